// Room embedding: what the optimiser varies.
#include "cases.h"

#include "embedding/unknowns.h"

namespace transformables {
namespace {

TEST(Unknowns, ReadBackWhatWasWritten) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  Random random(3);
  const Unknowns unknowns(character, target, {}, false);
  Pose pose = random_pose(character, random, 0.1), read = pose;
  const Morphology scales = Morphology::Constant(Eigen::Index(character.bones.size()), 1.2);
  Morphology read_scales = unscaled(character);
  StartPlace start;
  const VectorXd y = unknowns.write(pose, scales, start);
  unknowns.read(y, start, read, read_scales);
  EXPECT_LT((read.root.matrix() - pose.root.matrix()).norm(), 1e-9);
  EXPECT_LT((read.angles - pose.angles).norm(), 1e-9);
  EXPECT_LT((read_scales - scales).norm(), 1e-9);
}

TEST(Unknowns, SymmetricOnesGiveMirrorImagesAndStayInTheLimits) {
  const Character character = armed();
  ASSERT_TRUE(character.mirrored);
  const Target target = box_target({0.25, 0.2, 0.15});
  const Unknowns half(character, target, {}, true), whole(character, target, {}, false);
  EXPECT_LT(half.count(), whole.count());
  Random random(4);
  Pose pose = pose_at(character, {0, 0, 0});
  Morphology scales = unscaled(character);
  for (const Eigen::Matrix3d& rotation : half.start_rotations()) {
    EXPECT_NEAR(rotation.determinant(), 1, 1e-12);
    VectorXd y(half.count());
    for (double& v : y) v = random.uniform(-3, 3);
    half.read(y, {rotation, Vector3d(0, 0.02, 0.01)}, pose, scales);
    const auto frames = forward_kinematics(character, pose, scales);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const Vector3d head = frames[i].translation(), other = frames[std::size_t(character.bones[i].mirror)].translation();
      EXPECT_LT((Vector3d(-head.x(), head.y(), head.z()) - other).norm(), 1e-6);
      EXPECT_GE(scales[Eigen::Index(i)], 0.6 - 1e-12);
      EXPECT_LE(scales[Eigen::Index(i)], 1.6 + 1e-12);
      for (std::size_t k = 0; k < character.bones[i].hinges.size(); ++k) {
        const double angle = pose.angles[character.bones[i].first_angle + Eigen::Index(k)];
        EXPECT_GE(angle, character.bones[i].hinges[k].min_rad - 1e-12);
        EXPECT_LE(angle, character.bones[i].hinges[k].max_rad + 1e-12);
      }
    }
  }
}

TEST(Unknowns, TellWhichBoneEachTurnsOrScales) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  for (const bool symmetric : {false, true}) {
    const Unknowns unknowns(character, target, {}, symmetric);
    ASSERT_EQ(unknowns.bones().size(), std::size_t(unknowns.count()));
    Pose rest = pose_at(character, {0, 0, 0}), moved = rest;
    Morphology scales = unscaled(character), other = scales;
    VectorXd y = VectorXd::Zero(unknowns.count());
    unknowns.read(y, {}, rest, scales);
    for (Eigen::Index u = unknowns.root_count(); u < y.size(); ++u) {
      y[u] = 0.3;
      unknowns.read(y, {}, moved, other);
      y[u] = 0;
      for (std::size_t b = 0; b < character.bones.size(); ++b) {
        const Bone& bone = character.bones[b];
        const bool changed = other[Eigen::Index(b)] != scales[Eigen::Index(b)] ||
                             (!bone.hinges.empty() && moved.angles[bone.first_angle] != rest.angles[bone.first_angle]);
        const int own = unknowns.bones()[std::size_t(u)];
        EXPECT_EQ(changed, int(b) == own || (symmetric && int(b) == character.bones[std::size_t(own)].mirror));
      }
    }
  }
}

VectorXd anywhere(const Unknowns& unknowns, Random& random) {
  VectorXd y(unknowns.count());
  for (double& v : y) v = random.uniform(-3, 3);
  return y;
}

