// Production against the paper to the letter (tests/reference): the objective's terms one by one, and the flood.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "embedding/evaluator.h"
#include "embedding/unfolding.h"
#include "reference/cases.h"
#include "reference/objective.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using reference::Case;
using reference::CollisionKind;
using reference::Flooded;
using reference::FloodKind;

/// The options under which the reference means what production means.
reference::ObjectiveOptions like_production(const Voxels& voxels) {
  return {FloodKind::kShortestWay, CollisionKind::kBeyondJoints, voxels.stride, voxels.spacing, Unfolding::kSamples};
}

/// Production's own segmentation of its last evaluation, in the reference's form.
std::vector<Flooded> flooded_by(const Evaluator& evaluator, const Voxels& voxels, const GridShape& shape) {
  std::vector<Flooded> flooded(shape.count());
  const Eigen::Vector3i low = voxels.first_sample / voxels.stride;
  for (int z = 0; z < voxels.size.z(); ++z)
    for (int y = 0; y < voxels.size.y(); ++y)
      for (int x = 0; x < voxels.size.x(); ++x) {
        const std::int32_t cell = evaluator.field()[std::size_t(voxels.cell(x, y, z))];
        if ((cell & kNoLabel) == kNoLabel) continue;
        flooded[shape.index(low + Eigen::Vector3i(x, y, z))] = {std::int16_t(cell & kNoLabel), cell >> kLabelBits};
      }
  return flooded;
}

bool planted(const std::vector<Flooded>& flooded) {
  return std::any_of(flooded.begin(), flooded.end(), [](const Flooded& f) { return f.bone >= 0; });
}

constexpr std::size_t kFew = 6000;  // voxels: with more, production's searches look at one boundary voxel in three or five

/// Calls `check(production's terms, pose, morphology, production's flood)` on random poses of a case.
template <class Check>
void for_random_poses(const Case& at, int count, const Check& check, std::size_t few = Voxels::kAlways) {
  const auto voxels = std::make_shared<const Voxels>(at.target, kMostVoxels, few);
  Evaluator evaluator(at.character, at.target, voxels, {});
  const reference::Objective letter(at.character, at.target, {}, like_production(*voxels));
  Random random(17);
  for (int round = 0; round < count; ++round) {
    SCOPED_TRACE(at.name + ", pose " + std::to_string(round));
    const Pose pose = reference::random_pose(at.character, random, 0.08);
    const Morphology morphology = reference::random_morphology(at.character, random);
    const ObjectiveTerms terms = evaluator(pose, morphology).terms;
    const std::vector<Flooded> flooded = flooded_by(evaluator, *voxels, letter.shape());
    if (planted(flooded)) check(letter, terms, pose, morphology, flooded);
    if (testing::Test::HasFatalFailure()) return;
  }
}

void expect_close(double a, double b, double relative, const char* what) {
  EXPECT_NEAR(a, b, relative * std::max({std::abs(a), std::abs(b), 1e-9})) << what;
}

// ---- the objective ----

TEST(ReferenceObjective, EachTermOfProductionAgreesToRoundingWhereDefinitionsAreEqual) {
  const ObjectiveWeights weights;
  for (const Case& at : reference::made_cases(20))
    for_random_poses(at, 334, [&](const auto& letter, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const ObjectiveTerms expected = letter.terms(pose, morphology, flooded);
      expect_close(terms.compact, expected.compact, 1e-9, "compact");
      expect_close(terms.skin, expected.skin, 1e-9, "skin");
      expect_close(terms.skeleton, expected.skeleton, 1e-9, "skeleton");
      expect_close(terms.protrude, expected.protrude, 1e-6, "protrude");
      expect_close(terms.limits, expected.limits, 1e-12, "limits");
      expect_close(terms.morphology, expected.morphology, 1e-12, "morphology");
      EXPECT_NEAR(terms.unfold, expected.unfold, 2.5 / Unfolding::kSamples);  // single precision: a sample between two voxels may go to the other
      expect_close(terms.total - weights.unfold * terms.unfold, expected.total - weights.unfold * expected.unfold, 1e-6, "total");
    });
}

