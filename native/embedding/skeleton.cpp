#include "embedding/skeleton.h"

#include <limits>

namespace transformables {
namespace {

// Bones that share a joint always meet there; what lies within so many radii of it is left to the joint's own housing.
constexpr double kJointRadii = 2.5;

std::vector<int> path_to_root(const Character& character, int bone) {
  std::vector<int> path;
  for (int b = bone; b >= 0; b = character.bones[std::size_t(b)].parent) path.push_back(b);
  return path;
}

}  // namespace

Skeleton::Skeleton(const Character& character_) : character(character_) {
  const std::size_t n = character.bones.size();
  rotations.resize(n);
  heads.resize(n);
  hinge_axes.resize(std::size_t(character.angle_count));
  scales_.assign(n, 1);
  reach_.assign(n, 0);
  first_segment.push_back(0);
  for (const Bone& bone : character.bones) {
    rest_.insert(rest_.end(), bone.segments.begin(), bone.segments.end());
    if (bone.segments.empty()) rest_.push_back({});
    first_segment.push_back(int(rest_.size()));
    largest_radius = std::max(largest_radius, bone.radius);
  }
  segments.resize(rest_.size());
  for (int j = 0; j < int(n); ++j)
    for (int i = 0; i < j; ++i) add_pair(i, j);
}

void Skeleton::add_pair(int i, int j) {
  std::vector<int> from_i = path_to_root(character, i), from_j = path_to_root(character, j);
  while (from_i.size() > 1 && from_j.size() > 1 && from_i[from_i.size() - 2] == from_j[from_j.size() - 2]) {
    from_i.pop_back();
    from_j.pop_back();
  }
  // Both paths now end with the lowest common ancestor, and part before it, or one of them is that bone alone.
  if (from_i.size() > 1 && from_j.size() == 1) return;  // j comes after its ancestors, so this never happens
  const auto head = [&](int bone) { return character.bones[std::size_t(bone)].head_in_parent; };
  Pair pair{i, j, character.bones[std::size_t(j)].parent == i, from_i.size() > 1, int(links_.size()), 0};
  for (const auto* path : {&from_i, &from_j})
    for (std::size_t k = 1; k + 1 < path->size(); ++k) links_.push_back({(*path)[k], head((*path)[k - 1]).norm()});
  if (pair.trim_first) {
    const int a = from_i[from_i.size() - 2], b = from_j[from_j.size() - 2];
    links_.push_back({from_i.back(), (head(a) - head(b)).norm()});
  }
  pair.end_link = int(links_.size());
  pairs_.push_back(pair);
}

void Skeleton::set(const Pose& pose, const Morphology& morphology) {
  for (std::size_t i = 0; i < character.bones.size(); ++i) {
    const Bone& bone = character.bones[i];
    scales_[i] = morphology[Eigen::Index(i)];
    Eigen::Matrix3d turned;
    if (bone.parent < 0) {
      turned = pose.root.linear();
      heads[i] = pose.root.translation();
    } else {
      const auto p = std::size_t(bone.parent);
      turned = rotations[p] * bone.rest_in_parent.toRotationMatrix();
      heads[i] = heads[p] + rotations[p] * (scales_[p] * bone.head_in_parent);
    }
    // R = Rz Ry Rx: the last hinge stands in the frame at rest, each earlier one is turned by those after it.
    for (std::size_t k = bone.hinges.size(); k-- > 0;) {
      const auto angle = std::size_t(bone.first_angle) + k;
      hinge_axes[angle] = turned.col(bone.hinges[k].axis);
      turned = turned * Eigen::AngleAxisd(pose.angles[Eigen::Index(angle)], Eigen::Vector3d::Unit(bone.hinges[k].axis)).toRotationMatrix();
    }
    rotations[i] = turned;
    reach_[i] = 0;
    for (int s = first_segment[i]; s < first_segment[i + 1]; ++s) {
      const Segment& rest = rest_[std::size_t(s)];
      const Eigen::Vector3d along = rest.b - rest.a;
      const double length = along.norm();
      PosedSegment& out = segments[std::size_t(s)];
      out.a = heads[i] + turned * (scales_[i] * rest.a);
      out.length = scales_[i] * length;
      out.direction = length > 0 ? Eigen::Vector3d(turned * (along / length)) : Eigen::Vector3d::Zero();
      reach_[i] = std::max(reach_[i], scales_[i] * std::max(rest.a.norm(), rest.b.norm()));
    }
  }
}

double Skeleton::trim(const Pair& pair) const {
  const auto& bones = character.bones;
  double way = 0;
  for (int k = pair.first_link; k < pair.end_link; ++k)
    way += scales_[std::size_t(links_[std::size_t(k)].bone)] * links_[std::size_t(k)].length;
  return std::max(0.0, kJointRadii * 0.5 * (bones[std::size_t(pair.i)].radius + bones[std::size_t(pair.j)].radius) - way);
}

double Skeleton::gap(const Pair& pair) const {
  const double trimmed = trim(pair), trimmed_first = pair.trim_first ? trimmed : 0;
  double least = std::numeric_limits<double>::infinity();
  const auto i = std::size_t(pair.i), j = std::size_t(pair.j);
  for (int s = first_segment[i]; s < first_segment[i + 1]; ++s) {
    const PosedSegment& a = segments[std::size_t(s)];
    if (trimmed_first > 0 && a.length <= trimmed_first) continue;
    const Segment first{a.a + trimmed_first * a.direction, a.a + a.length * a.direction};
    for (int t = first_segment[j]; t < first_segment[j + 1]; ++t) {
      const PosedSegment& b = segments[std::size_t(t)];
      if (trimmed > 0 && b.length <= trimmed) continue;
      least = std::min(least, distance(first, Segment{b.a + trimmed * b.direction, b.a + b.length * b.direction}));
    }
  }
  return least;
}

bool Skeleton::apart(const Pair& pair) const {
  const auto i = std::size_t(pair.i), j = std::size_t(pair.j);
  const double far = reach_[i] + reach_[j] + character.bones[i].radius + character.bones[j].radius;
  return (heads[i] - heads[j]).squaredNorm() >= far * far;
}

double Skeleton::depth(const Pair& pair) const {
  if (apart(pair)) return 0;
  return std::max(0.0, character.bones[std::size_t(pair.i)].radius + character.bones[std::size_t(pair.j)].radius - gap(pair));
}

CapsuleCollisions Skeleton::collisions() const {
  CapsuleCollisions result;
  for (const Pair& pair : pairs_) {
    const double deep = depth(pair);
    if (!(deep > 0)) continue;
    result.sum_of_squares += deep * deep;
    result.sum += deep;
    if (!pair.joined) result.deepest = std::max(result.deepest, deep);
  }
  return result;
}

}  // namespace transformables
