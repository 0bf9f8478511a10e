#include "segmentation/skeleton.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <string>

#include "segmentation/lattice.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kProtectedShare = 0.9;  // of a capsule's radius

struct AxisSample {
  std::size_t index;
  double from_axis;   // target units
  double from_rooms;  // to the nearest child's head; large without children
};

double axis_distance(const Skeleton& skeleton, int bone, const Eigen::Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Segment& s : skeleton.shapes[bone].capsules)
    least = std::min(least, distance(transformed(skeleton.frames[bone], s), p));
  return least;
}

double rooms_distance(const Skeleton& skeleton, int bone, const Eigen::Vector3d& p) {
  double least = std::numeric_limits<double>::max();
  for (const Eigen::Vector3d& room : skeleton.shapes[bone].rooms)
    least = std::min(least, (skeleton.frames[bone] * room - p).norm());
  return least;
}

// The first and the last sample of a box that holds a bone's shape.
std::pair<Eigen::Vector3i, Eigen::Vector3i> box_of(const Skeleton& skeleton, const GridShape& shape, int bone) {
  Eigen::AlignedBox3d box;
  for (const Segment& s : skeleton.shapes[bone].capsules) box.extend(skeleton.frames[bone] * s.a), box.extend(skeleton.frames[bone] * s.b);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(skeleton.shapes[bone].radius);
  const Eigen::Vector3i last = shape.size - Eigen::Vector3i::Ones();
  return {shape.nearest(box.min() - reach).cwiseMax(0).cwiseMin(last), shape.nearest(box.max() + reach).cwiseMax(0).cwiseMin(last)};
}

// Samples along a segment, each a face neighbour of the one before.
std::vector<Eigen::Vector3i> rasterised(const GridShape& shape, const Segment& s) {
  const int parts = std::max(1, int(std::ceil((s.b - s.a).norm() / (0.25 * shape.step))));
  std::vector<Eigen::Vector3i> path{shape.nearest(s.a)};
  for (int k = 1; k <= parts; ++k) {
    const Eigen::Vector3i next = shape.nearest(s.a + (s.b - s.a) * (double(k) / parts));
    for (int axis = 0; axis < 3; ++axis)
      while (path.back()[axis] != next[axis]) {
        Eigen::Vector3i between = path.back();
        between[axis] += next[axis] > between[axis] ? 1 : -1;
        path.push_back(between);
      }
  }
  return path;
}

// All inside samples on a bone's axis; of an axis that passes between the samples of a thin target, the nearest inside one.
std::vector<AxisSample> axis_samples(const Skeleton& skeleton, const Target& target, const std::vector<char>& inside, int bone) {
  const GridShape& shape = target.distance.shape;
  std::vector<std::size_t> found;
  for (const Segment& s : skeleton.shapes[bone].capsules)
    for (const Eigen::Vector3i& c : rasterised(shape, transformed(skeleton.frames[bone], s)))
      if (shape.contains(c) && inside[shape.index(c)]) found.push_back(shape.index(c));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  if (found.empty()) {
    double least = skeleton.shapes[bone].radius + shape.step;
    for (std::size_t i : target.inside) {
      const double d = axis_distance(skeleton, bone, shape.position(i));
      if (d < least) least = d, found.assign(1, i);
    }
  }
  std::vector<AxisSample> samples;
  for (std::size_t i : found) {
    const Eigen::Vector3d p = shape.position(i);
    samples.push_back({i, axis_distance(skeleton, bone, p), rooms_distance(skeleton, bone, p)});
  }
  return samples;
}

// The part of an axis that is not in a child's housing: that belongs to the child. A bone too short for that keeps one sample.
std::vector<AxisSample> own_samples(const std::vector<AxisSample>& all, double room_radius) {
  std::vector<AxisSample> own;
  for (const AxisSample& s : all)
    if (s.from_rooms > room_radius) own.push_back(s);
  if (own.empty() && !all.empty())
    own.push_back(*std::max_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.from_rooms < b.from_rooms; }));
  return own;
}

void claim(std::vector<std::int16_t>& core, const std::vector<std::vector<AxisSample>>& own) {
  std::vector<double> best(core.size(), std::numeric_limits<double>::infinity());
  for (std::size_t bone = 0; bone < own.size(); ++bone)
    for (const AxisSample& s : own[bone])
      if (s.from_axis < best[s.index]) best[s.index] = s.from_axis, core[s.index] = std::int16_t(bone);
}

