#include "folding/cores.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace transformables::folding {

namespace {

constexpr double kShare = 0.9;  // of a skeletal shape's radius

/// Calls f(sample, signed distance in steps) for samples of the grid at a bone's skeletal shape or in it.
template <class F>
void for_each_near(const Design& design, const SkeletalShape& skeleton, std::size_t bone, F&& f) {
  constexpr double kNear = 2;   // steps
  const GridShape& shape = design.segmentation.shape;
  const Eigen::Isometry3d &frame = design.segmentation.frames[bone], into = frame.inverse();
  Eigen::AlignedBox3d box;
  for (const Segment& s : skeleton.capsules) box.extend(frame * s.a), box.extend(frame * s.b);
  if (box.isEmpty()) return;
  const double reach = skeleton.radius + kNear * shape.step;
  const Eigen::Vector3i low = shape.nearest(box.min().array() - reach).cwiseMax(0);
  const Eigen::Vector3i high = shape.nearest(box.max().array() + reach).cwiseMin(shape.size - Eigen::Vector3i::Ones());
  for (int k = low.z(); k <= high.z(); ++k)
    for (int j = low.y(); j <= high.y(); ++j)
      for (int i = low.x(); i <= high.x(); ++i)
        if (const double d = skeleton.distance(into * shape.position({i, j, k})) / shape.step; d < kNear) f(Eigen::Vector3i(i, j, k), d);
}

}  // namespace

Skeletons skeletons_of(const Design& design) {
  constexpr float kTolerance = 0.25f;   // steps
  const auto& [character, segmentation, target, embedding] = design;
  const GridShape& shape = segmentation.shape;
  const std::vector<SkeletalShape> shapes = skeletal_shapes(character, embedding.morphology, 0);
  std::vector<char> present(shapes.size(), 0);
  for (const std::size_t s : target.inside) present[std::size_t(segmentation.owner[s])] = 1;
  Skeletons skeletons{std::vector<std::int16_t>(shape.count(), -1), std::vector<std::vector<std::pair<Eigen::Vector3i, float>>>(shapes.size())};
  std::vector<float> least(shape.count(), 0);
  for (std::size_t bone = 0; bone < shapes.size(); ++bone) {
    if (!present[bone]) continue;
    for_each_near(design, shapes[bone], bone, [&](const Eigen::Vector3i& c, double d) {
      const std::size_t s = shape.index(c);
      const float outer = target.distance[s] / float(shape.step), depth = float(d + (1 - kShare) * shapes[bone].radius / shape.step);
      skeletons.near[bone].push_back({c, std::max(float(d), outer) - kTolerance});
      if (outer < 0 && depth < least[s]) least[s] = depth, skeletons.bone[s] = std::int16_t(bone);
    });
  }
  return skeletons;
}

Segmentation with_skeletons(const Design& design) {
  const Segmentation& given = design.segmentation;
  const std::vector<std::int16_t> bone = skeletons_of(design).bone;
  Segmentation changed = given;
  if (changed.pinned.empty()) changed.pinned.assign(given.owner.size(), 0);
  bool any = false;
  for (const std::size_t s : design.target.inside) {
    if (bone[s] < 0 || given.is_pinned(s)) continue;
    any = any || bone[s] != given.owner[s];
    changed.owner[s] = bone[s], changed.pinned[s] = 1;
  }
  return any ? retiled(changed, design.character, design.target, design.embedding) : changed;
}

std::vector<std::int16_t> cores_of(const Design& design) {
  const auto& [character, segmentation, target, embedding] = design;
  const std::vector<SkeletalShape> shapes = skeletal_shapes(character, embedding.morphology, 0);
  std::vector<std::int16_t> core(segmentation.owner.size(), -1);
  std::vector<float> depth(target.inside.size());
  tbb::parallel_for(std::size_t(0), target.inside.size(), [&](std::size_t i) {
    const std::size_t s = target.inside[i];
    const int bone = segmentation.owner[s];
    const double d = shapes[bone].distance(segmentation.frames[bone].inverse() * segmentation.shape.position(s));
    depth[i] = float(d + (1 - kShare) * shapes[bone].radius);
    if (depth[i] < 0 || segmentation.is_pinned(s)) core[s] = std::int16_t(bone);
  });
  // A capsule can be thinner than the lattice: its nearest sample stands for it then.
  std::vector<float> least(character.bones.size(), std::numeric_limits<float>::max());
  std::vector<std::size_t> nearest(character.bones.size(), 0);
  for (std::size_t i = 0; i < target.inside.size(); ++i) {
    const int bone = segmentation.owner[target.inside[i]];
    if (depth[i] < least[bone]) least[bone] = depth[i], nearest[bone] = target.inside[i];
  }
  for (std::size_t b = 0; b < least.size(); ++b)
    if (least[b] < std::numeric_limits<float>::max()) core[nearest[b]] = std::int16_t(b);
  return core;
}

}  // namespace transformables::folding
