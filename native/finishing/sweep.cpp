#include "finishing/sweep.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace transformables::finishing {

DistanceReader::DistanceReader(const PartField& part, float edge)
    : last_((Eigen::Array4f() << (part.shape().size.array() - 1).cast<float>(), 0.0f).finished()),
      first_(&part.away.values[0].inner),
      dy_(std::size_t(part.shape().size.x())),
      dz_(dy_ * std::size_t(part.shape().size.y())),
      step_(float(part.shape().step)),
      edge_(edge) {}

float DistanceReader::operator()(const Eigen::Array4f& p) const {
  const Eigen::Array4f q = p.max(0.0f).min(last_), inside = q.min(last_ - 1).max(0.0f);
  const Eigen::Array4i c = inside.cast<int>();
  const Eigen::Array4f t = q - c.cast<float>();
  // Two samples that follow each other along x, both distances of each, are read at once.
  const float* first = first_ + 2 * (std::size_t(c[2]) * dz_ + std::size_t(c[1]) * dy_ + std::size_t(c[0]));
  const auto pair_at = [&](std::size_t offset) { return Eigen::Map<const Eigen::Array4f>(first + 2 * offset); };
  const Eigen::Array4f low = pair_at(0) + (pair_at(dy_) - pair_at(0)) * t[1], high = pair_at(dz_) + (pair_at(dz_ + dy_) - pair_at(dz_)) * t[1];
  const Eigen::Array4f both = low + (high - low) * t[2];
  // The greater of two distances, each read between samples by itself, so that the edge where the two surfaces cross stays sharp.
  const float a = both[0] + (both[2] - both[0]) * t[0], b = both[1] + (both[3] - both[1]) * t[0];
  const float within = std::max(a, b) - edge_ * std::max(0.0f, step_ - std::abs(a - b));
  if ((p == q).all()) return within;
  // The box is convex and holds B, so the way round the nearest place of the box bends by a right angle at least.
  const float aside = std::max(within, 0.0f);
  return std::sqrt((p - q).square().sum() * step_ * step_ + aside * aside);
}

namespace {

constexpr int kBrick = 6;
constexpr double kReach = 1.5;   ///< steps beyond the gap to which swept values are known, so that what is carved can be interpolated
constexpr float kTrust = 0.9f;   ///< first-order distances may be too large by a few per cent far out
constexpr float kDepth = 2;      ///< steps inside B from which on a sample is lost anyway

struct Span {
  int first, last;
};

/// How many configurations a point may pass over when it is some length away from mattering.
class Stride {
 public:
  Stride(double travel, int last) : most_(float(last + 1)), by_length_(travel > 0 ? float(last / travel) : std::numeric_limits<float>::max()) {}
  int operator()(float slack) const { return std::max(1, int(std::min(slack * by_length_, most_))); }

 private:
  float most_, by_length_;
};

/// When, within `span`, a ball can be nearer to B than `reach`; conservative advancement of its centre.
template <class Value>
void near_spans(const Span& span, float radius, const Stride& stride, float reach, Value&& value_of, std::vector<Span>& spans) {
  const int dwell = stride(radius / 2);
  for (int k = span.first; k <= span.last;) {
    const float slack = kTrust * value_of(k) - radius - reach;
    if (slack > 0) {
      k += stride(slack);
      continue;
    }
    const int end = std::min(span.last, k + dwell);
    if (!spans.empty() && spans.back().last >= k)
      spans.back().last = end;
    else
      spans.push_back({k, end});
    k = end + 1;
  }
}

/// A sample's least value over some spans, and when.
struct Least {
  float value;
  std::int32_t where = 0;
};

struct Walker {
  const DistanceReader distance;   // to B
  const PairConfigurations& configurations;
  const float cover;

  Least walk(const Eigen::Vector3f& p, const Stride& stride, const std::vector<Span>& spans, const Matter& matter) const {
    Least least{matter.below};
    for (const Span& span : spans)
      for (int k = span.first; k <= span.last;) {
        const float value = distance(configurations(k, p));
        if (value < least.value) {
          least = {value, k};
          if (value < matter.to) return least;
        }
        // The end of a span is looked at, too.
        k = k < span.last ? std::min(k + stride(std::max(2 * cover, kTrust * (value - least.value))), span.last) : k + 1;
      }
    return least;
  }
};

/// Calls f(n, least) for samples of a brick whose least distance over the move matters and is found to be under what matters; until f is false.
/// @param matter_of  of the n-th of the bricks' samples
template <class MatterOf, class F>
void walk_brick(const PartField& a, const Bricks& bricks, std::size_t brick, const Walker& walker, MatterOf&& matter_of, F&& f) {
  const GridShape& shape = a.shape();
  const std::uint32_t first = bricks.first[brick], end = bricks.first[brick + 1];
  float reach = std::numeric_limits<float>::lowest();
  for (std::uint32_t n = first; n < end; ++n) reach = std::max(reach, matter_of(n).below);
  if (reach == std::numeric_limits<float>::lowest()) return;
  const PairMotion& motion = walker.configurations.motion();
  const double half = (kBrick - 1) / 2.0, radius = shape.step * half * std::sqrt(3.0);
  const Eigen::Vector3d centre = (shape.cell(bricks.samples[first]) / kBrick * kBrick).cast<double>().array() + half;
  const int last = walker.configurations.last();
  std::vector<Span> spans;
  const Stride stride(motion.travel(shape.origin + shape.step * centre) + motion.angle * radius, last);
  near_spans({0, last}, float(radius), stride, reach,
             [&](int k) { return walker.distance(walker.configurations(k, centre.cast<float>())); }, spans);
  if (spans.empty()) return;
  for (std::uint32_t n = first; n < end; ++n) {
    const Matter matter = matter_of(n);
    if (matter.below == std::numeric_limits<float>::lowest()) continue;
    const Eigen::Vector3i c = shape.cell(bricks.samples[n]);
    const Least least = walker.walk(c.cast<float>(), Stride(motion.travel(shape.position(c)), last), spans, matter);
    if (least.value < matter.below && !f(n, least)) return;
  }
}

}  // namespace

