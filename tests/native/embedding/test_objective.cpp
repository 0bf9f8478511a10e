// Room embedding: the terms of the objective on cases with known answers.
#include "cases.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> allocations{0};
}

// Counted, for the promise that an evaluation allocates nothing. Not inlined: GCC would take malloc and delete for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }


namespace transformables {
namespace {

TEST(Skeleton, StandsWhereForwardKinematicsPutsIt) {
  std::vector<ArmatureBone> bones{armature_bone("a", -1, {0, 0, 0}, {0, 0.1, 0}, {})};
  bones.push_back(armature_bone("b", 0, {0.02, 0.1, 0}, {0.02, 0.2, 0.05}, {{0, -2, 2}, {1, -2, 2}, {2, -2, 2}}));
  bones.push_back(armature_bone("c", 1, {0.03, 0.2, 0.05}, {0.1, 0.2, 0.1}, {{2, -2, 2}}));
  const Character character = with_radius(make_character(bones), 0.01);
  Skeleton skeleton(character);
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    const Pose pose = random_pose(character, random, 0.2);
    const Morphology scales = Vector3d(random.uniform(0.5, 2), random.uniform(0.5, 2), random.uniform(0.5, 2));
    skeleton.set(pose, scales);
    const auto frames = forward_kinematics(character, pose, scales);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_LT((skeleton.heads[i] - frames[i].translation()).norm(), 1e-12);
      EXPECT_LT((skeleton.rotations[i] - frames[i].linear()).norm(), 1e-12);
    }
  }
}

TEST(Skeleton, AHingeAxisIsWhatAPointTurnsAbout) {
  std::vector<ArmatureBone> bones{armature_bone("a", -1, {0, 0, 0}, {0, 0.1, 0}, {})};
  bones.push_back(armature_bone("b", 0, {0, 0.1, 0}, {0, 0.2, 0.05}, {{0, -2, 2}, {1, -2, 2}, {2, -2, 2}}));
  const Character character = with_radius(make_character(bones), 0.01);
  Skeleton skeleton(character);
  Random random(6);
  for (int round = 0; round < 10; ++round) {
    const Pose pose = random_pose(character, random, 0.2);
    const Vector3d local(0.03, 0.05, -0.02);
    for (int k = 0; k < 3; ++k) {
      Pose ahead = pose, behind = pose;
      ahead.angles[k] += 1e-6;
      behind.angles[k] -= 1e-6;
      const Vector3d velocity = (forward_kinematics(character, ahead, unscaled(character))[1] * local -
                                 forward_kinematics(character, behind, unscaled(character))[1] * local) / 2e-6;
      skeleton.set(pose, unscaled(character));
      const Vector3d arm = skeleton.rotations[1] * local;
      EXPECT_LT((skeleton.hinge_axes[std::size_t(k)].cross(arm) - velocity).norm(), 1e-7);
    }
  }
}

TEST(Objective, AnUpperAndALowerBoneThatFoldOntoEachOtherCollideByTheDepthOfTheirCapsules) {
  // Three bones folded to a U: the first and the third are parallel, 0.1 apart, and overlap when the radii exceed 0.05.
  const Character character = chain(3, 0.1, 0.06, {0, -1.6, 1.6});
  Pose pose = pose_at(character, {0, 0, 0});
  pose.angles << M_PI / 2, M_PI / 2;
  Skeleton skeleton(character);
  skeleton.set(pose, unscaled(character));
  const CapsuleCollisions collisions = skeleton.collisions();
  // The third bone starts 0.1 from the first's joint; housings reach 2.5 * 0.06 = 0.15, so 0.05 of it is not counted.
  EXPECT_NEAR(collisions.deepest, 0.02, 1e-9);
  const Character thin = with_radius(character, 0.049);
  Skeleton thin_skeleton(thin);
  thin_skeleton.set(pose, unscaled(thin));
  EXPECT_EQ(thin_skeleton.collisions().deepest, 0);
}

