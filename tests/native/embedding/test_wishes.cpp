// Room embedding: what an artist wants of a search. Bones that are locked, pinned or kept in proportion, and regions that are painted.
#include "cases.h"

#include <algorithm>

namespace transformables {
namespace {

TEST(Embed, GoesRoundWhatIsLockedPinnedAndKeptInProportion) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(4, 0.12, 0.018, {0, -2, 2});
  EmbeddingOptions options = quick();
  options.evaluations = 300;
  options.locked = {{1, 0.5}};
  options.proportion_of = {{2, 1, 1}};
  PinnedBone pin{3, Eigen::Isometry3d::Identity()};
  pin.frame.translation() = Vector3d(0.1, -0.05, 0.02);
  options.pinned = {pin};
  const Embedding e = embed(character, target, options, {});
  EXPECT_EQ(e.pose.angles[1], 0.5);
  EXPECT_EQ(e.morphology[2], 1);
  EXPECT_LT((forward_kinematics(character, e.pose, e.morphology)[3].matrix() - pin.frame.matrix()).norm(), 1e-9);
}

TEST(Embed, HoldsASecondPinClosely) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(5, 0.1, 0.015, {0, -2, 2});
  Pose pose = pose_at(character, {0, -0.1, -0.05});
  pose.angles << 1.5, -1.5, -1.5, 1.5;
  const auto frames = forward_kinematics(character, pose, unscaled(character));
  EmbeddingOptions options = quick();
  options.pinned = {{0, frames[0]}, {4, frames[4]}};
  Embedding start;
  start.pose = pose;
  start.morphology = unscaled(character);
  const Embedding e = embed(character, target, options, {}, start);
  const auto after = forward_kinematics(character, e.pose, e.morphology);
  EXPECT_LT((after[4].translation() - frames[4].translation()).norm(), 0.1 * target.distance.shape.step);
}

// The upper half of the end of a box at its largest x.
PaintedRegion end_of_box(const Vector3d& half, int bone) {
  const Vector3d a(half.x(), -half.y(), 0), b(half.x(), half.y(), 0), c = half, d(half.x(), -half.y(), half.z());
  return {bone, {{a, b, c}, {a, c, d}}};
}

// Share of the voxels right under it that each bone gets.
std::vector<double> shares_at_end(const Character& character, const Target& target, const Embedding& e) {
  Objective objective(character, target, {});
  objective(e.pose, e.morphology);
  std::vector<double> share(character.bones.size(), 0);
  double all = 0;
  for (const std::size_t i : target.inside) {
    const Vector3d p = target.distance.shape.position(i);
    if (p.z() > 0 && p.x() > 0.25 - 1.5 * target.distance.shape.step) ++share[std::size_t(objective.labels()[i])], ++all;
  }
  for (double& s : share) s /= all;
  return share;
}

TEST(Embed, BringsTheNamedBoneToAPaintedRegion) {
  const Vector3d half(0.25, 0.1, 0.1);
  const Target target = box_target(half, 24);
  const Character character = chain(4, 0.12, 0.018, {0, -2, 2});
  EmbeddingOptions options = quick();
  const std::vector<double> free = shares_at_end(character, target, embed(character, target, options, {}));
  int brought = 0;
  for (int bone = 0; bone < 4; ++bone) {
    SCOPED_TRACE(bone);
    options.painted = {end_of_box(half, bone)};
    const Embedding e = embed(character, target, options, {});
    EXPECT_GT(shares_at_end(character, target, e)[std::size_t(bone)], 0.65);
    EXPECT_LT(e.missed, target.distance.shape.step);
    EXPECT_LT(e.deepest_protrusion, 0.1 * target.distance.shape.step);
    EXPECT_LT(e.deepest_collision, 0.1 * target.distance.shape.step);
    brought += free[std::size_t(bone)] < 0.3;
  }
  EXPECT_GE(brought, 2) << "of which most were not there by themselves";
}

TEST(Embed, BringsAnyOneBoneToARegionThatIsToBeKeptWhole) {
  const Vector3d half(0.25, 0.1, 0.1);
  const Target target = box_target(half, 24);
  const Character character = chain(6, 0.08, 0.015, {0, -2, 2});
  int divided = 0;
  for (const std::uint64_t seed : {0, 1, 2, 3}) {
    SCOPED_TRACE(seed);
    EmbeddingOptions options = quick();
    options.seed = seed;
    const Embedding free = embed(character, target, options, {});
    EXPECT_EQ(free.missed, 0) << "nothing was asked for";
    options.painted = {end_of_box(half, -1)};
    const Embedding whole = embed(character, target, options, {});
    options.evaluations = 1;
    const Embedding unasked = embed(character, target, options, {}, free);  // the same pose, now measured by what is asked
    EXPECT_LT(whole.missed, 0.7 * unasked.missed);
    const std::vector<double> before = shares_at_end(character, target, free), after = shares_at_end(character, target, whole);
    EXPECT_GT(*std::max_element(after.begin(), after.end()), 0.85);
    divided += *std::max_element(before.begin(), before.end()) < 0.75;
  }
  EXPECT_GE(divided, 2) << "of which some were divided by themselves";
}

TEST(Embed, IsNotChangedByARegionWithoutArea) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(3, 0.12, 0.018);
  EmbeddingOptions options = quick();
  options.evaluations = 100;
  const Embedding plain = embed(character, target, options, {});
  options.painted = {{1, {}}, {0, {{Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitX()}}}};
  const Embedding e = embed(character, target, options, {});
  EXPECT_EQ(e.pose.angles, plain.pose.angles);
  EXPECT_EQ(e.value, plain.value);
}

}  // namespace
}  // namespace transformables
