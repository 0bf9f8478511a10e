// The approximate segmentation: by fronts, as the paper has it, and by the shortest way.
#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

#include "reference/laid_out.h"

namespace transformables::reference {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

constexpr double kThinnest = 0.87;      // voxels: the least radius that a capsule is drawn with
constexpr double kAboutJoint = 4;       // voxels: seeds about a joint
constexpr double kBisector = 0.1;       // of how far a point lies past a bone's end: breaks ties about a joint

/// Distance to a segment plus a little of how far the point lies past its end.
double with_overshoot(const Segment& s, const Vector3d& p) {
  const Vector3d along = s.b - s.a;
  const double length = along.norm(), t = length > 0 ? (p - s.a).dot(along) / length : 0;
  return distance(s, p) + kBisector * std::abs(t - std::clamp(t, 0.0, length));
}

/// The point of a segment that is nearest to p.
Vector3d nearest_of(const Segment& s, const Vector3d& p) {
  const Vector3d along = s.b - s.a;
  return s.a + (along.squaredNorm() > 0 ? std::clamp((p - s.a).dot(along) / along.squaredNorm(), 0.0, 1.0) : 0.0) * along;
}

}  // namespace

/// Whether p, and the point of the segment that is nearest to it, are within the ball about one of the bone's joints.
bool Objective::about_joint(const Posed& posed, std::size_t bone, const Segment& s, const Vector3d& p) const {
  const auto within = [&](std::size_t child) {
    const Vector3d& joint = posed.heads[child];
    const double reach = std::min(kAboutJoint * shape_.step, -distance_at(target_, joint));
    return reach > 0 && (p - joint).norm() <= reach && (nearest_of(s, p) - joint).norm() <= reach;
  };
  bool any = character_.bones[bone].parent >= 0 && within(bone);
  for (std::size_t child = 0; child < character_.bones.size(); ++child) any |= character_.bones[child].parent == int(bone) && within(child);
  return any;
}

// Voxels whose centre is within a capsule; where ways count, those about joints too. Of two bones, that whose axis is nearer keeps the voxel.
std::vector<Flooded> Objective::seeds(const Posed& posed) const {
  std::vector<Flooded> flooded(shape_.count());
  double largest = 0;
  for (const Bone& bone : character_.bones) largest = std::max(largest, bone.radius);
  for (std::size_t b = 0; b < character_.bones.size(); ++b) {
    const double radius = std::max(character_.bones[b].radius, kThinnest * shape_.step);
    for (const Segment& s : posed.segments[b]) {
      const Vector3d reach = Vector3d::Constant(std::max(radius, kAboutJoint * shape_.step) + shape_.step);
      const Vector3i low = shape_.nearest(s.a.cwiseMin(s.b) - reach).cwiseMax(0);
      const Vector3i high = shape_.nearest(s.a.cwiseMax(s.b) + reach).cwiseMin((shape_.size.array() - 1).matrix());
      for (int z = low.z(); z <= high.z(); ++z)
        for (int y = low.y(); y <= high.y(); ++y)
          for (int x = low.x(); x <= high.x(); ++x) {
            const std::size_t v = shape_.index(x, y, z);
            const Vector3d p = shape_.position(v);
            const bool near = distance(s, p) <= radius || (options_.flood == FloodKind::kShortestWay && about_joint(posed, b, s, p));
            if (!inside_[v] || !near) continue;
            const double start = (with_overshoot(s, p) + largest - character_.bones[b].radius) / shape_.step;
            const auto units = std::int32_t(32 * start + 0.5);
            if (flooded[v].bone < 0 || units < flooded[v].distance) flooded[v] = {std::int16_t(b), units};
          }
    }
  }
  return flooded;
}

std::vector<Flooded> Objective::flood(const Pose& pose, const Morphology& morphology) const {
  std::vector<Flooded> flooded = seeds(posed(pose, morphology));
  if (options_.flood == FloodKind::kBreadthFirst) by_fronts(flooded);
  else by_shortest_way(flooded);
  return flooded;
}

// The paper's: the front moves on by one voxel at a time, to all neighbours, and takes the bone along.
void Objective::by_fronts(std::vector<Flooded>& flooded) const {
  std::vector<std::size_t> front, next;
  for (const std::size_t v : voxels_)
    if (flooded[v].bone >= 0) {
      flooded[v].distance = 0;
      front.push_back(v);
    }
  while (!front.empty()) {
    next.clear();
    for (const std::size_t v : front)
      for_around(shape_, v, 1, [&](std::size_t n, int) {
        if (!inside_[n] || flooded[n].bone >= 0) return;
        flooded[n] = {flooded[v].bone, flooded[v].distance + 1};
        next.push_back(n);
      });
    front.swap(next);
  }
}

// Dijkstra: the bone with the least start + way; of equal ones the lower bone.
void Objective::by_shortest_way(std::vector<Flooded>& flooded) const {
  constexpr std::int32_t kCost[4] = {0, 32, 45, 55};
  using Entry = std::pair<std::pair<std::int32_t, std::int16_t>, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::vector<char> done(shape_.count(), 0);
  for (const std::size_t v : voxels_)
    if (flooded[v].bone >= 0) open.push({{flooded[v].distance, flooded[v].bone}, v});
  while (!open.empty()) {
    const auto [key, v] = open.top();
    open.pop();
    if (done[v]) continue;
    done[v] = 1;
    for_around(shape_, v, 1, [&, at = key](std::size_t n, int axes) {
      if (!inside_[n] || done[n]) return;
      const auto offer = std::pair(at.first + kCost[axes], at.second);
      if (flooded[n].bone >= 0 && std::pair(flooded[n].distance, flooded[n].bone) <= offer) return;
      flooded[n] = {offer.second, offer.first};
      open.push({offer, n});
    });
  }
}

}  // namespace transformables::reference
