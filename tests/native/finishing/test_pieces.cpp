// What is left of parts in pieces, in hollows, or not at all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "cases.h"
#include "finishing/finishing.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

TEST(Finish, PiecesCutOffAreDroppedAndReported) {
  Design d = halves();
  // A second blob of the root, cut off from it by the child.
  const auto blob = [](const Vector3d& p) { return std::min(p.y(), 0.2 - p.y()); };
  d = beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.15, 0), bone("child", 0, 0, 0.15)}, 0.012,
           {blob, [=](const Vector3d& p) { return -blob(p); }});
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  for (const Part& part : parts.parts) expect_good(part.mesh);
  ASSERT_FALSE(parts.warnings.empty());
  EXPECT_NE(parts.warnings[0].find("root"), std::string::npos);
}

TEST(Finish, AnEnclosedPartIsGivenUpByNameAndItsRoomFilled) {
  const auto ball = [](const Vector3d& p) { return (p - Vector3d(0, 0.1, 0)).norm() - 0.05; };
  const Design d = beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.15, 0), bone("yolk", 0, 0.09, 0.11)}, 0.01,
                        {[=](const Vector3d& p) { return -ball(p); }, ball});
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 1u);
  expect_good(parts.parts[0].mesh);
  EXPECT_GT(parts.filled_volume_pct, 99);
  ASSERT_FALSE(parts.warnings.empty());
  EXPECT_NE(parts.warnings[0].find("yolk"), std::string::npos);
}

TEST(Finish, TheCrossOfAUniversalJointMayBeLostAndThatIsTold) {
  // A bone between two others, of which the joints' balls leave nothing.
  const auto ball = [](const Vector3d& p) { return p.norm() - 0.004; };
  Design d = beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.15, 0), bone("cross", 0, 0, 0), bone("child", 1, 0, 0.15)}, 0.012,
                  {[=](const Vector3d& p) { return std::max(p.y(), -ball(p)); }, ball, [=](const Vector3d& p) { return std::max(-p.y(), -ball(p)); }});
  d.turn(1, 0.3);
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  EXPECT_THAT(parts.warnings, testing::Contains(testing::HasSubstr("'cross': its joint and the next are at one place")));
}

/// A bone that lies in another one's skeleton, so that its part is only a ball at the target's surface.
Design with_helper(double radius) {
  const auto ball = [=](const Vector3d& p) { return (p - kLongestSide / 32 * Vector3d(5, 3, 0)).norm() - radius; };
  return beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.15, 0), bone("helper", 0, 0, 0.1), bone("child", 0, 0, 0.15)}, 0.012,
              {[](const Vector3d& p) { return p.y(); }, ball, [=](const Vector3d& p) { return std::max(-p.y(), -ball(p)); }});
}

TEST(Finish, APartOfWhichOnlyASpeckIsLeftIsToldByName) {
  const auto speck = testing::Contains(testing::HasSubstr("Only a speck is left of the part of bone 'helper'"));
  const Parts large = with_helper(0.05).finished(), small = with_helper(0.012).finished();
  ASSERT_EQ(large.parts.size(), 3u);
  ASSERT_EQ(small.parts.size(), 3u);
  EXPECT_THAT(large.warnings, testing::Not(speck));
  EXPECT_THAT(small.warnings, speck);
}

TEST(Finish, AVoidInTheSegmentationBecomesNoHollow) {
  Design d = halves();
  for (std::size_t n = 0; n < d.segmentation.shape.count(); ++n)
    if ((d.segmentation.shape.position(n) - Vector3d(0.04, 0.18, 0)).norm() < 0.03) d.segmentation.phi[1][n] = 0.05f;
  const Parts parts = d.finished();
  for (const Part& part : parts.parts) expect_good(part.mesh);
  EXPECT_GT(parts.filled_volume_pct, 97);
}

TEST(Finish, ABoneWithoutASkinKeepsItsSkeleton) {
  Design d = halves();
  d.segmentation.phi[1] = {};
  for (float& v : d.segmentation.phi[0].values) v = -0.05f;
  d.turn(0, 0.5);
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  EXPECT_TRUE(parts.collisions.empty());
  EXPECT_GT(parts.parts[1].volume, 0.1 * std::numbers::pi * 0.012 * 0.012);
}

}  // namespace
}  // namespace transformables