// A bone whose every sample went to others takes the free or shareable inside sample nearest to its axis.
void rescue(const Character& character, const Skeleton& skeleton, const Target& target, std::vector<std::int16_t>& core,
            const std::vector<std::vector<AxisSample>>& all) {
  std::vector<int> count(all.size(), 0);
  for (std::int16_t b : core)
    if (b >= 0) ++count[b];
  for (std::size_t bone = 0; bone < all.size(); ++bone) {
    if (count[bone] > 0) continue;
    std::size_t chosen = core.size();
    double least = std::numeric_limits<double>::infinity();
    const auto offer = [&](std::size_t i, double cost) {
      if (core[i] >= 0 && count[core[i]] < 2) return;
      if (cost < least) least = cost, chosen = i;
    };
    for (const AxisSample& s : all[bone]) offer(s.index, core[s.index] < 0 ? 0 : s.from_axis);
    if (chosen == core.size())
      for (std::size_t i : target.inside)
        if (core[i] < 0) {
          const double d = axis_distance(skeleton, int(bone), target.distance.shape.position(i));
          if (d < skeleton.shapes[bone].radius + 2 * target.distance.shape.step) offer(i, d);
        }
    if (chosen == core.size())
      throw Infeasible("bone '" + character.bones[bone].name + "' has no room in the target: other bones cover it; move them apart or use a higher resolution");
    if (core[chosen] >= 0) --count[core[chosen]];
    core[chosen] = std::int16_t(bone);
    count[bone] = 1;
  }
}

std::vector<std::size_t> flood(const GridShape& shape, const std::vector<std::int16_t>& core, std::size_t start, std::vector<char>& seen) {
  std::vector<std::size_t> piece{start};
  seen[start] = 1;
  for (std::size_t k = 0; k < piece.size(); ++k)
    for_neighbours(shape, piece[k], [&](std::size_t n) {
      if (core[n] == core[start] && !seen[n]) seen[n] = 1, piece.push_back(n);
    });
  return piece;
}

