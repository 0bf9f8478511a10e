// What armatures are refused, how a character is built of one, how fixed bones join.
#include "character/character.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "cases.h"
#include "common/error.h"

namespace transformables {
namespace {

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

}  // namespace
}  // namespace transformables
