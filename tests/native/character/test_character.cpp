// The character room: what is refused, how fixed bones join, where poses put bones, mirrors, shapes.
#include "character/character.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "common/error.h"

namespace transformables {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) { return low + (high - low) * double(engine_()) / double(engine_.max()); }
  Vector3d point(double reach = 1) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }
  Isometry3d motion() {
    Isometry3d m = Isometry3d::Identity();
    m.translation() = point();
    m.linear() = Eigen::AngleAxisd((*this)(-3, 3), point().normalized()).toRotationMatrix();
    return m;
  }

 private:
  std::mt19937 engine_;
};

Hinge hinge(int axis, double low = -1, double high = 1) { return {axis, low, high}; }

/// Axes with Y from head to tail, X as near to `side` as that allows.
Matrix3d axes_along(const Vector3d& along, const Vector3d& side) {
  Matrix3d axes;
  axes.col(1) = along.normalized();
  axes.col(2) = side.cross(axes.col(1)).normalized();
  axes.col(0) = axes.col(1).cross(axes.col(2));
  return axes;
}

ArmatureBone bone(const std::string& name, int parent, const Vector3d& head, const Vector3d& tail, std::vector<Hinge> hinges = {},
                  const Vector3d& side = {1, 0.1, 0.2}) {
  return {name, parent, head, tail, axes_along(tail - head, side), std::move(hinges)};
}

/// A root at the origin, an upper and a lower arm; the arm starts away from the root's tail.
std::vector<ArmatureBone> arm() {
  return {bone("root", -1, {0, 0, 0}, {0, 0, 1}), bone("upper", 0, {0.5, 0, 1}, {1.5, 0, 1}, {hinge(0)}),
          bone("lower", 1, {1.5, 0, 1}, {2.5, 0.5, 1}, {hinge(0), hinge(2)})};
}

/// A mirror-symmetric walker: spine in the plane, two legs of two bones (knee of two hinges), names given or not.
std::vector<ArmatureBone> walker(bool named = true, const Vector3d& at = {0, 0, 0}) {
  std::vector<ArmatureBone> bones{
      bone("hips", -1, {0, 0, 1}, {0, 0.2, 1.2}, {}, {1, 0, 0}),
      bone("chest", 0, {0, 0.2, 1.3}, {0, 0.1, 2}, {hinge(0, -0.5, 1), hinge(1), hinge(2)}, {1, 0, 0}),
      bone("head", 1, {0, 0.1, 2.1}, {0, 0, 2.5}, {hinge(0, -0.2, 0.9)}, {1, 0, 0})};
  for (const double s : {1.0, -1.0}) {
    const std::string side = named ? (s > 0 ? ".L" : ".R") : (s > 0 ? "a" : "b");
    const int thigh = int(bones.size());
    // The sides' frames are turned differently about the bones, so that axes map with either sign.
    bones.push_back(bone("thigh" + side, 0, {0.2 * s, 0, 1}, {0.3 * s, 0.05, 0.5}, {hinge(0, -0.7, 0.7)}, {1, 0.3 * s, 0}));
    bones.push_back(bone("shin" + side, thigh, {0.3 * s, 0.05, 0.45}, {0.25 * s, 0.1, 0},
                         {hinge(0, -0.4, 0.6), s > 0 ? hinge(2, -0.2, 0.8) : hinge(2, -0.8, 0.2)}, {1, -0.2 * s, 0.1 * s}));
  }
  for (ArmatureBone& b : bones) b.head += at, b.tail += at;
  return bones;
}

Pose random_pose(const Character& c, Dice& dice) {
  Pose pose = rest_pose(c, dice.motion());
  for (double& angle : pose.angles) angle = dice(-2, 2);
  return pose;
}

Morphology random_morphology(const Character& c, Dice& dice) {
  Morphology m(c.bones.size());
  for (double& factor : m) factor = dice(0.5, 2);
  return m;
}

Morphology ones(const Character& c) { return Morphology::Ones(Eigen::Index(c.bones.size())); }

// ---- what is refused

void expect_refused(const std::vector<ArmatureBone>& bones, const std::string& word) {
  try {
    make_character(bones);
    FAIL() << "accepted, though it should be refused for: " << word;
  } catch (const InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }
}

TEST(MakeCharacter, RefusesAnArmatureWithoutBones) { expect_refused({}, "no bones"); }

