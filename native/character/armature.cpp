#include "character/armature.h"

#include <cmath>
#include <string>

#include "common/error.h"

namespace transformables {
namespace {

// Blender stores bone matrices in single precision.
constexpr double kRotationTolerance = 1e-3;

std::string quoted(const ArmatureBone& bone) { return "bone '" + bone.name + "'"; }

void check_hinges(const ArmatureBone& bone) {
  int last_axis = -1;
  for (const Hinge& hinge : bone.hinges) {
    if (hinge.axis < 0 || hinge.axis > 2)
      throw InvalidInput(quoted(bone) + ": a hinge axis must be X, Y or Z (0, 1 or 2), not " + std::to_string(hinge.axis));
    if (hinge.axis <= last_axis)
      throw InvalidInput(quoted(bone) + ": its hinges must be about different axes, in X, Y, Z order");
    last_axis = hinge.axis;
    if (!std::isfinite(hinge.min_rad) || !std::isfinite(hinge.max_rad))
      throw InvalidInput(quoted(bone) + ": a joint limit is not a finite number; set its limits again");
    if (hinge.min_rad >= hinge.max_rad)
      throw InvalidInput(quoted(bone) + ": the least angle of a hinge is not below its largest; widen its limits or lock the axis");
  }
}

void check_bone(const ArmatureBone& bone) {
  if (!bone.head.allFinite() || !bone.tail.allFinite() || !bone.axes.allFinite())
    throw InvalidInput(quoted(bone) + ": its position is not a finite number; move or delete the bone");
  const double error = (bone.axes.transpose() * bone.axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance || bone.axes.determinant() < 0)
    throw InvalidInput(quoted(bone) + ": its axes are not a rotation; apply the armature's scale");
  check_hinges(bone);
}

int checked_root(const std::vector<ArmatureBone>& bones) {
  int root = -1;
  for (int i = 0; i < int(bones.size()); ++i) {
    const int parent = bones[i].parent;
    if (parent < -1 || parent >= int(bones.size()))
      throw InvalidInput(quoted(bones[i]) + ": its parent's index " + std::to_string(parent) + " is out of range");
    if (parent != -1) continue;
    if (root != -1)
      throw InvalidInput("the armature has several roots ('" + bones[root].name + "', '" + bones[i].name +
                         "'); parent them to one bone");
    root = i;
  }
  if (root == -1) throw InvalidInput("the armature has no root: its parents form a cycle");
  return root;
}

double checked_size(const std::vector<ArmatureBone>& bones) {
  Eigen::AlignedBox3d box;
  for (const ArmatureBone& bone : bones) box.extend(bone.head).extend(bone.tail);
  const double size = box.diagonal().norm();
  if (!std::isfinite(size)) throw InvalidInput("the armature is too large to be measured; scale it down");
  if (!(size > 0)) throw InvalidInput("all bones of the armature are at one point; give them lengths");
  return size;
}

}  // namespace

BoneTree checked_tree(const std::vector<ArmatureBone>& bones) {
  if (bones.empty()) throw InvalidInput("the armature has no bones");
  for (const ArmatureBone& bone : bones) check_bone(bone);
  const int root = checked_root(bones);

  BoneTree tree;
  tree.size = checked_size(bones);
  tree.children.resize(bones.size());
  for (int i = 0; i < int(bones.size()); ++i)
    if (bones[i].parent >= 0) tree.children[bones[i].parent].push_back(i);
  std::vector<int> open{root};
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    tree.order.push_back(i);
    open.insert(open.end(), tree.children[i].rbegin(), tree.children[i].rend());
  }
  if (tree.order.size() != bones.size()) throw InvalidInput("the armature's parents form a cycle");
  return tree;
}

}  // namespace transformables