TEST(ReferenceObjective, AFineGridIsSampledOnTheSameLatticeWithTheSameWeights) {
  for (const Case& at : reference::made_cases(72)) {
    EXPECT_EQ(Voxels(at.target).stride, 2);
    for_random_poses(at, 3, [](const auto& letter, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const ObjectiveTerms expected = letter.terms(pose, morphology, flooded);
      expect_close(terms.compact, expected.compact, 1e-9, "compact");
      expect_close(terms.skin, expected.skin, 1e-9, "skin");
    }, kFew);
  }
  const Case at = reference::made_cases(40)[1];
  EXPECT_EQ(Voxels(at.target, kMostVoxels, kFew).spacing, 5);
  for_random_poses(at, 5, [](const auto& letter, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
    const ObjectiveTerms expected = letter.terms(pose, morphology, flooded);
    expect_close(terms.compact, expected.compact, 1e-9, "compact");
    expect_close(terms.skin, expected.skin, 1e-9, "skin");
  }, kFew);
}

TEST(ReferenceObjective, OneVoxelInFiveTellsTheSumOverAllOfThem) {
  const Case at = reference::made_cases(40)[1];
  const reference::Objective all(at.character, at.target, {}, like_production(Voxels(at.target)));
  for_random_poses(at, 10, [&](const auto&, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
    const ObjectiveTerms expected = all.terms(pose, morphology, flooded);
    expect_close(terms.compact, expected.compact, 0.02, "compact");
    expect_close(terms.skin, expected.skin, 0.2, "skin");  // few samples: one voxel in five of a joint's interface
  }, kFew);
}

TEST(ReferenceObjective, AFewHundredSamplesTellWhatIsInTheWayOfAllVoxels) {
  double mean = 0;
  for (const Case& at : reference::made_cases(20)) {
    reference::ObjectiveOptions every = like_production(Voxels(at.target));
    every.unfolded = 0;
    const reference::Objective all(at.character, at.target, {}, every);
    for_random_poses(at, 10, [&](const auto&, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const double expected = all.terms(pose, morphology, flooded).unfold;
      EXPECT_NEAR(terms.unfold, expected, 0.1);
      mean += std::abs(terms.unfold - expected) / 30;
    });
  }
  EXPECT_LT(mean, 0.04);
}

TEST(ReferenceObjective, TheFloodGivesEveryVoxelTheBoneAndDistanceThatDijkstraGives) {
  for (const Case& at : reference::made_cases(24))
    for_random_poses(at, 20, [](const auto& letter, const ObjectiveTerms&, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const std::vector<Flooded> expected = letter.flood(pose, morphology);
      std::size_t other_bone = 0, other_distance = 0, inside = 0;
      for (std::size_t v = 0; v < expected.size(); ++v) {
        ASSERT_EQ(expected[v].bone < 0, flooded[v].bone < 0);
        if (expected[v].bone < 0) continue;
        ++inside;
        other_bone += expected[v].bone != flooded[v].bone;
        other_distance += std::abs(expected[v].distance - flooded[v].distance) > 1;
      }
      EXPECT_EQ(other_distance, 0u);
      // A start that rounds the other way (1/32 of a voxel) may hand over a tie.
      EXPECT_LE(double(other_bone), 0.001 * double(inside));
    });
}

TEST(ReferenceObjective, ThePapersFrontsReachEveryVoxelAndCountStepsOfTheFlood) {
  const Case at = reference::made_cases(24)[2];
  const reference::Objective letter(at.character, at.target, {});
  Random random(3);
  const Pose pose = reference::random_pose(at.character, random, 0.02);
  const Morphology morphology = Morphology::Ones(Eigen::Index(at.character.bones.size()));
  const std::vector<Flooded> flooded = letter.flood(pose, morphology);
  const GridShape& shape = letter.shape();
  for (const std::size_t v : at.target.inside) {
    ASSERT_GE(flooded[v].bone, 0);
    if (flooded[v].distance == 0) continue;
    bool follows = false;
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i n = shape.cell(v) + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (!shape.contains(n) || flooded[shape.index(n)].bone < 0) continue;
      ASSERT_GE(flooded[shape.index(n)].distance, flooded[v].distance - 1);
      follows |= flooded[shape.index(n)].distance == flooded[v].distance - 1 && flooded[shape.index(n)].bone == flooded[v].bone;
    }
    ASSERT_TRUE(follows);
  }
}