TEST(MakeCharacter, RefusesSeveralRootsAndNamesThem) {
  auto bones = arm();
  bones[1].parent = -1;
  expect_refused(bones, "'upper'");
}

TEST(MakeCharacter, RefusesParentsOutOfRange) {
  for (const int parent : {-2, 3, 99}) {
    auto bones = arm();
    bones[2].parent = parent;
    expect_refused(bones, "out of range");
  }
}

TEST(MakeCharacter, RefusesCyclesWithAndWithoutARoot) {
  auto bones = arm();
  bones[1].parent = 2;
  expect_refused(bones, "cycle");
  bones[0].parent = 0;
  expect_refused(bones, "cycle");
}

TEST(MakeCharacter, RefusesPositionsThatAreNotFinite) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    auto bones = arm();
    bones[1].tail.y() = bad;
    expect_refused(bones, "finite");
    bones = arm();
    bones[2].head.x() = bad;
    expect_refused(bones, "finite");
    bones = arm();
    bones[0].axes(1, 1) = bad;
    expect_refused(bones, "finite");
  }
  auto huge = arm();
  huge[1].tail.y() = 1e300;
  expect_refused(huge, "too large");
}

TEST(MakeCharacter, RefusesBonesThatAreAllAtOnePoint) {
  auto bones = arm();
  for (ArmatureBone& b : bones) b.head = b.tail = Vector3d(1, 2, 3);
  expect_refused(bones, "one point");
  bones[0].tail.x() += 1;  // a tail that nothing starts from does not help
  expect_refused(bones, "one point");
}

TEST(MakeCharacter, RefusesAxesThatAreNoRotation) {
  auto bones = arm();
  bones[1].axes.col(0) *= -1;
  expect_refused(bones, "rotation");
  bones = arm();
  bones[1].axes *= 1.01;
  expect_refused(bones, "rotation");
}

TEST(MakeCharacter, RefusesHingesThatAreNone) {
  const double nan = std::nan("");
  for (const auto& [bad, word] : std::vector<std::pair<std::vector<Hinge>, std::string>>{
           {{hinge(3)}, "axis"}, {{hinge(-1)}, "axis"}, {{hinge(0, 1, 1)}, "least angle"}, {{hinge(0, 1, -1)}, "least angle"},
           {{hinge(0, nan, 1)}, "finite"}, {{hinge(0, 0, HUGE_VAL)}, "finite"}, {{hinge(1), hinge(0)}, "order"},
           {{hinge(1), hinge(1)}, "order"}}) {
    auto bones = arm();
    bones[1].hinges = bad;
    expect_refused(bones, word);
  }
}

TEST(MakeCharacter, RefusesACharacterOnlyTheRootOfWhichHasHinges) {
  auto bones = arm();
  bones[0].hinges = {hinge(0)};
  bones[1].hinges = bones[2].hinges = {};
  expect_refused(bones, "hinge");
}

// ---- how it is built

TEST(MakeCharacter, NamesParentsHingesAndAnglesAreThoseOfTheArmature) {
  const Character c = make_character(arm());
  ASSERT_EQ(c.bones.size(), 3u);
  EXPECT_EQ(c.angle_count, 3);
  EXPECT_EQ(c.bones[0].parent, -1);
  EXPECT_EQ(c.bones[1].parent, 0);
  EXPECT_EQ(c.bones[2].parent, 1);
  EXPECT_EQ(c.bones[1].first_angle, 0);
  EXPECT_EQ(c.bones[2].first_angle, 1);
  EXPECT_EQ(c.bones[2].name, "lower");
  EXPECT_EQ(c.bones[2].hinges[1].axis, 2);
}

TEST(MakeCharacter, HingesOfTheRootAreIgnored) {
  auto bones = arm();
  bones[0].hinges = {hinge(0), hinge(1), hinge(2)};
  const Character c = make_character(bones);
  EXPECT_TRUE(c.bones[0].hinges.empty());
  EXPECT_EQ(c.angle_count, 3);
}

TEST(MakeCharacter, TheOrderOfTheArmaturesBonesDoesNotMatter) {
  const auto bones = arm();
  std::vector<ArmatureBone> turned{bones[2], bones[1], bones[0]};
  turned[0].parent = 1, turned[1].parent = 2, turned[2].parent = -1;
  const Character c = make_character(turned);
  ASSERT_EQ(c.bones.size(), 3u);
  EXPECT_EQ(c.bones[0].name, "root");
  EXPECT_EQ(c.bones[0].members, std::vector<int>{2});
  for (std::size_t i = 1; i < 3; ++i) EXPECT_LT(c.bones[i].parent, int(i));
}

