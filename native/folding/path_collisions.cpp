#include "folding/path_collisions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <compare>
#include <span>

#include "folding/cores.h"

namespace transformables::folding {
namespace {

constexpr int kBrick = 4, kBlock = 4 * kBrick;  // samples along the edges of bricks of samples that are looked at together, and of blocks of bricks
constexpr float kUneven = 0.1f;                  // steps by which an interpolated distance may change more than the way between two points

struct Ball {
  Eigen::Vector3f centre;
  float radius = 0;
};

Ball ball_about(std::span<const Eigen::Vector3f> points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  Ball ball{box.center()};
  for (const Eigen::Vector3f& p : points) ball.radius = std::max(ball.radius, (p - ball.centre).norm());
  return ball;
}

/// The last one again and again where there are fewer.
std::vector<EightPlaces> in_eights(std::span<const Eigen::Vector3f> points) {
  std::vector<EightPlaces> eights((points.size() + 7) / 8);
  for (std::size_t i = 0; i < 8 * eights.size(); ++i) {
    const Eigen::Vector3f& p = points[std::min(i, points.size() - 1)];
    EightPlaces& eight = eights[i / 8];
    eight.x[i % 8] = p.x(), eight.y[i % 8] = p.y(), eight.z[i % 8] = p.z();
  }
  return eights;
}

/// Where each run of equal `of(place)` begins among `count` places, and the end.
template <class Of>
std::vector<std::size_t> runs(std::size_t count, const Of& of) {
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < count; ++i)
    if (i == 0 || of(i) != of(i - 1)) first.push_back(i);
  first.push_back(count);
  return first;
}

}  // namespace

PathCollisions::PathCollisions(const Design& design, const std::vector<char>& present, const std::vector<SampledMove>& moves, float tolerance)
    : shape_(design.segmentation.shape), skeletons_(skeletons_of(design)), tolerance_(tolerance), encounters_(present.size()), fields_(present.size()), grown_(present.size(), 0) {
  const int bones = int(present.size());
  for (const SampledMove& move : moves)
    for (int a = 0; a < bones; ++a)
      for (int b = 0; b < bones; ++b)
        if (a != b && move.group(a) != move.group(b) && present[a] && present[b]) encounters_[a].push_back({b, move.pair(a, b)});
}

/// The encounters of a bone that are not ruled out for a ball about all the points.
std::vector<const PathCollisions::Encounter*> PathCollisions::near(std::span<const Eigen::Vector3f> points, int bone) const {
  const Ball ball = ball_about(points);
  std::vector<const Encounter*> result;
  for (const Encounter& e : encounters_[bone]) {
    const PartField& field = fields_[e.other];
    if (!field.empty() && first_hit(field, e.motion, ball.centre, e.motion.speed(ball.centre, ball.radius), 0, tolerance_ - ball.radius - kUneven - float(grown_[std::size_t(e.other)])) >= 0)
      result.push_back(&e);
  }
  return result;
}

/// Most of the encounters left are ruled out for a ball about all samples of a brick; the others are looked at for each.
void PathCollisions::hits_of_brick(std::span<const Eigen::Vector3f> points, const std::vector<const Encounter*>& encounters, int enough, std::span<int> found) const {
  const Ball ball = ball_about(points);
  const std::vector<EightPlaces> eights = in_eights(points);
  std::size_t open = points.size();
  for (const Encounter* e : encounters) {
    if (open == 0) return;
    const PartField& field = fields_[e->other];
    const float speed = e->motion.speed(ball.centre, ball.radius);
    const int from = first_hit(field, e->motion, ball.centre, speed, 0, tolerance_ - ball.radius);
    if (from < 0) continue;
    for (std::size_t first = 0; first < points.size(); first += 8) {
      std::uint32_t asked = 0;
      for (std::size_t n = 0; n < std::min<std::size_t>(8, points.size() - first); ++n) asked |= std::uint32_t(found[first + n] < enough) << n;
      if (asked == 0) continue;
      for (std::uint32_t met = ever_deeper(field, e->motion, eights[first / 8], asked, speed, from, tolerance_); met; met &= met - 1)
        if (++found[first + std::size_t(std::countr_zero(met))] == enough) --open;
    }
  }
}

