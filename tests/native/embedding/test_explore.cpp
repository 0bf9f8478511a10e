// Room embedding: several embeddings that differ.
#include "cases.h"

#include <algorithm>

#include "embedding/difference.h"

namespace transformables {
namespace {

EmbeddingOptions brief() {
  EmbeddingOptions options;
  options.runs = 1;
  options.starts = 3;
  options.evaluations = 300;
  return options;
}

Partition partition_of(Evaluator& evaluator, const Pose& pose, const Morphology& morphology) {
  evaluator(pose, morphology);
  Partition partition;
  evaluator.read_partition(partition);
  return partition;
}

TEST(Explore, GivesSolutionsThatDifferBestFirstEachWithItsTerms) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = armed();
  const ExploreOptions wanted{4, 0.15};
  const auto solutions = explore(character, target, brief(), wanted, {});
  ASSERT_EQ(solutions.size(), 4u);
  Evaluator evaluator = evaluator_of(character, target);
  const PartitionDifference difference(character, target, Voxels(target));
  for (std::size_t i = 0; i < solutions.size(); ++i) {
    const ObjectiveTerms again = Objective(character, target, {})(solutions[i].pose, solutions[i].morphology);
    EXPECT_EQ(again.total, solutions[i].terms.total);
    EXPECT_GE(solutions[i].value, solutions[i].terms.total);
    const Partition own = partition_of(evaluator, solutions[i].pose, solutions[i].morphology);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE(solutions[i].value, solutions[j].value);
      EXPECT_GE(difference(own, partition_of(evaluator, solutions[j].pose, solutions[j].morphology)), 0.15);
    }
  }
}

TEST(Explore, IsTheSameForAnyNumberOfThreads) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(4, 0.12, 0.018, {0, -2, 2});
  EmbeddingOptions options = brief();
  options.threads = 1;
  const auto one = explore(character, target, options, {3, 0.1}, {});
  options.threads = 3;
  const auto three = explore(character, target, options, {3, 0.1}, {});
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].pose.angles, three[i].pose.angles);
    EXPECT_EQ(one[i].pose.root.matrix(), three[i].pose.root.matrix());
    EXPECT_EQ(one[i].morphology, three[i].morphology);
  }
}

TEST(Explore, TellsOfEachSolutionThatItReturns) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(4, 0.12, 0.018, {0, -2, 2});
  std::vector<Embedding> told;
  const auto solutions = explore(character, target, brief(), {3, 0.1}, {}, [&](const Embedding& e) { told.push_back(e); });
  EXPECT_GE(told.size(), solutions.size());
  EXPECT_TRUE(std::any_of(told.begin(), told.end(), [&](const Embedding& e) { return e.pose.angles == solutions[0].pose.angles; }));
}

TEST(Explore, ForOneGivesWhatEmbedGives) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(4, 0.12, 0.018, {0, -2, 2});
  const auto solutions = explore(character, target, brief(), {1, 0.15}, {});
  ASSERT_EQ(solutions.size(), 1u);
  EXPECT_EQ(solutions[0].pose.angles, embed(character, target, brief(), {}).pose.angles);
}

TEST(Explore, StopsWhenAsked) {
  const Target target = box_target({0.25, 0.2, 0.15});
  int ticks = 0;
  const Progress progress{[&](double fraction, std::string_view) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    return ++ticks < 60;
  }};
  EXPECT_THROW(explore(armed(), target, {}, {}, progress), Cancelled);
  EXPECT_EQ(ticks, 60) << "it does not go on to where it would ask again";
}

TEST(Explore, RefusesOptionsOutOfRange) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  EXPECT_THROW(explore(armed(), target, brief(), {0, 0.15}, {}), InvalidInput);
  EXPECT_THROW(explore(armed(), target, brief(), {101, 0.15}, {}), InvalidInput);
  EXPECT_THROW(explore(armed(), target, brief(), {2, -0.1}, {}), InvalidInput);
  EXPECT_THROW(explore(armed(), target, brief(), {2, 1.5}, {}), InvalidInput);
  EmbeddingOptions options = brief();
  options.runs = 0;
  EXPECT_THROW(explore(armed(), target, options, {2, 0.15}, {}), InvalidInput);
}

TEST(PartitionDifference, IsTheShareOfVoxelsThatChangeBone) {
  // Two bones end to end in a box: the border is the plane between them, so moving both by a tenth moves a tenth of the voxels.
  const Target target = box_target({0.1, 0.25, 0.1}, 40);
  const Character character = chain(2, 0.2, 0.02);
  Evaluator evaluator = evaluator_of(character, target);
  const PartitionDifference difference(character, target, Voxels(target));
  const Partition middle = partition_of(evaluator, pose_at(character, {0, -0.2, 0}), unscaled(character));
  const Partition above = partition_of(evaluator, pose_at(character, {0, -0.15, 0}), unscaled(character));
  EXPECT_EQ(difference(middle, middle), 0);
  EXPECT_NEAR(difference(middle, above), 0.1, 0.03);
  EXPECT_EQ(difference(middle, above), difference(above, middle));
}

TEST(PartitionDifference, CountsMirrorImagesAsEqual) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = armed();
  Pose left = pose_at(character, {0.03, -0.1, 0}), right = left;
  right.root.translation().x() = -0.03;
  left.angles.setRandom();
  right.angles = mirrored_angles(character, left.angles);
  Evaluator evaluator = evaluator_of(character, target);
  const Partition a = partition_of(evaluator, left, unscaled(character)), b = partition_of(evaluator, right, unscaled(character));
  EXPECT_LT(PartitionDifference(character, target, Voxels(target))(a, b), 0.03) << "ties aside";
  Character lopsided = character;
  lopsided.mirrored = false;
  EXPECT_GT(PartitionDifference(lopsided, target, Voxels(target))(a, b), 0.2);
}

}  // namespace
}  // namespace transformables
