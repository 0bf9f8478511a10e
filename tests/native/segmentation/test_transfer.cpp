#include <gtest/gtest.h>

#include "segmentation/cases.h"

namespace transformables {
namespace {

using namespace cases;

constexpr double kThickness = 0.08;   // half of it, of the box of two halves

Target bar() { return box_target({0.25, 0.12, kThickness}, 64); }

TransferResult transferred(const Posed& posed, const Target& target, double angle, TransferOptions options, Segmentation* after = nullptr) {
  std::vector<TransferResult> results;
  const Segmentation s = transfer(cut_in_halves(posed, target), posed.character, target, posed.embedding, {{1, 0, 0, angle}}, options, {}, &results);
  if (after) *after = s;
  return results.at(0);
}

TEST(Transfer, FindsTheRadiusOfAHingeInTheMiddle) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0);
  TransferOptions options;
  options.method = TransferMethod::kCylinder;
  // Beyond b / cos(angle / 2) the two halves' arcs leave room for the turn.
  for (double angle : {M_PI / 2, -M_PI / 2, 1.2}) {
    const double expected = kThickness / std::cos(angle / 2);
    EXPECT_NEAR(transferred(posed, target, angle, options).radius, expected, 2 * target.distance.shape.step) << angle;
  }
}

TEST(Transfer, IsNotNeededWhenTheHingeSitsOnTheEdgeThatOpens) {
  const Target target = bar();
  const double h = target.distance.shape.step;
  const Posed posed = half_boxes(target, kThickness - 0.5 * h);
  const TransferResult opens = transferred(posed, target, -M_PI / 2, {});
  EXPECT_EQ(opens.radius, 0);
  EXPECT_EQ(opens.moved_volume, 0);
  EXPECT_LT(opens.left_overlap, 1e-4 * target.volume);
  EXPECT_GT(transferred(posed, target, 0.5, {}).moved_volume, 0) << "the other way it closes";
}

TEST(Transfer, WithoutRoundingMakesRoomToo) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0);
  TransferOptions rough;
  rough.round_off = false;
  Segmentation after;
  const TransferResult result = transferred(posed, target, M_PI / 2, rough, &after), whole = transferred(posed, target, M_PI / 2, {});
  expect_tiling(after, posed, target);
  EXPECT_NEAR(result.moved_volume, whole.moved_volume, 0.01 * target.volume);
  EXPECT_LT(result.left_overlap, 0.01 * target.volume);
  EXPECT_LT(whole.left_overlap, result.left_overlap) << "that is what rounding is for";
}

TEST(Transfer, LowersTheOverlapAndMovesNoVolumeOutOfTheTarget) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0);
  for (TransferMethod method : {TransferMethod::kCylinder, TransferMethod::kExact, TransferMethod::kBetter})
    for (TransferDirection direction : {TransferDirection::kChildToParent, TransferDirection::kParentToChild, TransferDirection::kLessVolume}) {
      TransferOptions options;
      options.method = method;
      options.direction = direction;
      Segmentation after;
      const TransferResult result = transferred(posed, target, M_PI / 2, options, &after);
      expect_tiling(after, posed, target);
      EXPECT_GT(result.moved_volume, 0);
      // Without a transfer, half a square of the half thickness is in the way on average.
      const double before = 0.5 * kThickness * kThickness * 0.24;
      EXPECT_LT(result.left_overlap, 0.25 * before);
      if (direction == TransferDirection::kChildToParent) {
        EXPECT_TRUE(result.child_to_parent);
      }
      if (direction == TransferDirection::kParentToChild) {
        EXPECT_FALSE(result.child_to_parent);
      }
    }
}

TEST(Transfer, GoesTheWayThatIsAskedOfASingleJoint) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0.3 * kThickness);
  for (TransferDirection wanted : {TransferDirection::kChildToParent, TransferDirection::kParentToChild}) {
    std::vector<TransferResult> results;
    TransferOptions options;
    options.direction_of = {{1, wanted}};
    const Segmentation after = transfer(cut_in_halves(posed, target), posed.character, target, posed.embedding, {{1, 0, 0, M_PI / 2}}, options, {}, &results);
    expect_tiling(after, posed, target);
    EXPECT_GT(results.at(0).moved_volume, 0);
    EXPECT_EQ(results[0].child_to_parent, wanted == TransferDirection::kChildToParent);
  }
}