TEST(Unknowns, ALockedAngleStaysWhatItIsEvenOutsideItsRange) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  EmbeddingOptions options;
  options.locked = {{0, 0.7}, {1, -4}};
  const Unknowns unknowns(character, target, options, false), all(character, target, {}, false);
  EXPECT_EQ(unknowns.count(), all.count() - 2);
  Random random(4);
  Pose pose = pose_at(character, {0, 0, 0});
  Morphology scales = unscaled(character);
  for (int round = 0; round < 5; ++round) {
    unknowns.read(anywhere(unknowns, random), {}, pose, scales);
    EXPECT_EQ(pose.angles[0], 0.7);
    EXPECT_EQ(pose.angles[1], -4);
  }
}

TEST(Unknowns, WhenSymmetricALockHoldsTheOtherSideToo) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  int upper = 0;
  for (const Bone& bone : character.bones)
    if (bone.name == "upper.L") upper = bone.first_angle;
  EmbeddingOptions options;
  options.locked = {{upper, 0.4}};
  const Unknowns unknowns(character, target, options, true);
  Random random(4);
  Pose pose = pose_at(character, {0, 0, 0});
  Morphology scales = unscaled(character);
  unknowns.read(anywhere(unknowns, random), {}, pose, scales);
  EXPECT_EQ(pose.angles[upper], 0.4);
  EXPECT_LT((mirrored_angles(character, pose.angles) - pose.angles).norm(), 1e-12);
}

TEST(Unknowns, APinnedBoneStaysInItsPlaceWhateverTheOthersDo) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  Random random(7);
  for (int bone = 0; bone < int(character.bones.size()); ++bone) {
    EmbeddingOptions options;
    options.pinned = {{bone, random_pose(character, random, 0.2).root}};
    const Unknowns unknowns(character, target, options, false);
    EXPECT_EQ(unknowns.start_rotations().size(), 1u);
    Pose pose = pose_at(character, {0, 0, 0});
    Morphology scales = unscaled(character);
    for (int round = 0; round < 3; ++round) {
      unknowns.read(anywhere(unknowns, random), {}, pose, scales);
      const auto frames = forward_kinematics(character, pose, scales);
      EXPECT_LT((frames[std::size_t(bone)].matrix() - options.pinned[0].frame.matrix()).norm(), 1e-9);
    }
  }
}

TEST(Unknowns, ABoneWithBoundsOfItsOwnKeepsToThemAndTheRestToTheCommonOnes) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  for (const bool proportions : {true, false}) {
    EmbeddingOptions options;
    options.proportions = proportions;
    options.proportion_of = {{0, 1.1, 1.2}, {1, 0.9, 0.9}};
    const Unknowns unknowns(character, target, options, false);
    Random random(2);
    Pose pose = pose_at(character, {0, 0, 0});
    Morphology scales = unscaled(character);
    for (int round = 0; round < 10; ++round) {
      unknowns.read(anywhere(unknowns, random), {}, pose, scales);
      EXPECT_GE(scales[0], 1.1 - 1e-12);
      EXPECT_LE(scales[0], 1.2 + 1e-12);
      EXPECT_EQ(scales[1], 0.9);
      if (proportions)
        EXPECT_NE(scales[2], 1);
      else
        EXPECT_EQ(scales[2], 1);
    }
  }
}

TEST(Unknowns, WhenSymmetricBothSidesScaleAlikeWhereOneHasBoundsOfItsOwn) {
  const Character character = armed();
  const Target target = box_target({0.25, 0.2, 0.15});
  for (int bone = 2; bone < int(character.bones.size()); ++bone) {
    EmbeddingOptions options;
    options.proportions = false;
    options.proportion_of = {{bone, 1.3, 1.3}};
    const Unknowns unknowns(character, target, options, true);
    Random random(2);
    Pose pose = pose_at(character, {0, 0, 0});
    Morphology scales = unscaled(character);
    unknowns.read(anywhere(unknowns, random), {Eigen::Matrix3d::Identity(), {0, 0, 0}}, pose, scales);
    EXPECT_EQ(scales[bone], 1.3);
    EXPECT_EQ(scales[character.bones[std::size_t(bone)].mirror], 1.3);
  }
}

}  // namespace
}  // namespace transformables