// Shortest way from `piece` to another sample of the same bone through free inside samples, kept close to the axis.
std::vector<std::size_t> way_out(const Skeleton& skeleton, const Target& target, const std::vector<char>& inside,
                                 const std::vector<std::int16_t>& core, const std::vector<std::size_t>& piece, int bone) {
  const GridShape& shape = target.distance.shape;
  std::vector<double> cost(core.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(core.size(), core.size());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (std::size_t i : piece) cost[i] = 0, open.push({0, i});
  while (!open.empty()) {
    const auto [c, i] = open.top();
    open.pop();
    if (c > cost[i]) continue;
    if (core[i] == bone && c > 0) {
      std::vector<std::size_t> way;
      for (std::size_t k = from[i]; core[k] != bone; k = from[k]) way.push_back(k);
      return way;
    }
    for_neighbours(shape, i, [&](std::size_t n) {
      if (!inside[n] || (core[n] >= 0 && core[n] != bone)) return;
      const double next = c + 1 + axis_distance(skeleton, bone, shape.position(n)) / shape.step;
      if (next < cost[n]) cost[n] = next, from[n] = i, open.push({next, n});
    });
  }
  return {};
}

// Pieces of a bone's core, cut by crossing bones or by the target's outline, are joined or given up.
void join_pieces(const Skeleton& skeleton, const Target& target, const std::vector<char>& inside, std::vector<std::int16_t>& core, int bone) {
  const GridShape& shape = target.distance.shape;
  for (;;) {
    std::vector<char> seen(core.size(), 0);
    std::vector<std::vector<std::size_t>> pieces;
    for (std::size_t i : target.inside)
      if (core[i] == bone && !seen[i]) pieces.push_back(flood(shape, core, i, seen));
    if (pieces.size() < 2) return;
    std::stable_sort(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    const auto way = way_out(skeleton, target, inside, core, pieces.front(), bone);
    if (way.empty())
      for (std::size_t i : pieces.front()) core[i] = -1;
    else
      for (std::size_t i : way) core[i] = std::int16_t(bone);
  }
}

void check_sizes(const Character& character, const Target& target, const Embedding& embedding) {
  if (character.bones.empty()) throw InvalidInput("the character has no bones; give an armature with at least two");
  if (embedding.pose.angles.size() != character.angle_count || embedding.morphology.size() != Eigen::Index(character.bones.size()))
    throw InvalidInput("the embedding belongs to another character (its angles or bone scales do not match); embed this character again");
  if (target.inside.empty() || target.distance.values.size() != target.distance.shape.count())
    throw InvalidInput("the target has no inside samples; use a higher resolution");
}

}  // namespace

Skeleton skeleton_on_lattice(const Character& character, const Target& target, const Embedding& embedding) {
  check_sizes(character, target, embedding);
  Skeleton skeleton{forward_kinematics(character, embedding.pose, embedding.morphology),
                    skeletal_shapes(character, embedding.morphology, 0),
                    std::vector<std::int16_t>(target.distance.shape.count(), -1)};
  const std::vector<char> inside = inside_flags(target);
  const int bones = int(character.bones.size());
  std::vector<std::vector<AxisSample>> all(bones), own(bones);
  for (int b = 0; b < bones; ++b) {
    all[b] = axis_samples(skeleton, target, inside, b);
    if (all[b].empty())
      throw Infeasible("bone '" + character.bones[b].name + "' lies wholly outside the target; embed again, or scale or move the character");
    own[b] = own_samples(all[b], skeleton.shapes[b].room_radius);
  }
  claim(skeleton.core, own);
  rescue(character, skeleton, target, skeleton.core, all);
  for (int b = 0; b < bones; ++b) join_pieces(skeleton, target, inside, skeleton.core, b);
  return skeleton;
}

Skeleton skeleton_of_edited(const Character& character, const Target& target, const Embedding& embedding, const Segmentation& segmentation) {
  if (!segmentation.pinned.empty() && segmentation.pinned.size() != segmentation.owner.size())
    throw InvalidInput("the segmentation's pinned samples belong to another grid; segment again");
  if (!segmentation.inhibited.empty() && segmentation.inhibited.size() != character.bones.size())
    throw InvalidInput("the segmentation's inhibited bones belong to another character; segment again");
  Skeleton skeleton = skeleton_on_lattice(character, target, embedding);
  std::vector<char> present(character.bones.size(), 0);
  for (std::size_t i : target.inside)
    if (segmentation.owner[i] >= 0 && segmentation.owner[i] < int(present.size())) present[segmentation.owner[i]] = 1;
  for (std::size_t i : target.inside) {
    std::int16_t& core = skeleton.core[i];
    if (core >= 0 && !present[core]) core = -1;
    if (segmentation.is_pinned(i) && segmentation.owner[i] >= 0) core = segmentation.owner[i];
  }
  return skeleton;
}

std::vector<std::int16_t> whole_skeletons(const Skeleton& skeleton, const Target& target) {
  const GridShape& shape = target.distance.shape;
  std::vector<std::int16_t> whole = skeleton.core, deepest(whole.size(), -1);
  std::vector<double> least(whole.size(), std::numeric_limits<double>::lowest());   // of samples outside, and in a core: they are not to be had
  std::vector<std::size_t> found;
  for (std::size_t i : target.inside)
    if (whole[i] >= 0) found.push_back(i);
    else least[i] = 0;
  for (int b = 0; b < int(skeleton.shapes.size()); ++b) {
    const auto [low, high] = box_of(skeleton, shape, b);
    Eigen::Vector3i c;
    for (c.z() = low.z(); c.z() <= high.z(); ++c.z())
      for (c.y() = low.y(); c.y() <= high.y(); ++c.y())
        for (c.x() = low.x(); c.x() <= high.x(); ++c.x()) {
          const std::size_t i = shape.index(c);
          if (least[i] < -skeleton.shapes[b].radius) continue;
          const double d = distance_to_bone(skeleton, b, shape.position(c)) + (1 - kProtectedShare) * skeleton.shapes[b].radius;
          if (d < least[i]) least[i] = d, deepest[i] = std::int16_t(b);
        }
  }
  for (std::size_t k = 0; k < found.size(); ++k)
    for_neighbours(shape, found[k], [&](std::size_t n) {
      if (whole[n] < 0 && deepest[n] == whole[found[k]]) whole[n] = deepest[n], found.push_back(n);
    });
  return whole;
}

double distance_to_bone(const Skeleton& skeleton, int bone, const Eigen::Vector3d& p) {
  return skeleton.shapes[bone].distance(skeleton.frames[bone].inverse() * p);
}

bool is_protected(const Skeleton& skeleton, const GridShape& shape, int bone, std::size_t sample) {
  if (skeleton.core[sample] == bone) return true;
  return distance_to_bone(skeleton, bone, shape.position(sample)) <= -(1 - kProtectedShare) * skeleton.shapes[bone].radius;
}

}  // namespace transformables::segmentation_inner
