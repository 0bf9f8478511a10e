#include "folding/overlap.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace transformables::folding {
namespace {

constexpr int kBrick = 4;        // samples along a brick's edge
constexpr float kFar = 1e12f;

/// Squared distances along one line of samples, in place (Felzenszwalb and Huttenlocher 2012).
struct LineTransform {
  std::vector<float> value, bound;
  std::vector<int> parabola;

  void operator()(float* line, std::size_t stride, int n) {
    value.resize(n), parabola.resize(n), bound.resize(n + 1);
    for (int i = 0; i < n; ++i) value[i] = line[i * stride];
    int last = 0;
    parabola[0] = 0, bound[0] = -2 * kFar, bound[1] = kFar;
    for (int q = 1; q < n; ++q) {
      float meet = crossing(q, parabola[last]);
      while (last > 0 && meet <= bound[last]) meet = crossing(q, parabola[--last]);
      parabola[++last] = q;
      bound[last] = meet, bound[last + 1] = kFar;
    }
    bound[last + 1] = kFar;
    for (int q = 0, at = 0; q < n; ++q) {
      while (bound[at + 1] < float(q)) ++at;
      const float d = float(q - parabola[at]);
      line[q * stride] = std::min(kFar, d * d + value[parabola[at]]);
    }
  }

 private:
  float crossing(int q, int p) const {
    const double rise = double(value[q]) + double(q) * q - double(value[p]) - double(p) * p;
    return float(rise / (2.0 * (q - p)));
  }
};

void squared_distances(std::vector<float>& v, const Eigen::Vector3i& size) {
  LineTransform line;
  const std::size_t nx = size.x(), ny = size.y(), nz = size.z();
  for (std::size_t r = 0; r < ny * nz; ++r) line(v.data() + r * nx, 1, int(nx));
  for (std::size_t k = 0; k < nz; ++k)
    for (std::size_t i = 0; i < nx; ++i) line(v.data() + k * nx * ny + i, nx, int(ny));
  for (std::size_t r = 0; r < nx * ny; ++r) line(v.data() + r, nx * ny, int(nz));
}

/// Whether no ball of A's bricks as a whole ever comes within reach of B.
bool never_near(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance) {
  return first_hit(b, motion, a.whole.centre, motion.speed(a.whole.centre, a.whole.radius), 0, tolerance - a.whole.radius) < 0;
}

}  // namespace

Rigid in_lattice_units(const Eigen::Isometry3d& motion, const GridShape& shape) {
  Rigid r;
  r.turn = motion.linear().cast<float>();
  r.shift = ((motion * shape.origin - shape.origin) / shape.step).cast<float>();
  return r;
}

PartField::PartField(const std::vector<std::int16_t>& owner, const GridShape& shape, int bone) {
  Eigen::AlignedBox3i box;
  std::size_t sample = 0;
  for (int k = 0; k < shape.size.z(); ++k)
    for (int j = 0; j < shape.size.y(); ++j)
      for (int i = 0; i < shape.size.x(); ++i, ++sample)
        if (owner[sample] == bone) box.extend(Eigen::Vector3i(i, j, k));
  if (box.isEmpty()) return;
  low_ = box.min() - Eigen::Vector3i::Constant(PartField::kMargin);
  size_ = box.max() + Eigen::Vector3i::Constant(PartField::kMargin + 1) - low_;
  const std::size_t count = std::size_t(size_.x()) * size_.y() * size_.z();
  std::vector<float> outside(count, 0.0f);
  values_.assign(count, kFar);
  for (int k = 0; k < box.sizes().z() + 1; ++k)
    for (int j = 0; j < box.sizes().y() + 1; ++j)
      for (int i = 0; i < box.sizes().x() + 1; ++i) {
        const Eigen::Vector3i c = box.min() + Eigen::Vector3i(i, j, k);
        if (owner[shape.index(c)] != bone) continue;
        const std::size_t at = (std::size_t(k + PartField::kMargin) * size_.y() + j + PartField::kMargin) * size_.x() + i + PartField::kMargin;
        values_[at] = 0, outside[at] = kFar;
      }
  squared_distances(values_, size_);
  squared_distances(outside, size_);
  for (std::size_t i = 0; i < count; ++i)
    values_[i] = values_[i] > 0 ? std::sqrt(values_[i]) - 0.5f : 0.5f - std::sqrt(outside[i]);
}