PairConfigurations::PairConfigurations(const MoveMotion& motion, const PartField& a, const PartField& b)
    : motion_(motion.pair(a.bone, b.bone)), maps_(motion.last() + 1) {
  const GridShape &from = a.shape(), &to = b.shape();
  tbb::parallel_for(0, motion.last() + 1, [&](int k) {
    const Eigen::Isometry3d rigid = motion.into(a.bone, b.bone, k);
    maps_[k].setZero();
    maps_[k].topLeftCorner<3, 3>() = rigid.linear().cast<float>();
    maps_[k].topRightCorner<3, 1>() = ((rigid * from.origin - to.origin) / to.step).cast<float>();
  });
}

bool PairConfigurations::can_meet(const MoveMotion& motion, const PartField& a, const PartField& b, double reach) {
  const PairMotion pair = motion.pair(a.bone, b.bone);
  if (!pair.moves) return false;
  const GridShape &from = a.shape(), &to = b.shape();
  const Eigen::Vector3d half = from.step * (from.size.cast<double>().array() - 1).matrix() / 2;
  const Eigen::Vector3d centre = from.origin + half;
  const DistanceReader distance(b);
  std::vector<Span> spans;
  near_spans({0, motion.last()}, float(half.norm()), Stride(pair.travel(centre), motion.last()), float(reach), [&](int k) {
    const Eigen::Vector3f p = ((motion.into(a.bone, b.bone, k) * centre - to.origin) / to.step).cast<float>();
    return distance({p.x(), p.y(), p.z(), 0});
  }, spans);
  return !spans.empty();
}

double reach_of(const Lattice& lattice, double gap) { return gap + kReach * lattice.step(); }

Bricks bricks_of(const PartField& part, double reach, const std::vector<char>& mask) {
  const GridShape& shape = part.shape();
  const Eigen::Vector3i count = (shape.size.array() + kBrick - 1) / kBrick;
  std::vector<std::vector<std::uint32_t>> all(std::size_t(count.prod()));
  std::size_t n = 0;
  for (int k = 0; k < shape.size.z(); ++k)
    for (int j = 0; j < shape.size.y(); ++j)
      for (int i = 0; i < shape.size.x(); ++i, ++n)
        if (part.bound(n) < reach && (mask.empty() || mask[n]))
          all[std::size_t((k / kBrick * count.y() + j / kBrick) * count.x() + i / kBrick)].push_back(std::uint32_t(n));
  Bricks bricks{{}, {0}};
  for (const auto& brick : all) {
    if (brick.empty()) continue;
    bricks.samples.insert(bricks.samples.end(), brick.begin(), brick.end());
    bricks.first.push_back(std::uint32_t(bricks.samples.size()));
  }
  return bricks;
}

Swept sweep(const PartField& a, const Bricks& bricks, const PartField& b, const PairConfigurations& configurations, double cover, double reach,
            float edge, const std::vector<Matter>& matters) {
  Swept swept{std::vector<float>(bricks.samples.size(), float(reach)), std::vector<std::int32_t>(bricks.samples.size(), 0), float(reach)};
  const Walker walker{DistanceReader(b, edge), configurations, float(cover)};
  const Matter all{float(reach), float(-kDepth * a.shape().step)}, none{std::numeric_limits<float>::lowest(), 0};
  tbb::parallel_for(std::size_t(0), bricks.first.size() - 1, [&](std::size_t brick) {
    const auto matter_of = [&](std::uint32_t n) {
      if (a.bound(bricks.samples[n]) >= reach) return none;
      return matters.empty() ? all : Matter{std::min(matters[n].below, all.below), std::max(matters[n].to, all.to)};
    };
    walk_brick(a, bricks, brick, walker, matter_of, [&](std::uint32_t n, const Least& least) {
      swept.least[n] = least.value;
      swept.where[n] = least.where;
      return true;
    });
  });
  return swept;
}

bool any_nearer(const PartField& a, const Bricks& bricks, const PartField& b, const PairConfigurations& configurations, double cover,
                const std::vector<float>& below) {
  const Walker walker{DistanceReader(b), configurations, float(cover)};
  std::atomic<bool> found = false;
  tbb::parallel_for(std::size_t(0), bricks.first.size() - 1, [&](std::size_t brick) {
    if (found) return;
    walk_brick(a, bricks, brick, walker, [&](std::uint32_t n) { return Matter{below[n], below[n]}; },
               [&](std::uint32_t, const Least&) { return !(found = true); });
  });
  return found;
}

}  // namespace transformables::finishing
