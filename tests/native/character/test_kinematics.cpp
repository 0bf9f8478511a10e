// The uniform fit, and where poses put bones.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cases.h"
#include "common/error.h"

namespace transformables {
namespace {

// ---- fit

TEST(Fitted, LengthsAreAsTheDoorSays) {
  const Character c = make_character(walker());
  const double volume = 0.03, longest_side = 0.5, edge = std::cbrt(volume / double(c.bones.size()));
  const Character f = fitted(c, volume, longest_side, 0.001);
  double sum = 0, longest = 0;
  for (const Bone& b : f.bones)
    for (const Segment& s : b.segments) {
      sum += (s.b - s.a).norm();
      longest = std::max(longest, (s.b - s.a).norm());
    }
  const double mean = sum / double(c.bones.size());
  EXPECT_LT(longest, 0.6 * longest_side + 1e-12);
  EXPECT_LT(mean, 1.3 * edge + 1e-12);
  EXPECT_TRUE(std::abs(longest - 0.6 * longest_side) < 1e-9 || std::abs(mean - 1.3 * edge) < 1e-9);
  for (const Bone& b : f.bones) EXPECT_NEAR(b.radius, 0.1 * edge, 1e-12);
  for (const Bone& b : fitted(c, volume, longest_side, 0.02).bones) EXPECT_EQ(b.radius, 0.02);
}

TEST(Fitted, EveryPointOfTheCharacterFrameIsScaledAlikeAndAnglesMeanTheSame) {
  Dice dice(11);
  const Character c = make_character(walker(true, {2, 0, 0})), f = fitted(c, 0.03, 0.5, 0.01, 0.25);
  EXPECT_EQ(f.scale, 0.25);
  EXPECT_NEAR(f.mirror_x, 0.5, 1e-12);
  Pose pose = random_pose(c, dice), small = pose;
  pose.root = c.root_rest, small.root = f.root_rest;
  const Morphology m = random_morphology(c, dice);
  const auto big = forward_kinematics(c, pose, m), little = forward_kinematics(f, small, m);
  for (std::size_t i = 0; i < big.size(); ++i)
    for (std::size_t k = 0; k < c.bones[i].segments.size(); ++k)
      EXPECT_LT((0.25 * (big[i] * c.bones[i].segments[k].b) - little[i] * f.bones[i].segments[k].b).norm(), 1e-12);
  EXPECT_NEAR(fitted(f, 0.03, 0.5, 0.01, 2).scale, 0.5, 1e-15);
}

TEST(Fitted, RefusesNumbersThatMeanNothing) {
  const Character c = make_character(arm());
  const double nan = std::nan("");
  for (const double bad : {0.0, -1.0, nan, HUGE_VAL}) {
    EXPECT_THROW(fitted(c, bad, 0.5, 0.01), InvalidInput);
    EXPECT_THROW(fitted(c, 0.03, bad, 0.01), InvalidInput);
    EXPECT_THROW(fitted(c, 0.03, 0.5, bad), InvalidInput);
  }
  for (const double bad : {-1.0, nan, HUGE_VAL}) EXPECT_THROW(fitted(c, 0.03, 0.5, 0.01, bad), InvalidInput);
}

// ---- kinematics

TEST(ForwardKinematics, AHandMadeElbowIsWhereGeometryPutsIt) {
  // Bones along Y, hinges about X: a quarter turn takes Y to Z.
  std::vector<ArmatureBone> bones(3);
  bones[0] = {"root", -1, {0, 0, 0}, {0, 1, 0}, Matrix3d::Identity(), {}};
  bones[1] = {"upper", 0, {0, 1, 0}, {0, 2, 0}, Matrix3d::Identity(), {hinge(0)}};
  bones[2] = {"lower", 1, {0, 2, 0}, {0, 3, 0}, Matrix3d::Identity(), {hinge(0)}};
  const Character c = make_character(bones);
  Pose pose = rest_pose(c, Isometry3d::Identity());
  pose.angles << kPi / 2, kPi / 2;
  Morphology m = ones(c);
  m << 1, 2, 3;
  const auto frames = forward_kinematics(c, pose, m);
  EXPECT_LT((frames[1].translation() - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((frames[2].translation() - Vector3d(0, 1, 2)).norm(), 1e-12);
  EXPECT_LT((frames[2] * skeleton_of(c.bones[2], m[2])[0].b - Vector3d(0, -2, 2)).norm(), 1e-12);
}

TEST(ForwardKinematics, SeveralHingesActAsBlendersXyzEuler) {
  const Character c = make_character(walker());
  Eigen::VectorXd angles = Eigen::VectorXd::Zero(c.angle_count);
  const Bone& chest = c.bones[1];
  ASSERT_EQ(chest.hinges.size(), 3u);
  angles.segment(chest.first_angle, 3) << 0.3, -0.8, 1.1;
  const Matrix3d expected = (Eigen::AngleAxisd(1.1, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.8, Vector3d::UnitY()) *
                             Eigen::AngleAxisd(0.3, Vector3d::UnitX())).toRotationMatrix();
  EXPECT_LT((joint_rotation(chest, angles).toRotationMatrix() - expected).norm(), 1e-12);
}

TEST(ForwardKinematics, BonesStayRigidAndOnTheirJointsInAnyPose) {
  Dice dice(12);
  const Character c = make_character(walker());
  for (int n = 0; n < 20; ++n) {
    const Morphology m = random_morphology(c, dice);
    const auto frames = forward_kinematics(c, random_pose(c, dice), m);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_LT((frames[i].linear().transpose() * frames[i].linear() - Matrix3d::Identity()).norm(), 1e-12);
      const int p = c.bones[i].parent;
      if (p < 0) continue;
      EXPECT_LT((frames[i].translation() - frames[p] * (m[p] * c.bones[i].head_in_parent)).norm(), 1e-12);
      // A bone of one hinge keeps its axis where its parent has it.
      if (c.bones[i].hinges.size() != 1) continue;
      const Vector3d axis = Vector3d::Unit(c.bones[i].hinges[0].axis);
      EXPECT_LT((frames[i].linear() * axis - frames[p].linear() * (c.bones[i].rest_in_parent * axis)).norm(), 1e-12);
    }
  }
}

TEST(ForwardKinematics, AnAngleMovesItsSubtreeAndNothingElse) {
  Dice dice(13);
  const Character c = make_character(walker());
  const Morphology m = ones(c);
  const Pose pose = random_pose(c, dice);
  const auto before = forward_kinematics(c, pose, m);
  for (int i = 1; i < int(c.bones.size()); ++i) {
    Pose moved = pose;
    moved.angles[c.bones[i].first_angle] += 0.7;
    const auto after = forward_kinematics(c, moved, m);
    const auto flags = subtree(c, i);
    for (std::size_t k = 0; k < after.size(); ++k)
      EXPECT_EQ(bool(flags[k]), !after[k].isApprox(before[k], 1e-9)) << c.bones[i].name << " " << c.bones[k].name;
  }
  EXPECT_THROW(subtree(c, -1), InvalidInput);
  EXPECT_THROW(subtree(c, int(c.bones.size())), InvalidInput);
}

TEST(ForwardKinematics, AnElbowOfBothKindsGivesTheSameFrames) {
  Dice dice(14);
  const Character c = make_character(walker());
  std::vector<Isometry3d> frames(40);
  const Pose pose = random_pose(c, dice);
  const Morphology m = random_morphology(c, dice);
  forward_kinematics(c, pose, m, frames);
  const auto other = forward_kinematics(c, pose, m);
  ASSERT_EQ(frames.size(), c.bones.size());
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(frames[i].matrix(), other[i].matrix());
}

TEST(ForwardKinematics, RefusesAPoseOrAMorphologyOfAnotherCharacter) {
  const Character c = make_character(arm());
  Pose pose = rest_pose(c, Isometry3d::Identity());
  EXPECT_THROW(forward_kinematics(c, pose, Morphology::Ones(2)), InvalidInput);
  pose.angles.conservativeResize(2);
  EXPECT_THROW(forward_kinematics(c, pose, ones(c)), InvalidInput);
}

}  // namespace
}  // namespace transformables