PartSamples::PartSamples(const std::vector<std::int16_t>& owner, const GridShape& shape, const std::vector<std::size_t>& inside,
                         int bone) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // brick, sample
  const Eigen::Vector3i bricks_along = shape.size / kBrick + Eigen::Vector3i::Ones();
  for (const std::size_t s : inside) {
    if (owner[s] != bone) continue;
    const Eigen::Vector3i b = shape.cell(s) / kBrick;
    order.push_back({(std::uint64_t(b.z()) * bricks_along.y() + b.y()) * bricks_along.x() + b.x(), std::uint32_t(s)});
  }
  std::sort(order.begin(), order.end());
  for (const auto& [brick, s] : order) {
    index.push_back(s);
    points.push_back(shape.cell(s).cast<float>());
  }
  const auto ball = [this](std::size_t first, std::size_t last) {
    Eigen::AlignedBox3f box;
    for (std::size_t i = first; i < last; ++i) box.extend(points[i]);
    Brick b{box.center(), 0, std::uint32_t(first), std::uint32_t(last - first)};
    for (std::size_t i = first; i < last; ++i) b.radius = std::max(b.radius, (points[i] - b.centre).norm());
    return b;
  };
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last < order.size() && order[last].first == order[first].first) ++last;
    bricks.push_back(ball(first, last));
    first = last;
  }
  if (!points.empty()) whole = ball(0, points.size());
}

float PairMotion::speed(const Eigen::Vector3f& p, float radius) const {
  const std::size_t pairs = a_to_b.size() < 2 ? 0 : steady ? 1 : a_to_b.size() - 1;
  float fastest = 0;
  for (std::size_t t = 0; t < pairs; ++t) {
    const float turning = (a_to_b[t + 1].turn - a_to_b[t].turn).norm();  // Frobenius, so not under the spectral norm
    fastest = std::max(fastest, (a_to_b[t + 1](p) - a_to_b[t](p)).norm() + turning * radius);
  }
  return fastest;
}

PairMotion PairMotion::reversed() const {
  PairMotion r;
  r.steady = steady;
  for (const Rigid& m : a_to_b) r.a_to_b.push_back({m.turn.transpose(), -(m.turn.transpose() * m.shift)});
  return r;
}

std::size_t swept_samples(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance, std::vector<char>* hit) {
  if (hit) hit->assign(a.points.size(), 0);
  if (a.points.empty() || b.empty() || never_near(a, b, motion, tolerance)) return 0;
  std::size_t hits = 0;
  for (const auto& brick : a.bricks) {
    const float speed = motion.speed(brick.centre, brick.radius);
    const int from = first_hit(b, motion, brick.centre, speed, 0, tolerance - brick.radius);
    if (from < 0) continue;
    for (std::uint32_t i = brick.first; i < brick.first + brick.count; ++i) {
      if (first_hit(b, motion, a.points[i], speed, from, tolerance) < 0) continue;
      ++hits;
      if (hit) (*hit)[i] = 1;
    }
  }
  return hits;
}

std::size_t overlapping_samples(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) {
  if (a.points.empty() || b.empty() || b.at(a_to_b(a.whole.centre)) > a.whole.radius - tolerance) return 0;
  std::size_t hits = 0;
  for (const auto& brick : a.bricks) {
    if (b.at(a_to_b(brick.centre)) > brick.radius - tolerance) continue;
    for (std::uint32_t i = brick.first; i < brick.first + brick.count; ++i) hits += b.at(a_to_b(a.points[i])) < -tolerance;
  }
  return hits;
}

Parts parts_of(const Segmentation& segmentation, const Target& target) {
  const GridShape& shape = segmentation.shape;
  const int bones = int(segmentation.frames.size());
  constexpr float kNone = std::numeric_limits<float>::max();
  std::vector<float> least(shape.count(), kNone), second(shape.count(), kNone);
  const auto each_sample = [&](int bone, const auto& visit) {
    const Grid<float>& phi = segmentation.phi[bone];
    if (phi.values.empty()) return;
    const Eigen::Vector3i low = shape.nearest(phi.shape.origin);
    for (std::size_t i = 0; i < phi.values.size(); ++i) {
      const Eigen::Vector3i c = low + phi.shape.cell(i);
      if (shape.contains(c)) visit(shape.index(c), phi.values[i]);
    }
  };
  for (int bone = 0; bone < bones; ++bone)
    each_sample(bone, [&](std::size_t s, float v) {
      second[s] = std::min(second[s], std::max(v, least[s]));
      least[s] = std::min(least[s], v);
    });
  Parts parts;
  parts.fields.resize(bones), parts.samples.resize(bones);
  tbb::parallel_for(0, bones, [&](int bone) {
    parts.samples[bone] = PartSamples(segmentation.owner, shape, target.inside, bone);
    parts.fields[bone] = PartField(segmentation.owner, shape, bone);
    std::vector<float> psi(segmentation.phi[bone].values.empty() ? 0 : shape.count(), kNone);
    each_sample(bone, [&](std::size_t s, float v) {
      const float other = v > least[s] ? least[s] : second[s];
      const float apart = other == kNone ? -kNone : (v - other) / 2;
      psi[s] = std::max(apart, target.distance[s]) / float(shape.step);
    });
    if (!psi.empty()) parts.fields[bone].refine(shape, [&](std::size_t s) { return psi[s]; });
  });
  return parts;
}

}  // namespace transformables::folding
