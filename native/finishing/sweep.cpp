#include "finishing/sweep.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

constexpr int kBrick = 8;
constexpr float kTrust = 0.9f;   ///< first-order distances may be too large by a few per cent far out
constexpr float kDepth = 2;      ///< steps inside B from which on a sample is lost anyway

struct Span {
  int first, last;
};

/// Steps that a point may skip when it is `slack` away from mattering.
int stride_for(double slack, double travel, int last) {
  const double steps = travel > 0 ? slack * last / travel : last;
  return std::max(1, int(std::min(steps, double(last) + 1)));
}

/// When, within `span`, a ball can be nearer to B than `reach`; conservative advancement of its centre.
template <class Value>
void near_spans(const Span& span, double radius, double travel, double reach, int last, Value&& value_of, std::vector<Span>& spans) {
  const int dwell = stride_for(radius / 2, travel, last);
  for (int k = span.first; k <= span.last;) {
    const double slack = kTrust * value_of(k) - radius - reach;
    if (slack > 0) {
      k += stride_for(slack, travel, last);
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

/// One sample's least value over some spans.
struct Walker {
  const Grid<float>& field;
  const PairConfigurations& configurations;
  float cover, reach, floor;

  void walk(const Eigen::Vector3f& p, double travel, const std::vector<Span>& spans, float& least, std::int32_t& where) const {
    const int last = configurations.last();
    for (const Span& span : spans)
      for (int k = span.first; k <= span.last;) {
        const float value = value_at(field, configurations(k, p));
        if (value < least) {
          least = value;
          where = k;
          if (least < floor) return;
        }
        const int stride = stride_for(std::max(2 * cover, kTrust * (value - least)), travel, last);
        // The end of a span is looked at, too.
        k = k < span.last ? std::min(k + stride, span.last) : k + 1;
      }
  }
};

}  // namespace

float value_at(const Grid<float>& field, const Eigen::Vector3f& p) {
  const Eigen::Vector3i& n = field.shape.size;
  const Eigen::Vector3f q = p.cwiseMax(0.0f).cwiseMin((n.cast<float>().array() - 1).matrix());
  const Eigen::Vector3i c = q.cast<int>().cwiseMin((n.array() - 2).matrix());
  const Eigen::Vector3f t = q - c.cast<float>();
  const std::size_t dy = std::size_t(n.x()), dz = dy * n.y();
  const float* v = field.values.data() + field.shape.index(c);
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  const float inner = mix(mix(mix(v[0], v[1], t.x()), mix(v[dy], v[dy + 1], t.x()), t.y()),
                          mix(mix(v[dz], v[dz + 1], t.x()), mix(v[dz + dy], v[dz + dy + 1], t.x()), t.y()), t.z());
  const float beyond2 = (p - q).squaredNorm();
  if (beyond2 == 0) return inner;
  // The box is convex and holds B, so the way round the nearest place of the box bends by a right angle at least.
  const float step = float(field.shape.step);
  return std::sqrt(beyond2 * step * step + std::max(inner, 0.0f) * std::max(inner, 0.0f));
}

PairConfigurations::PairConfigurations(const MoveMotion& motion, const PartField& a, const PartField& b)
    : motion_(motion.pair(a.bone, b.bone)), maps_(motion.last() + 1) {
  const GridShape &from = a.shape(), &to = b.shape();
  tbb::parallel_for(0, motion.last() + 1, [&](int k) {
    const Eigen::Isometry3d rigid = motion.into(a.bone, b.bone, k);
    maps_[k].leftCols<3>() = rigid.linear().cast<float>();
    maps_[k].col(3) = ((rigid * from.origin - to.origin) / to.step).cast<float>();
  });
}

bool PairConfigurations::can_meet(const MoveMotion& motion, const PartField& a, const PartField& b, double reach) {
  const PairMotion pair = motion.pair(a.bone, b.bone);
  if (!pair.moves) return false;
  const GridShape &from = a.shape(), &to = b.shape();
  const Eigen::Vector3d half = from.step * (from.size.cast<double>().array() - 1).matrix() / 2;
  const Eigen::Vector3d centre = from.origin + half;
  std::vector<Span> spans;
  near_spans({0, motion.last()}, half.norm(), pair.travel(centre), reach, motion.last(), [&](int k) {
    const Eigen::Vector3d p = (motion.into(a.bone, b.bone, k) * centre - to.origin) / to.step;
    return value_at(b.distance, p.cast<float>());
  }, spans);
  return !spans.empty();
}

Swept sweep(const PartField& a, const Grid<float>& field_b, const PairConfigurations& configurations, double cover, double reach,
            const std::vector<char>& mask) {
  const GridShape& shape = a.shape();
  Swept swept{std::vector<float>(shape.count(), float(reach)), std::vector<std::int32_t>(shape.count(), 0), float(reach)};
  const Walker walker{field_b, configurations, float(cover), float(reach), float(-kDepth * shape.step)};
  const Eigen::Vector3i bricks = (shape.size.array() + kBrick - 1) / kBrick;
  const PairMotion& motion = configurations.motion();
  tbb::parallel_for(0, bricks.prod(), [&](int brick) {
    const Eigen::Vector3i low = kBrick * Eigen::Vector3i(brick % bricks.x(), brick / bricks.x() % bricks.y(), brick / (bricks.x() * bricks.y()));
    const Eigen::Vector3i high = (low.array() + kBrick).min(shape.size.array()) - 1;
    const auto for_each_kept = [&](auto&& f) {
      for (int k = low.z(); k <= high.z(); ++k)
        for (int j = low.y(); j <= high.y(); ++j)
          for (int i = low.x(); i <= high.x(); ++i)
            if (const std::size_t n = shape.index(i, j, k); a.distance[n] < reach && (mask.empty() || mask[n])) f(Eigen::Vector3i(i, j, k));
    };
    bool any = false;
    for_each_kept([&](const Eigen::Vector3i&) { any = true; });
    if (!any) return;
    const Eigen::Vector3d half = (high - low).cast<double>() / 2, centre = low.cast<double>() + half;
    const double radius = shape.step * half.norm();
    std::vector<Span> spans;
    near_spans({0, configurations.last()}, radius, motion.travel(shape.origin + shape.step * centre) + motion.angle * radius, reach,
               configurations.last(), [&](int k) { return value_at(field_b, configurations(k, centre.cast<float>())); }, spans);
    if (spans.empty()) return;
    for_each_kept([&](const Eigen::Vector3i& c) {
      const std::size_t n = shape.index(c);
      walker.walk(c.cast<float>(), motion.travel(shape.position(c)), spans, swept.least[n], swept.where[n]);
    });
  });
  return swept;
}

}  // namespace transformables::finishing