// The paper's fronts move by one voxel whatever the direction, so that they run 1.7 times faster along diagonals: parts differ from
// those by true ways. This is what is left in common.
TEST(ReferenceObjective, ThePapersFloodAndProductionsGiveMostVoxelsTheSameBone) {
  for (const Case& at : reference::made_cases(32)) {
    const reference::Objective paper(at.character, at.target, {});
    double same = 0, inside = 0;
    for_random_poses(at, 20, [&](const auto&, const ObjectiveTerms&, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const std::vector<Flooded> fronts = paper.flood(pose, morphology);
      for (const std::size_t v : at.target.inside) {
        same += fronts[v].bone == flooded[v].bone;
        ++inside;
      }
    });
    std::cout << "  " << at.name << ": same bone on " << 100 * same / inside << " % of voxels\n";
    EXPECT_GT(same / inside, 0.6) << at.name;
  }
}

TEST(ReferenceObjective, MovingLeastSquaresFindTheNormalOfAFlatInterface) {
  // Two bones end to end through a box, hinged about x: the interface is the plane between, and turning about an axis in it moves
  // its points along its normal, by their distance from the axis: Eq. 3 is a sum that can be done by hand.
  const Target target = reference::box({0.1, 0.25, 0.1}, 40);
  std::vector<ArmatureBone> bones{{"a", -1, {0, -0.2, 0}, {0, 0, 0}, Eigen::Matrix3d::Identity(), {}},
                                  {"b", 0, {0, 0, 0}, {0, 0.2, 0}, Eigen::Matrix3d::Identity(), {{0, -1, 0.5}}}};
  Character character = make_character(bones);
  for (Bone& bone : character.bones) bone.radius = 0.02;
  Pose pose{Eigen::Isometry3d::Identity(), Eigen::VectorXd::Zero(1)};
  pose.root.translation() = Vector3d(0, -0.2, 0);
  reference::ObjectiveOptions options;
  options.flood = FloodKind::kShortestWay;
  const double letter = reference::Objective(character, target, {}, options)(pose, Morphology::Ones(2)).skin;
  const double h = target.distance.shape.step;
  double expected = 0;
  for (int i = -8; i < 8; ++i)
    for (int k = -8; k < 8; ++k) {
      const double z = (k + 0.5) * h;   // velocity (1, 0, 0) x (x, 0, z) = (0, -z, 0); the normal to the parent is -y
      expected += std::max(-1 * z, 0.0) + std::max(0.5 * z, 0.0);
    }
  EXPECT_NEAR(letter, expected * std::pow(h / 0.01, 2), 1e-9);
}

TEST(ReferenceObjective, PlainEq4CountsNeighboursThatShareAJointAndProductionDoesNot) {
  // A short bone between two long ones, in a line: plain Eq. 4 has the long ones collide across it, at rest and for ever.
  const Target target = reference::box({0.1, 0.25, 0.1}, 24);
  const auto bone = [](const char* name, int parent, double from, double to) {
    return ArmatureBone{name, parent, {0, from, 0}, {0, to, 0}, Eigen::Matrix3d::Identity(), {{0, -2, 2}}};
  };
  std::vector<ArmatureBone> bones{bone("a", -1, 0, 0.1), bone("b", 0, 0.1, 0.12), bone("c", 1, 0.12, 0.22)};
  bones[0].hinges.clear();
  Character character = make_character(bones);
  for (Bone& b : character.bones) b.radius = 0.02;
  const Pose pose = rest_pose(character, Eigen::Isometry3d(Eigen::Translation3d(0, -0.1, 0)));
  const Morphology morphology = Morphology::Ones(3);
  reference::ObjectiveOptions beyond;
  beyond.collisions = CollisionKind::kBeyondJoints;
  EXPECT_NEAR(reference::Objective(character, target, {})(pose, morphology).skeleton, 0.02 * 0.02, 1e-12);
  EXPECT_EQ(reference::Objective(character, target, {}, beyond)(pose, morphology).skeleton, 0);
  EXPECT_EQ(Objective(character, target, {})(pose, morphology).skeleton, 0);
}

}  // namespace
}  // namespace transformables
