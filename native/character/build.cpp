#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "character/armature.h"
#include "character/character.h"
#include "character/mirror.h"
#include "common/error.h"

namespace transformables {
namespace {

// Shorter segments, as a share of the character's size, are joints that share a point.
constexpr double kPointTolerance = 1e-6;

Eigen::Isometry3d bone_frame(const ArmatureBone& bone) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = Eigen::Quaterniond(bone.axes).normalized().toRotationMatrix();
  frame.translation() = bone.head;
  return frame;
}

Bone lead_bone(const ArmatureBone& source, int index, int parent, const Eigen::Isometry3d& in_parent) {
  Bone bone;
  bone.name = source.name;
  bone.parent = parent;
  bone.members = {index};
  if (parent >= 0) {
    bone.head_in_parent = in_parent.translation();
    bone.rest_in_parent = Eigen::Quaterniond(in_parent.linear()).normalized();
    bone.hinges = source.hinges;
  }
  return bone;
}

/// Joins each bone without hinges to its parent. Angles are numbered in the order of the bodies.
void join_fixed_bones(const std::vector<ArmatureBone>& bones, const BoneTree& tree, Character& character,
                      std::vector<Eigen::Isometry3d>& frames) {
  std::vector<int> body_of(bones.size(), -1);
  for (const int i : tree.order) {
    const int parent = bones[i].parent < 0 ? -1 : body_of[bones[i].parent];
    if (parent >= 0 && bones[i].hinges.empty()) {
      body_of[i] = parent;
      character.bones[parent].members.push_back(i);
      continue;
    }
    body_of[i] = int(character.bones.size());
    frames.push_back(bone_frame(bones[i]));
    const Eigen::Isometry3d in_parent = parent < 0 ? frames.back() : frames[parent].inverse() * frames.back();
    character.bones.push_back(lead_bone(bones[i], i, parent, in_parent));
    character.bones.back().first_angle = character.angle_count;
    character.angle_count += int(character.bones.back().hinges.size());
  }
}

using Links = std::vector<Segment>;

/// How near, at least, a link passes by a child's head that it does not lead to: there the child's housing would cut it.
double least_passing(const Links& links, const std::vector<Eigen::Vector3d>& ends) {
  double least = std::numeric_limits<double>::infinity();
  for (const Segment& link : links)
    for (const Eigen::Vector3d& end : ends)
      if (end != link.a && end != link.b) least = std::min(least, distance(link, end));
  return least;
}

/// A spine along the bone as far as its children need it, in pieces, with a rib to each child.
Links spine_and_ribs(const ArmatureBone& bone, const std::vector<Eigen::Vector3d>& ends) {
  const Eigen::Vector3d along = bone.tail - bone.head;
  std::vector<double> joints{0};
  Links links;
  for (const Eigen::Vector3d& end : ends) {
    joints.push_back(std::clamp((end - bone.head).dot(along) / along.squaredNorm(), 0.0, 1.0));
    links.push_back({bone.head + joints.back() * along, end});
  }
  std::sort(joints.begin(), joints.end());
  for (std::size_t n = 1; n < joints.size(); ++n) links.push_back({bone.head + joints[n - 1] * along, bone.head + joints[n] * along});
  return links;
}

/// Straight links from the head to all ends, unless they pass by other children's housings so closely that these would cut
/// them, and a spine with ribs keeps clearly more distance.
Links lay_links(const ArmatureBone& bone, const std::vector<Eigen::Vector3d>& ends) {
  constexpr double kClearlyMore = 1.5;
  Links straight;
  for (const Eigen::Vector3d& end : ends) straight.push_back({bone.head, end});
  if (ends.size() < 2 || bone.tail == bone.head) return straight;
  Links ribs = spine_and_ribs(bone, ends);
  return least_passing(ribs, ends) > kClearlyMore * least_passing(straight, ends) ? ribs : straight;
}

/// The links of all members, to the heads of their children, be they of this body or of the next: so the skeleton is
/// connected and spans the gaps of rigs whose bones start away from their parent's tail.
std::vector<Segment> lay_segments(const std::vector<ArmatureBone>& bones, const BoneTree& tree, const Bone& body,
                                  const Eigen::Isometry3d& frame) {
  const Eigen::Isometry3d to_body = frame.inverse();
  std::vector<Segment> segments;
  for (const int i : body.members) {
    std::vector<Eigen::Vector3d> ends;
    for (const int child : tree.children[i]) ends.push_back(bones[child].head);
    if (ends.empty()) ends.push_back(bones[i].tail);
    for (const Segment& link : lay_links(bones[i], ends))
      if ((link.a - link.b).norm() > kPointTolerance * tree.size) segments.push_back({to_body * link.a, to_body * link.b});
  }
  if (segments.empty()) segments.push_back({});
  return segments;
}

double total_length(const Character& character) {
  double length = 0;
  for (const Bone& bone : character.bones)
    for (const Segment& s : bone.segments) length += (s.b - s.a).norm();
  return length;
}

}  // namespace

Character make_character(const std::vector<ArmatureBone>& bones) {
  const BoneTree tree = checked_tree(bones);
  Character character;
  std::vector<Eigen::Isometry3d> frames;
  join_fixed_bones(bones, tree, character, frames);
  if (character.angle_count == 0)
    throw InvalidInput("no bone of the armature has a hinge (its root's are not counted): unlock an axis of a bone");
  for (std::size_t i = 0; i < frames.size(); ++i)
    character.bones[i].segments = lay_segments(bones, tree, character.bones[i], frames[i]);
  if (!(total_length(character) > 0))
    throw InvalidInput("all joints of the armature are at one point; give its bones lengths");
  character.root_rest = frames.front();
  character.mirror_x = frames.front().translation().x();
  find_mirror(character, tree.size);
  return character;
}

}  // namespace transformables
