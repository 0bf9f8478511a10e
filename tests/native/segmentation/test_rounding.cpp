#include <gtest/gtest.h>

#include "segmentation/cases.h"
#include "segmentation/joint.h"
#include "segmentation/overlaps.h"

namespace transformables {
namespace {

using namespace cases;

constexpr double kRadius = 0.1, kTurn = 1;

// The right half of a bar turns about a drum of the left one, whose rim is rough by up to 0.4 steps.
Segmentation rough_drum(const Posed& posed, const Target& target) {
  Segmentation s = cut_in_halves(posed, target);
  const double h = s.shape.step;
  for (std::size_t i = 0; i < s.shape.count(); ++i) {
    const Vector3d p = s.shape.position(i);
    const double rough = 0.4 * h * std::sin(9 * std::atan2(p.z(), p.x())) * std::cos(p.y() / (2 * h));
    const double to_left = std::clamp(std::min(p.x(), std::hypot(p.x(), p.z()) - kRadius + rough), -3 * h, 3 * h);
    s.phi[0][i] = float(to_left), s.phi[1][i] = float(-to_left);
    if (s.owner[i] >= 0) s.owner[i] = to_left > 0;
  }
  return s;
}

// But for the child's own bone, which runs through the drum to the hinge.
double overlap(const Segmentation& s, const Posed& posed, const Target& target, const std::vector<JointRange>& ranges) {
  const auto joints = segmentation_inner::joints_of(posed.character, posed.embedding, ranges, 50);
  return overlap_on_the_way(s, target, joints.at(0), 0.8 * kRadius).whole;
}

TEST(Rounding, MakesPartsThatSlideFitAtEveryAngle) {
  const Target target = box_target({0.25, 0.12, 0.08}, 64);
  const Posed posed = half_boxes(target, 0);
  const Segmentation before = rough_drum(posed, target);
  for (const std::vector<JointRange>& ranges : {std::vector<JointRange>{{1, 0, 0, kTurn}}, {{1, 0, 0, -kTurn}}, {{1, 0, -kTurn / 2, kTurn / 2}}}) {
    const Segmentation after = rounded(before, posed.character, target, posed.embedding, ranges, 0);
    expect_tiling(after, posed, target);
    const double was = overlap(before, posed, target, ranges), is = overlap(after, posed, target, ranges);
    EXPECT_GT(was, 5e-4);
    EXPECT_LT(is, 6e-5);
    EXPECT_LT(is, 0.1 * was);
    for (std::size_t i : target.inside)
      if (before.owner[i] != after.owner[i] && std::abs(before.shape.position(i).z()) > 0.02) {
        ASSERT_NEAR(std::hypot(before.shape.position(i).x(), before.shape.position(i).z()), kRadius, before.shape.step);
      }
  }
}

// A joint that turns by less than a sample on most circles: nothing that is told by samples alone is in the way.
TEST(Rounding, PartsThinLayersOfAJointThatHardlyTurns) {
  const Target target = box_target({0.25, 0.12, 0.08}, 64);
  const Posed posed = half_boxes(target, 0);
  Segmentation before = rough_drum(posed, target);
  for (double angle : {0.06, -0.06}) {
    const std::vector<JointRange> ranges{{1, 0, 0, angle}};
    const Segmentation after = rounded(before, posed.character, target, posed.embedding, ranges, 0);
    expect_tiling(after, posed, target);
    const double was = overlap(before, posed, target, ranges), is = overlap(after, posed, target, ranges);
    EXPECT_GT(was, 1e-4) << angle;
    EXPECT_LT(is, 6e-5) << angle << ", " << was;
  }
}

TEST(Rounding, LeavesInterfacesThatOpenAsTheyAre) {
  const Target target = box_target({0.25, 0.12, 0.08}, 48);
  const Posed posed = half_boxes(target, 0.08 - 0.5 * target.distance.shape.step);
  const Segmentation before = cut_in_halves(posed, target);
  EXPECT_EQ(rounded(before, posed.character, target, posed.embedding, {{1, 0, 0, -kTurn}}, 0).owner, before.owner);
}

TEST(Rounding, LeavesWhatAnArtistDecidedAndIsTheSameForAnyThreads) {
  const Target target = box_target({0.25, 0.12, 0.08}, 48);
  const Posed posed = half_boxes(target, 0);
  Segmentation before = rough_drum(posed, target);
  const auto changed = [&](int threads) { return rounded(before, posed.character, target, posed.embedding, {{1, 0, 0, kTurn}}, threads); };
  const Segmentation after = changed(1);
  EXPECT_EQ(after.owner, changed(2).owner);
  std::size_t given[2] = {0, 0};
  for (std::size_t i : target.inside)
    if (before.owner[i] != after.owner[i]) ++given[after.owner[i]];
  EXPECT_GT(given[0], 20u);
  EXPECT_GT(given[1], 20u);
  before.inhibited = {1, 0};
  const Segmentation inhibited = changed(0);
  for (std::size_t i : target.inside)
    if (before.owner[i] == 1) {
      ASSERT_EQ(inhibited.owner[i], 1);
    }
  before.inhibited.clear();
  before.pinned.assign(before.owner.size(), 1);
  EXPECT_EQ(changed(0).owner, before.owner);
}

TEST(Rounding, RefusesWhatDoesNotFit) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32);
  const Posed posed = half_boxes(target, 0);
  const Segmentation s = cut_in_halves(posed, target);
  EXPECT_THROW(rounded(s, posed.character, target, posed.embedding, {{1, 0, 0, 1}}, -1), InvalidInput);
  EXPECT_THROW(rounded(s, posed.character, target, posed.embedding, {{2, 0, 0, 1}}, 0), InvalidInput);
  EXPECT_THROW(rounded(s, posed.character, target, posed.embedding, {{1, 0, 0, NAN}}, 0), InvalidInput);
  EXPECT_THROW(rounded(s, posed.character, sphere_target(16), posed.embedding, {{1, 0, 0, 1}}, 0), InvalidInput);
}

}  // namespace
}  // namespace transformables
