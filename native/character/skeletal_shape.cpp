#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "character/character.h"
#include "common/error.h"

namespace transformables {
namespace {

// What must stay of a bone about its own head, in its radii, when its children's rooms are cut.
constexpr double kKeptAboutHead = 0.2;

SkeletalShape shape_of(const Character& character, int i, double scale, double gap) {
  const Bone& bone = character.bones[i];
  SkeletalShape shape;
  shape.capsules = skeleton_of(bone, scale);
  shape.radius = bone.radius;
  std::vector<Eigen::Vector3d> heads;
  for (const Bone& child : character.bones) {
    if (child.parent != i) continue;
    heads.push_back(scale * child.head_in_parent);
    shape.room_radius = std::max(shape.room_radius, child.radius + gap);
  }
  for (const Eigen::Vector3d& head : heads) {
    const bool near = head.norm() < shape.room_radius + kKeptAboutHead * shape.radius;
    const bool known = std::find(shape.rooms.begin(), shape.rooms.end(), head) != shape.rooms.end();
    if (!near && !known) shape.rooms.push_back(head);
  }
  return shape;
}

}  // namespace

double SkeletalShape::distance(const Eigen::Vector3d& p_in_bone) const {
  double outside = std::numeric_limits<double>::infinity();
  for (const Segment& s : capsules) outside = std::min(outside, transformables::distance(s, p_in_bone));
  outside -= radius;
  for (const Eigen::Vector3d& room : rooms) outside = std::max(outside, room_radius - (p_in_bone - room).norm());
  return outside;
}

std::vector<SkeletalShape> skeletal_shapes(const Character& character, const Morphology& morphology, double gap) {
  if (!std::isfinite(gap) || gap < 0)
    throw InvalidInput("the gap between joint housings must not be negative, but is " + std::to_string(gap));
  if (morphology.size() != Eigen::Index(character.bones.size()))
    throw InvalidInput("a morphology of this character needs " + std::to_string(character.bones.size()) +
                       " factors, not " + std::to_string(morphology.size()));
  std::vector<SkeletalShape> shapes;
  for (int i = 0; i < int(character.bones.size()); ++i) shapes.push_back(shape_of(character, i, morphology[i], gap));
  return shapes;
}

}  // namespace transformables