/// Samples in bricks, and what they may meet, block by block.
struct PathCollisions::Grouped {
  std::vector<std::uint32_t> place;        // of each point in what was asked for
  std::vector<Eigen::Vector3f> points;
  std::vector<std::size_t> blocks, bricks; // where each begins, and the end
  std::vector<std::vector<const Encounter*>> near_block;
};

PathCollisions::Grouped PathCollisions::grouped(const std::vector<std::uint32_t>& samples, int bone) const {
  const auto place_of = [&](const Eigen::Vector3i& b) {
    return (std::uint64_t(b.z()) * std::uint64_t(shape_.size.y()) + std::uint64_t(b.y())) * std::uint64_t(shape_.size.x()) + std::uint64_t(b.x());
  };
  struct Place {
    std::uint64_t block, brick;
    std::uint32_t sample;   // place in `samples`
    auto operator<=>(const Place&) const = default;
  };
  std::vector<Place> order;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3i c = shape_.cell(samples[i]);
    order.push_back({place_of(c / kBlock), place_of(c / kBrick), std::uint32_t(i)});
  }
  std::sort(order.begin(), order.end());
  Grouped all;
  for (const Place& p : order) all.place.push_back(p.sample), all.points.push_back(shape_.cell(samples[p.sample]).cast<float>());
  all.blocks = runs(order.size(), [&](std::size_t i) { return order[i].block; });
  all.bricks = runs(order.size(), [&](std::size_t i) { return order[i].brick; });
  all.near_block.resize(all.blocks.size() - 1);
  tbb::parallel_for(std::size_t(0), all.near_block.size(), [&](std::size_t k) {
    all.near_block[k] = near(std::span(all.points).subspan(all.blocks[k], all.blocks[k + 1] - all.blocks[k]), bone);
  });
  return all;
}

std::vector<int> PathCollisions::hits(const Grouped& samples, int enough) const {
  const auto& [place, points, blocks, bricks, near_block] = samples;
  std::vector<int> found(points.size(), 0);
  tbb::parallel_for(std::size_t(0), bricks.size() - 1, [&, &points = points, &blocks = blocks, &bricks = bricks, &near_block = near_block](std::size_t b) {
    const std::size_t first = bricks[b], count = bricks[b + 1] - first;
    const std::size_t block = std::size_t(std::upper_bound(blocks.begin(), blocks.end(), first) - blocks.begin()) - 1;
    hits_of_brick(std::span(points).subspan(first, count), near_block[block], enough, std::span(found).subspan(first, count));
  });
  std::vector<int> result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) result[place[i]] = found[i];
  return result;
}

std::vector<int> PathCollisions::hits(const std::vector<std::uint32_t>& samples, int bone, int enough) const { return hits(grouped(samples, bone), enough); }

std::vector<int> PathCollisions::hits(const std::vector<std::uint32_t>& samples, int bone, int enough, const std::vector<std::int16_t>& owner) {
  const Grouped all = grouped(samples, bone);
  std::vector<char> met(fields_.size(), 0);
  for (const auto& encounters : all.near_block)
    for (const Encounter* e : encounters) met[std::size_t(e->other)] = 1;
  tbb::parallel_for(std::size_t(0), fields_.size(), [&](std::size_t b) {
    if (met[b] && grown_[b] > 0) set_part(owner, int(b));
  });
  return hits(all, enough);
}

void PathCollisions::refresh(const std::vector<std::int16_t>& owner) {
  tbb::parallel_for(std::size_t(0), fields_.size(), [&](std::size_t b) {
    if (grown_[b] > 0) set_part(owner, int(b));
  });
}

}  // namespace transformables::folding