TEST(Objective, JoinedBonesAreFreeAtTheirJointButMayNotFoldFlat) {
  const Character character = chain(2, 0.1, 0.01, {0, -3.1, 3.1});
  Skeleton skeleton(character);
  Pose pose = pose_at(character, {0, 0, 0});
  for (const double angle : {0.0, 1.0, -1.5, 2.0}) {
    pose.angles << angle;
    skeleton.set(pose, unscaled(character));
    EXPECT_EQ(skeleton.collisions().sum, 0) << angle;
  }
  pose.angles << 3.1;
  skeleton.set(pose, unscaled(character));
  // The child from 0.025 on lies 0.025 * sin(pi - 3.1) beside its parent.
  EXPECT_NEAR(skeleton.collisions().sum, 0.02 - 0.025 * std::sin(M_PI - 3.1), 1e-9);
  EXPECT_EQ(skeleton.collisions().deepest, 0);
}

TEST(Objective, BonesThatStartAtOnePlaceOfTheirParentCanBeFeasible) {
  std::vector<ArmatureBone> bones{armature_bone("body", -1, {0, 0, 0}, {0, 0.1, 0}, {})};
  bones.push_back(armature_bone("a", 0, {0, 0.1, 0}, {0.07, 0.17, 0}, {{2, -1, 1}}));
  bones.push_back(armature_bone("b", 0, {0.001, 0.1, 0}, {-0.07, 0.17, 0}, {{2, -1, 1}}));
  const Character character = with_radius(make_character(bones), 0.01);
  Skeleton skeleton(character);
  skeleton.set(pose_at(character, {0, 0, 0}), unscaled(character));
  EXPECT_EQ(skeleton.collisions().sum, 0);
}

TEST(Objective, ACapsuleBesideTheTargetProtrudesByItsDistance) {
  const Target target = box_target({0.25, 0.2, 0.2});
  const double out = 0.08, radius = 0.01;
  const Character character = chain(2, 0.1, radius);
  const Evaluation beside = evaluator_of(character, target).without_flood(pose_at(character, {0.25 + out, -0.1, 0}), unscaled(character));
  // On a ring the mean of (out + radius cos t)^2 is out^2 + radius^2 / 2; the tips of the capsules have out^2.
  EXPECT_GT(beside.terms.protrude, out * out);
  EXPECT_LT(beside.terms.protrude, (out * out + radius * radius / 2) * 1.01);
  EXPECT_NEAR(beside.deepest_protrusion, out + radius, 1e-3);
  const Evaluation within = evaluator_of(character, target).without_flood(pose_at(character, {0, -0.1, 0}), unscaled(character));
  EXPECT_EQ(within.terms.protrude, 0);
  EXPECT_EQ(within.deepest_protrusion, 0);
}

TEST(Objective, TheSkinTermOfAHingeBetweenTwoBoxesIsTheIntegralByHand) {
  const Vector3d half(0.1, 0.25, 0.12);
  const Target target = box_target(half);
  const double least = -1, most = 2;
  const Character character = chain(2, 0.2, 0.02, {0, least, most});
  Objective objective(character, target, {});
  const ObjectiveTerms terms = objective(pose_at(character, {0, -0.2, 0}), unscaled(character));
  // The interface is the plane y = 0 with normal -Y (child to parent); the X hinge moves (x, 0, z) by (0, -z, 0) a radian.
  const double per_unit_length = (most - least) * half.z() * half.z() / 2;
  const double expected = 2 * half.x() * per_unit_length / (0.01 * 0.01);
  EXPECT_NEAR(terms.skin, expected, 0.05 * expected);
}

TEST(Objective, AHingeAtTheEndOfItsRangeOnlyCountsWhatIsLeft) {
  const Vector3d half(0.1, 0.25, 0.12);
  const Target target = box_target(half);
  const Character whole = chain(2, 0.2, 0.02, {0, -1, 1}), shut = chain(2, 0.2, 0.02, {0, 0, 1});
  const Pose pose = pose_at(whole, {0, -0.2, 0});
  const double both = Objective(whole, target, {})(pose, unscaled(whole)).skin;
  ASSERT_GT(both, 1);
  EXPECT_NEAR(Objective(shut, target, {})(pose, unscaled(shut)).skin, both / 2, 0.05 * both);
}