TEST(Transfer, MovesNoMoreByTheExactWayThanByTheCylinder) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0.4 * kThickness);
  TransferOptions cylinder, exact;
  cylinder.method = TransferMethod::kCylinder;
  exact.method = TransferMethod::kExact;
  EXPECT_LT(transferred(posed, target, M_PI / 2, exact).moved_volume, 1.1 * transferred(posed, target, M_PI / 2, cylinder).moved_volume);
}

TEST(Transfer, UsesASphereForABallJoint) {
  const Target target = bar();
  std::vector<ArmatureBone> bones{bone("left", -1, {-0.2, 0, 0}, {0, 0, 0}, Vector3d::UnitY()), bone("right", 0, {0, 0, 0}, {0.2, 0, 0}, Vector3d::UnitY())};
  bones[1].hinges = {{0, -2, 2}, {2, -2, 2}};
  const Posed posed = as_given(bones, target);
  std::vector<TransferResult> results;
  TransferOptions options;
  options.direction = TransferDirection::kChildToParent;
  const Segmentation before = cut_in_halves(posed, target);
  const Segmentation after = transfer(before, posed.character, target, posed.embedding, {{1, 0, 0, 0.8}, {1, 1, 0, 0.4}}, options, {}, &results);
  expect_tiling(after, posed, target);
  ASSERT_GT(results.at(0).radius, 0);
  for (std::size_t i : target.inside)
    if (before.owner[i] != after.owner[i]) {
      ASSERT_LT(before.shape.position(i).norm(), results[0].radius + 3 * before.shape.step);
    }
}

TEST(Transfer, KeepsATilingForRandomPosesAndIsTheSameForAnyThreads) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    std::vector<JointRange> ranges;
    for (int b = 1; b < int(posed.character.bones.size()); ++b) ranges.push_back({b, 0, 0, b % 2 ? 1.5 : -1.2});
    TransferOptions one, two;
    one.threads = 1, two.threads = 2;
    const Segmentation s = grown(posed, target);
    std::vector<TransferResult> results;
    const Segmentation after = transfer(s, posed.character, target, posed.embedding, ranges, one, {}, &results);
    EXPECT_EQ(results.size(), ranges.size());
    expect_tiling(after, posed, target);
    EXPECT_EQ(after.owner, transfer(s, posed.character, target, posed.embedding, ranges, two, {}).owner);
  }
}

TEST(Transfer, RefusesBadRangesAndOptionsAndStopsWhenAsked) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32);
  const Posed posed = half_boxes(target, 0);
  const Segmentation s = cut_in_halves(posed, target);
  const auto with = [&](JointRange range, TransferOptions options = {}) {
    return transfer(s, posed.character, target, posed.embedding, {range}, options, {});
  };
  EXPECT_THROW(with({0, 0, 0, 1}), InvalidInput);
  EXPECT_THROW(with({2, 0, 0, 1}), InvalidInput);
  EXPECT_THROW(with({1, 1, 0, 1}), InvalidInput);
  EXPECT_THROW(with({1, 0, 0, NAN}), InvalidInput);
  TransferOptions few;
  few.samples = 1;
  EXPECT_THROW(with({1, 0, 0, 1}, few), InvalidInput);
  for (int nobody : {0, 2}) {
    TransferOptions directed;
    directed.direction_of = {{nobody, TransferDirection::kChildToParent}};
    EXPECT_THROW(with({1, 0, 0, 1}, directed), InvalidInput);
  }
  TransferOptions threads;
  threads.threads = -1;
  EXPECT_THROW(with({1, 0, 0, 1}, threads), InvalidInput);
  EXPECT_THROW(transfer(s, posed.character, sphere_target(16), posed.embedding, {{1, 0, 0, 1}}, {}, {}), InvalidInput);
  const Progress stop{[](double, std::string_view) { return false; }};
  EXPECT_THROW(transfer(s, posed.character, target, posed.embedding, {{1, 0, 0, 1}}, {}, stop), Cancelled);
}

}  // namespace
}  // namespace transformables