TEST(MakeCharacter, AtRestEveryBoneStandsWhereTheArmatureHasIt) {
  for (const auto& bones : {arm(), walker(), walker(false, {3, -2, 1})}) {
    const Character c = make_character(bones);
    const auto frames = forward_kinematics(c, rest_pose(c, c.root_rest), ones(c));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const ArmatureBone& source = bones[c.bones[i].members[0]];
      EXPECT_LT((frames[i].translation() - source.head).norm(), 1e-12);
      EXPECT_LT((frames[i].linear() - source.axes).norm(), 1e-12);
    }
  }
}

TEST(MakeCharacter, SegmentsReachFromTheHeadToEachChildAcrossGapsAndToALeafsTail) {
  const Character c = make_character(arm());
  const auto frames = forward_kinematics(c, rest_pose(c, c.root_rest), ones(c));
  const std::vector<std::pair<Vector3d, Vector3d>> expected{{{0, 0, 0}, {0.5, 0, 1}}, {{0.5, 0, 1}, {1.5, 0, 1}}, {{1.5, 0, 1}, {2.5, 0.5, 1}}};
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(c.bones[i].segments.size(), 1u);
    const Segment s = transformed(frames[i], c.bones[i].segments[0]);
    EXPECT_LT((s.a - expected[i].first).norm(), 1e-12);
    EXPECT_LT((s.b - expected[i].second).norm(), 1e-12);
  }
}

TEST(MakeCharacter, HingesThatShareAPointGiveABallAndNothingElse) {
  auto bones = arm();
  bones[1].tail = bones[1].head + Vector3d(0.1, 0, 0);
  bones[2].head = bones[1].head;
  const Character c = make_character(bones);
  ASSERT_EQ(c.bones[1].segments.size(), 1u);
  EXPECT_EQ((c.bones[1].segments[0].a - c.bones[1].segments[0].b).norm(), 0);
  EXPECT_EQ(c.bones[1].segments[0].a.norm(), 0);
  EXPECT_LT(c.bones[2].head_in_parent.norm(), 1e-12);
}

TEST(MakeCharacter, AZeroLengthSegmentIsDroppedWhereTheBoneHasAnother) {
  auto bones = arm();
  bones.push_back(bone("twin", 1, {0.5, 0, 1}, {0.5, 1, 1}, {hinge(0)}));  // at the head of 'upper'
  const Character c = make_character(bones);
  for (const Bone& b : c.bones)
    for (const Segment& s : b.segments) EXPECT_GT((s.a - s.b).norm(), 1e-3) << b.name;
}

/// 'upper' leads: plate and hook (a chain of two) are fixed to it, and 'lower' hangs on the hook's end.
std::vector<ArmatureBone> arm_with_fixed_bones() {
  std::vector<ArmatureBone> bones{arm()[0], arm()[1]};
  bones.push_back(bone("plate", 1, {1, 0.2, 1}, {1, 1, 1}));
  bones.push_back(bone("hook", 2, {1, 1, 1.2}, {1, 1, 2}));
  bones.push_back(bone("spike", 1, {0.7, 0, 1}, {0.7, 0, 2}));
  bones.push_back(bone("lower", 3, {1, 1, 2.1}, {2, 1, 2.1}, {hinge(0)}));
  return bones;
}

TEST(MakeCharacter, BonesWithoutHingesBecomeMembersOfTheirParentsBodyInChainsToo) {
  const Character c = make_character(arm_with_fixed_bones());
  ASSERT_EQ(c.bones.size(), 3u);
  EXPECT_EQ(c.bones[1].name, "upper");
  EXPECT_EQ(c.bones[1].members.front(), 1);
  EXPECT_EQ(std::set<int>(c.bones[1].members.begin(), c.bones[1].members.end()), (std::set<int>{1, 2, 3, 4}));
  EXPECT_EQ(c.bones[2].name, "lower");
  EXPECT_EQ(c.bones[2].parent, 1);
}

