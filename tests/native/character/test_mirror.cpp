// Which bone is the mirror image of which, and what angles mirror a pose.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cases.h"
#include "common/error.h"

namespace transformables {
namespace {

// ---- mirrors

/// Ends of all segments, reflected or not.
std::vector<Segment> placed_segments(const Character& c, const std::vector<Isometry3d>& frames, int i, const Morphology& m) {
  std::vector<Segment> result;
  for (const Segment& s : skeleton_of(c.bones[i], m[i])) result.push_back(transformed(frames[i], s));
  return result;
}

void expect_mirror_images(const Character& c, Dice& dice) {
  ASSERT_TRUE(c.mirrored);
  Morphology m = random_morphology(c, dice);
  for (std::size_t i = 0; i < c.bones.size(); ++i) m[c.bones[i].mirror] = m[i];
  Pose pose = random_pose(c, dice), other = pose;
  pose.root = other.root = c.root_rest;
  other.angles = mirrored_angles(c, pose.angles);
  EXPECT_LT((mirrored_angles(c, other.angles) - pose.angles).norm(), 1e-15);
  const auto frames = forward_kinematics(c, pose, m), images = forward_kinematics(c, other, m);
  const auto reflected = [&](const Vector3d& p) { return Vector3d(2 * c.mirror_x - p.x(), p.y(), p.z()); };
  for (int i = 0; i < int(c.bones.size()); ++i) {
    const int j = c.bones[i].mirror;
    EXPECT_LT((reflected(frames[i].translation()) - images[j].translation()).norm(), 1e-9) << c.bones[i].name;
    const auto from = placed_segments(c, frames, i, m), to = placed_segments(c, images, j, m);
    for (const Segment& s : from)
      EXPECT_TRUE(std::any_of(to.begin(), to.end(), [&](const Segment& t) {
        return (reflected(s.a) - t.a).norm() < 1e-9 && (reflected(s.b) - t.b).norm() < 1e-9;
      })) << c.bones[i].name;
  }
}

TEST(Mirror, MirroredAnglesPutEveryBoneAtItsMirrorImage) {
  Dice dice(15);
  for (const auto& bones : {walker(), walker(false), walker(true, {7, 1, -2})}) {
    const Character c = make_character(bones);
    for (int n = 0; n < 10; ++n) expect_mirror_images(c, dice);
    for (int n = 0; n < 3; ++n) expect_mirror_images(fitted(c, 0.03, 0.5, 0.01), dice);
  }
}

TEST(Mirror, SidesAndBonesInThePlaneAreFoundByNameAndByGeometryAlike) {
  for (const bool named : {true, false}) {
    const Character c = make_character(walker(named));
    ASSERT_TRUE(c.mirrored);
    std::map<std::string, int> index;
    for (int i = 0; i < int(c.bones.size()); ++i) index[c.bones[i].name] = i;
    const std::string l = named ? ".L" : "a", r = named ? ".R" : "b";
    EXPECT_EQ(c.bones[index["chest"]].mirror, index["chest"]);
    EXPECT_EQ(c.bones[index["thigh" + l]].mirror, index["thigh" + r]);
    EXPECT_EQ(c.bones[index["shin" + r]].mirror, index["shin" + l]);
  }
}

TEST(Mirror, GeometryOverrulesNamesThatLie) {
  auto bones = walker();
  std::swap(bones[4].name, bones[3].name);  // thigh and shin of the left exchange names
  const Character c = make_character(bones);
  EXPECT_TRUE(c.mirrored);
  Dice dice(16);
  expect_mirror_images(c, dice);
}

TEST(Mirror, LimbsThatStartAtOnePointOfThePlaneAreToldApart) {
  std::vector<ArmatureBone> bones{bone("root", -1, {0, 0, 0}, {0, 0, 1}, {}, {1, 0, 0})};
  for (const double s : {1.0, -1.0}) {
    const int ball = int(bones.size());
    bones.push_back({"ball" + std::to_string(ball), 0, {0, 0, 1}, {0, 0.1, 1}, Matrix3d::Identity(), {hinge(0)}});
    bones.push_back(bone("limb" + std::to_string(ball), ball, {0, 0, 1}, {s, 0, 2}, {hinge(0)}, {0, 1, 0}));
  }
  const Character c = make_character(bones);
  ASSERT_TRUE(c.mirrored);
  EXPECT_EQ(c.bones[1].mirror, 3);
  EXPECT_EQ(c.bones[2].mirror, 4);
  Dice dice(17);
  expect_mirror_images(c, dice);
}

TEST(Mirror, ABoneThatIsMovedTurnedOrLimitedDifferentlyHasNoImage) {
  auto moved = walker(), turned = walker(), limited = walker(), missing = walker(), hinged = walker();
  moved[4].tail.y() += 0.05;
  turned[4].axes = turned[4].axes * Eigen::AngleAxisd(0.2, Vector3d::UnitY()).toRotationMatrix();
  limited[4].hinges[0].max_rad += 0.1;
  missing.pop_back();
  hinged[4].hinges.pop_back();
  for (const auto& bones : {moved, turned, limited, missing, hinged}) {
    const Character c = make_character(bones);
    EXPECT_FALSE(c.mirrored);
    EXPECT_EQ(c.bones[0].mirror, 0);
    EXPECT_EQ(c.bones[4].mirror, -1);
    EXPECT_THROW(mirrored_angles(c, Eigen::VectorXd::Zero(c.angle_count)), InvalidInput);
  }
}

TEST(Mirror, ALimbWhoseParentHasNoImageHasNone) {
  auto bones = walker();
  bones[3].hinges[0].max_rad += 0.3;  // a thigh
  const Character c = make_character(bones);
  for (const int i : {3, 4, 5, 6}) EXPECT_EQ(c.bones[i].mirror, -1);
  EXPECT_EQ(c.bones[1].mirror, 1);
}

TEST(Mirror, ADeviationBelowATenthOfAPercentIsForgiven) {
  auto bones = walker();
  bones[4].tail.y() += 1e-4;
  EXPECT_TRUE(make_character(bones).mirrored);
}

TEST(Mirror, MirroredAnglesWantsAllAngles) {
  const Character c = make_character(walker());
  EXPECT_THROW(mirrored_angles(c, Eigen::VectorXd::Zero(1)), InvalidInput);
}

}  // namespace
}  // namespace transformables