TEST(Objective, TheFinerGridDoesNotChangeTheBalanceOfTerms) {
  const Vector3d half(0.15, 0.25, 0.15);
  const Character character = chain(3, 0.14, 0.02);
  Pose pose = pose_at(character, {0.02, -0.2, 0});
  pose.angles << 0.4, -0.5;
  const Target coarse = box_target(half, 32), fine = box_target(half, 64);
  const ObjectiveTerms a = Objective(character, coarse, {})(pose, unscaled(character));
  const ObjectiveTerms b = Objective(character, fine, {})(pose, unscaled(character));
  EXPECT_NEAR(a.compact, b.compact, 0.15 * b.compact);
  EXPECT_NEAR(a.skin, b.skin, 0.2 * b.skin);
}

TEST(Objective, ABoneIsMostCompactInTheMiddleOfABall) {
  const Target target = ball_target();
  Character character;  // a single bone, so that there is no interface to be made smaller by leaving the middle
  character.bones.resize(1);
  character.bones[0].segments = {{Vector3d(0, -0.08, 0), Vector3d(0, 0.08, 0)}};
  character.bones[0].radius = 0.02;
  Objective objective(character, target, {});
  const double centred = objective(pose_at(character, {0, 0, 0}), unscaled(character)).compact;
  for (const Vector3d& off : {Vector3d(0.04, 0, 0), Vector3d(0, 0.04, 0), Vector3d(0, -0.04, 0), Vector3d(0.03, 0.02, -0.03)})
    EXPECT_GT(objective(pose_at(character, off), unscaled(character)).compact, centred);
}

TEST(Objective, AnglesOutsideTheirLimitsAndScalesOtherThanOneCost) {
  const Target target = ball_target();
  const Character character = chain(2, 0.08, 0.02, {0, -1, 1});
  Objective objective(character, target, {});
  Pose pose = pose_at(character, {0, -0.08, 0});
  pose.angles << 1.5;
  Morphology scales(2);
  scales << 2, 0.5;
  const ObjectiveTerms terms = objective(pose, scales);
  EXPECT_NEAR(terms.limits, 0.25, 1e-12);
  EXPECT_NEAR(terms.morphology, 2 * std::log(2.0) * std::log(2.0), 1e-12);
}

TEST(Objective, ASkeletonFarFromTheTargetCostsMoreTheFartherItIs) {
  const Target target = ball_target();
  const Character character = chain(2, 0.08, 0.02);
  Objective objective(character, target, {});
  const ObjectiveTerms near = objective(pose_at(character, {0.5, 0, 0}), unscaled(character));
  const ObjectiveTerms far = objective(pose_at(character, {0.9, 0, 0}), unscaled(character));
  EXPECT_GT(near.compact, 0);
  EXPECT_GT(far.compact, near.compact);
  EXPECT_GT(far.protrude, near.protrude);
}

TEST(Objective, AllocatesNothingInAnEvaluation) {
  const Target target = box_target({0.25, 0.2, 0.15}, 32);
  const Character character = armed();
  Objective objective(character, target, {});
  Random random(8);
  std::vector<Pose> poses;
  for (int k = 0; k < 20; ++k) poses.push_back(random_pose(character, random, k < 10 ? 0.05 : 1));
  const Morphology scales = unscaled(character);
  const long before = allocations;
  for (const Pose& pose : poses) objective(pose, scales);
  EXPECT_EQ(allocations - before, 0);
}

TEST(Objective, RefusesATargetWithoutInsideAndACharacterWithoutBones) {
  Target empty = ball_target();
  empty.inside.clear();
  const Character character = chain(2, 0.08, 0.02);
  EXPECT_THROW(Objective(character, empty, {}), InvalidInput);
  EXPECT_THROW(Objective(Character{}, ball_target(), {}), InvalidInput);
}

}  // namespace
}  // namespace transformables