TEST(MakeCharacter, EachArmatureBoneIsInExactlyOneBody) {
  for (const auto& bones : {arm(), walker(), arm_with_fixed_bones()}) {
    std::multiset<int> members;
    for (const Bone& b : make_character(bones).bones) members.insert(b.members.begin(), b.members.end());
    ASSERT_EQ(members.size(), bones.size());
    for (int i = 0; i < int(bones.size()); ++i) EXPECT_EQ(members.count(i), 1u);
  }
}

TEST(MakeCharacter, SegmentsOfAJoinedBodyAreOneConnectedTreeFromItsHeadToItsChildren) {
  const Character c = make_character(arm_with_fixed_bones());
  const Bone& body = c.bones[1];
  EXPECT_GE(body.segments.size(), 5u);  // to plate, spike; spike's own; plate to hook; hook to lower; pieces of a spine
  std::vector<Vector3d> reached{Vector3d::Zero()};
  const auto known = [&](const Vector3d& p) {
    return std::any_of(reached.begin(), reached.end(), [&](const Vector3d& q) { return (p - q).norm() < 1e-9; });
  };
  for (std::size_t round = 0; round < body.segments.size(); ++round)
    for (const Segment& s : body.segments) {
      if (known(s.a) && !known(s.b)) reached.push_back(s.b);
      if (known(s.b) && !known(s.a)) reached.push_back(s.a);
    }
  for (const Segment& s : body.segments) EXPECT_TRUE(known(s.a) && known(s.b));
  EXPECT_TRUE(known(c.bones[2].head_in_parent));
  const auto frames = forward_kinematics(c, rest_pose(c, c.root_rest), ones(c));
  EXPECT_TRUE(known(frames[1].inverse() * Vector3d(0.7, 0, 2)));  // the tail of a member that is a leaf
}

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

TEST(ForwardKinematics, TakesMicroseconds) {
  std::vector<ArmatureBone> bones{bone("0", -1, {0, 0, 0}, {0, 1, 0})};
  for (int i = 1; i < 20; ++i) bones.push_back(bone(std::to_string(i), i - 1, {0, double(i), 0}, {0, i + 1.0, 0}, {hinge(0)}));
  const Character c = make_character(bones);
  Pose pose = rest_pose(c, Isometry3d::Identity());
  const Morphology m = ones(c);
  std::vector<Isometry3d> frames;
  const auto start = std::chrono::steady_clock::now();
  constexpr int kRuns = 20000;
  double sum = 0;
  for (int n = 0; n < kRuns; ++n) {
    pose.angles[n % c.angle_count] = 1e-4 * n;
    forward_kinematics(c, pose, m, frames);
    sum += frames.back().translation().x();
  }
  const double us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count() / kRuns;
  std::cout << "forward kinematics of 20 bones: " << us << " us (" << sum << ")\n";
  EXPECT_LT(us, 200);  // generous: builds with checks, busy machines
}

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

// ---- shapes

Character fitted_arm() { return fitted(make_character(arm()), 0.03, 0.5, 0.01); }

TEST(SkeletalShape, ItIsTheCapsulesLessTheRoomsOfItsChildren) {
  Dice dice(18);
  const Character c = fitted_arm();
  const double gap = 0.002;
  const Morphology m = random_morphology(c, dice);
  const auto shapes = skeletal_shapes(c, m, gap);
  ASSERT_EQ(shapes.size(), c.bones.size());
  int inside = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (int n = 0; n < 3000; ++n) {
      const Segment& s = shapes[i].capsules[0];
      const Vector3d p = s.a + dice(-0.2, 1.2) * (s.b - s.a) + dice.point(2 * c.bones[i].radius);
      bool expected = distance(s, p) < c.bones[i].radius;
      for (const Bone& child : c.bones)
        if (child.parent == int(i)) expected = expected && (p - m[i] * child.head_in_parent).norm() > child.radius + gap;
      EXPECT_EQ(shapes[i].distance(p) < 0, expected);
      inside += expected;
    }
  EXPECT_GT(inside, 100);
}

TEST(SkeletalShape, ABoneContainsItsOwnHeadAndKeepsClearOfItsChildrensHousings) {
  const Character c = fitted_arm();
  const auto shapes = skeletal_shapes(c, ones(c), 0.003);
  for (const SkeletalShape& shape : shapes) EXPECT_NEAR(shape.distance(Vector3d::Zero()), -shape.radius, 1e-12);
  for (std::size_t i = 1; i < c.bones.size(); ++i)
    EXPECT_NEAR(shapes[c.bones[i].parent].distance(c.bones[i].head_in_parent), c.bones[i].radius + 0.003, 1e-12);
}

