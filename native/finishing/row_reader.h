// A level set read along rows of a lattice.
#pragma once

#include <algorithm>
#include <vector>

#include "common/grid.h"

namespace transformables::finishing {

/// Trilinear values at rows of a lattice's samples: what does not change along a row is found for all of it at once.
class RowReader {
 public:
  /// Refers to the level set while it lives. @param beyond  what is read outside of its box, and of an empty one
  RowReader(const Grid<float>& phi, const GridShape& lattice, float beyond) : phi_(phi), lattice_(lattice), beyond_(beyond) {}

  /// Samples (first to last, j, k) of the lattice; valid until the next row is read.
  const std::vector<float>& row(int first, int last, int j, int k) {
    values_.assign(std::size_t(last - first + 1), beyond_);
    if (phi_.values.empty()) return values_;
    const Eigen::Vector3i size = phi_.shape.size;
    const Eigen::Vector3d from = (lattice_.position({first, j, k}) - phi_.shape.origin) / phi_.shape.step;
    const double by = lattice_.step / phi_.shape.step;
    if (!within(from.y(), size.y()) || !within(from.z(), size.z())) return values_;
    const auto [cy, ty] = cell_of(from.y(), size.y());
    const auto [cz, tz] = cell_of(from.z(), size.z());
    const float *low = &phi_.values[phi_.shape.index(0, cy, cz)], *high = &phi_.values[phi_.shape.index(0, cy, cz + 1)];
    mixed_.resize(std::size_t(size.x()));
    const int begin = std::clamp(int(from.x()), 0, size.x() - 1), end = std::clamp(int(from.x() + by * (last - first)) + 2, 0, size.x());
    for (int i = begin; i < end; ++i)
      mixed_[std::size_t(i)] = mix(mix(low[i], low[size.x() + i], ty), mix(high[i], high[size.x() + i], ty), tz);
    for (std::size_t n = 0; n < values_.size(); ++n) {
      const double x = from.x() + by * double(n);
      if (!within(x, size.x())) continue;
      const auto [cx, tx] = cell_of(x, size.x());
      values_[n] = mix(mixed_[std::size_t(cx)], mixed_[std::size_t(cx) + 1], tx);
    }
    return values_;
  }

 private:
  struct Place {
    int cell;
    float beyond_it;
  };
  static constexpr double kRounding = 1e-6;
  static bool within(double q, int size) { return q > -kRounding && q < size - 1 + kRounding; }
  static Place cell_of(double q, int size) {
    const double inside = std::clamp(q, 0.0, double(size - 1));
    const int cell = std::min(int(inside), size - 2);
    return {cell, float(inside - cell)};
  }
  static float mix(float a, float b, float w) { return a + (b - a) * w; }

  const Grid<float>& phi_;
  const GridShape& lattice_;
  const float beyond_;
  std::vector<float> values_, mixed_;
};

}  // namespace transformables::finishing
