#include "folding/path_collisions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "folding/cores.h"

namespace transformables::folding {
namespace {

constexpr int kBrick = 4;  // samples along the edge of a brick of samples that are looked at together

}  // namespace

PathCollisions::PathCollisions(const Design& design, const std::vector<char>& present, const std::vector<SampledMove>& moves, float tolerance)
    : shape_(design.segmentation.shape), skeletons_(skeletons_of(design)), tolerance_(tolerance), encounters_(present.size()), fields_(present.size()) {
  const int bones = int(present.size());
  for (const SampledMove& move : moves)
    for (int a = 0; a < bones; ++a)
      for (int b = 0; b < bones; ++b)
        if (a != b && move.group(a) != move.group(b) && present[a] && present[b]) encounters_[a].push_back({b, move.pair(a, b)});
}

/// Most encounters are ruled out for a ball about all samples of a brick; the others are looked at for each.
void PathCollisions::hits_of_brick(const std::vector<Eigen::Vector3f>& points, int bone, int enough, std::vector<int>& found) const {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  const Eigen::Vector3f centre = box.center();
  float radius = 0;
  for (const Eigen::Vector3f& p : points) radius = std::max(radius, (p - centre).norm());
  std::size_t open = points.size();
  for (const Encounter& e : encounters_[bone]) {
    if (open == 0) return;
    const PartField& field = fields_[e.other];
    if (field.empty()) continue;
    const float speed = e.motion.speed(centre, radius);
    const int from = first_hit(field, e.motion, centre, speed, 0, tolerance_ - radius);
    if (from < 0) continue;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (found[i] >= enough || first_hit(field, e.motion, points[i], speed, from, tolerance_) < 0) continue;
      if (++found[i] == enough) --open;
    }
  }
}

std::vector<int> PathCollisions::hits(const std::vector<std::uint32_t>& samples, int bone, int enough) const {
  const auto brick_of = [&](std::uint32_t s) -> std::uint64_t {
    const Eigen::Vector3i b = shape_.cell(s) / kBrick;
    return (std::uint64_t(b.z()) * std::uint64_t(shape_.size.y()) + std::uint64_t(b.y())) * std::uint64_t(shape_.size.x()) + std::uint64_t(b.x());
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // brick, place in `samples`
  for (std::size_t i = 0; i < samples.size(); ++i) order.push_back({brick_of(samples[i]), std::uint32_t(i)});
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < order.size(); ++i)
    if (i == 0 || order[i].first != order[i - 1].first) first.push_back(i);
  std::vector<int> result(samples.size(), 0);
  tbb::parallel_for(std::size_t(0), first.size(), [&](std::size_t b) {
    const std::size_t end = b + 1 < first.size() ? first[b + 1] : order.size();
    std::vector<Eigen::Vector3f> points;
    for (std::size_t i = first[b]; i < end; ++i) points.push_back(shape_.cell(samples[order[i].second]).cast<float>());
    std::vector<int> found(points.size(), 0);
    hits_of_brick(points, bone, enough, found);
    for (std::size_t i = first[b]; i < end; ++i) result[order[i].second] = found[i - first[b]];
  });
  return result;
}

}  // namespace transformables::folding