TEST(SkeletalShape, NoBoneIsSwallowedByARoomHoweverNearItsChildsHead) {
  for (const double share : {0.0, 1e-9, 0.5, 1.0, 1.2, 1.5, 2.0, 3.0})
    for (const double gap : {0.0, 0.001, 0.05}) {
      Character c = fitted_arm();
      const double r = c.bones[1].radius;
      c.bones[2].head_in_parent = Vector3d(0, share * r, 0);
      c.bones[1].segments = {{Vector3d::Zero(), c.bones[2].head_in_parent}};
      const SkeletalShape shape = skeletal_shapes(c, ones(c), gap)[1];
      EXPECT_LE(shape.distance(Vector3d::Zero()), -0.2 * r + 1e-12) << share << " " << gap;
    }
}

TEST(SkeletalShape, DistanceNeverChangesFasterThanThePointMoves) {
  Dice dice(19);
  const Character c = fitted_arm();
  for (const SkeletalShape& shape : skeletal_shapes(c, ones(c), 0.002))
    for (int n = 0; n < 1000; ++n) {
      const Vector3d p = dice.point(0.4), q = p + dice.point(0.01);
      EXPECT_LE(std::abs(shape.distance(p) - shape.distance(q)), (p - q).norm() + 1e-12);
    }
}

TEST(SkeletalShape, RefusesAGapOrAMorphologyThatMeansNothing) {
  const Character c = fitted_arm();
  for (const double bad : {-0.001, std::nan(""), HUGE_VAL}) EXPECT_THROW(skeletal_shapes(c, ones(c), bad), InvalidInput);
  EXPECT_THROW(skeletal_shapes(c, Morphology::Ones(2), 0.001), InvalidInput);
}

/// Every edge is used once in each direction.
bool closed(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (!edges.insert({t[k], t[(k + 1) % 3]}).second) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return edges.count({e.second, e.first}) == 1; });
}

TEST(SkeletalMesh, IsClosedAndOutwardAndFollowsItsCapsules) {
  const Character c = fitted(make_character(arm_with_fixed_bones()), 0.03, 0.5, 0.01);
  Morphology m = ones(c);
  m[1] = 1.7;
  for (int i = 0; i < int(c.bones.size()); ++i) {
    const TriangleMesh mesh = skeletal_mesh(c, m, i);
    const double r = c.bones[i].radius;
    EXPECT_TRUE(closed(mesh));
    double capsules = 0;
    const auto segments = skeleton_of(c.bones[i], m[i]);
    for (const Segment& s : segments) capsules += kPi * r * r * ((s.b - s.a).norm() + 4 * r / 3);
    EXPECT_GT(signed_volume(mesh), 0.8 * capsules);
    EXPECT_LT(signed_volume(mesh), capsules);
    for (const Vector3d& v : mesh.vertices) {
      double d = HUGE_VAL;
      for (const Segment& s : segments) d = std::min(d, distance(s, v));
      EXPECT_LT(d, r + 1e-9);
      EXPECT_GT(d, -1e-9);
    }
  }
}

TEST(SkeletalMesh, ABoneWithoutLengthIsABall) {
  auto bones = arm();
  bones[2].head = bones[1].head;
  const Character c = fitted(make_character(bones), 0.03, 0.5, 0.01);
  const TriangleMesh mesh = skeletal_mesh(c, ones(c), 1);
  EXPECT_EQ(mesh.vertices.size(), 42u);
  EXPECT_EQ(mesh.triangles.size(), 80u);
  EXPECT_TRUE(closed(mesh));
  EXPECT_GT(signed_volume(mesh), 0);
}

TEST(SkeletalMesh, RefusesBonesThatDoNotExistOrHaveNoRadius) {
  const Character c = fitted_arm();
  EXPECT_THROW(skeletal_mesh(c, ones(c), -1), InvalidInput);
  EXPECT_THROW(skeletal_mesh(c, ones(c), 3), InvalidInput);
  EXPECT_THROW(skeletal_mesh(c, Morphology::Ones(1), 0), InvalidInput);
  const Character raw = make_character(arm());
  EXPECT_THROW(skeletal_mesh(raw, ones(raw), 0), InvalidInput);
}

}  // namespace
}  // namespace transformables
