#include <cmath>
#include <string>

#include "character/character.h"
#include "common/error.h"

namespace transformables {
namespace {

void check_sizes(const Character& character, Eigen::Index angles, Eigen::Index factors) {
  if (angles != character.angle_count)
    throw InvalidInput("a pose of this character needs " + std::to_string(character.angle_count) + " angles, not " +
                       std::to_string(angles));
  if (factors != Eigen::Index(character.bones.size()))
    throw InvalidInput("a morphology of this character needs " + std::to_string(character.bones.size()) +
                       " factors, not " + std::to_string(factors));
}

}  // namespace

Eigen::Quaterniond joint_rotation(const Bone& bone, const Eigen::VectorXd& angles) {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
    const double half = 0.5 * angles[bone.first_angle + Eigen::Index(k)];
    Eigen::Quaterniond turn(std::cos(half), 0, 0, 0);
    turn.vec()[bone.hinges[k].axis] = std::sin(half);
    // X acts first, about axes that stay with the parent: Z * Y * X, as Blender's XYZ order.
    rotation = turn * rotation;
  }
  return rotation;
}

void forward_kinematics(const Character& character, const Pose& pose, const Morphology& morphology,
                        std::vector<Eigen::Isometry3d>& frames) {
  check_sizes(character, pose.angles.size(), morphology.size());
  frames.resize(character.bones.size());
  frames[0] = pose.root;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const Bone& bone = character.bones[i];
    const Eigen::Isometry3d& parent = frames[bone.parent];
    const Eigen::Matrix3d turn = (bone.rest_in_parent * joint_rotation(bone, pose.angles)).toRotationMatrix();
    frames[i].linear().noalias() = parent.linear() * turn;
    frames[i].translation() = parent.translation();
    frames[i].translation().noalias() += parent.linear() * (morphology[bone.parent] * bone.head_in_parent);
    frames[i].makeAffine();
  }
}

std::vector<Eigen::Isometry3d> forward_kinematics(const Character& character, const Pose& pose, const Morphology& morphology) {
  std::vector<Eigen::Isometry3d> frames;
  forward_kinematics(character, pose, morphology, frames);
  return frames;
}

Pose rest_pose(const Character& character, const Eigen::Isometry3d& root) {
  return {root, Eigen::VectorXd::Zero(character.angle_count)};
}

std::vector<Segment> skeleton_of(const Bone& bone, double scale) {
  std::vector<Segment> segments = bone.segments;
  for (Segment& s : segments) s = {scale * s.a, scale * s.b};
  return segments;
}

Eigen::VectorXd mirrored_angles(const Character& character, const Eigen::VectorXd& angles) {
  if (!character.mirrored) throw InvalidInput("the character is not its own mirror image: switch symmetry off");
  check_sizes(character, angles.size(), Eigen::Index(character.bones.size()));
  Eigen::VectorXd result(angles.size());
  for (Eigen::Index k = 0; k < result.size(); ++k)
    result[k] = character.mirror_sign[k] * angles[character.mirror_angle[k]];
  return result;
}

std::vector<char> subtree(const Character& character, int i) {
  if (i < 0 || i >= int(character.bones.size()))
    throw InvalidInput("the character has no bone with index " + std::to_string(i));
  std::vector<char> flags(character.bones.size(), 0);
  flags[i] = 1;
  for (std::size_t k = std::size_t(i) + 1; k < flags.size(); ++k) flags[k] = flags[character.bones[k].parent];
  return flags;
}

}  // namespace transformables
