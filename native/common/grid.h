// Regular grids of samples, and how a value between samples is read.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace transformables {

/// Where the samples of a grid are: sample (i, j, k) stands at origin + step * (i, j, k), in the target's frame.
struct GridShape {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();      ///< samples along x, y, z
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< position of sample (0, 0, 0)
  double step = 1;                                     ///< distance of neighbours, the same along each axis

  std::size_t count() const { return std::size_t(size.x()) * size.y() * size.z(); }
  std::size_t index(int i, int j, int k) const { return (std::size_t(k) * size.y() + j) * size.x() + i; }
  std::size_t index(const Eigen::Vector3i& c) const { return index(c.x(), c.y(), c.z()); }
  Eigen::Vector3i cell(std::size_t index) const {
    const int i = int(index % size.x());
    const std::size_t rest = index / size.x();
    return {i, int(rest % size.y()), int(rest / size.y())};
  }
  bool contains(const Eigen::Vector3i& c) const {
    return (c.array() >= 0).all() && (c.array() < size.array()).all();
  }
  Eigen::Vector3d position(const Eigen::Vector3i& c) const { return origin + step * c.cast<double>(); }
  Eigen::Vector3d position(std::size_t i) const { return position(cell(i)); }
  /// The sample nearest to a point; may lie outside the grid.
  Eigen::Vector3i nearest(const Eigen::Vector3d& p) const {
    return ((p - origin) / step).array().round().matrix().cast<int>();
  }
  bool operator==(const GridShape& o) const { return size == o.size && origin == o.origin && step == o.step; }
};

/// A value at every sample, x fastest.
template <class T>
struct Grid {
  GridShape shape;
  std::vector<T> values;

  Grid() = default;
  Grid(const GridShape& s, T value) : shape(s), values(s.count(), value) {}
  T& operator[](std::size_t i) { return values[i]; }
  const T& operator[](std::size_t i) const { return values[i]; }
  T& at(const Eigen::Vector3i& c) { return values[shape.index(c)]; }
  const T& at(const Eigen::Vector3i& c) const { return values[shape.index(c)]; }
};

/// Trilinear value at a point in the grid's frame; a point outside reads the nearest place on the border.
inline float sample(const Grid<float>& grid, const Eigen::Vector3d& p) {
  const GridShape& s = grid.shape;
  const Eigen::Vector3d q = ((p - s.origin) / s.step)
                                .cwiseMax(0.0)
                                .cwiseMin((s.size.cast<double>().array() - 1.0).matrix());
  const Eigen::Vector3i c = q.cast<int>().cwiseMin((s.size.array() - 2).matrix()).cwiseMax(0);
  const Eigen::Vector3f t = (q - c.cast<double>()).cast<float>();
  const float* v = grid.values.data() + s.index(c);
  const std::size_t dx = s.size.x() > 1, dy = s.size.y() > 1 ? s.size.x() : 0,
                    dz = s.size.z() > 1 ? std::size_t(s.size.x()) * s.size.y() : 0;
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  return mix(mix(mix(v[0], v[dx], t.x()), mix(v[dy], v[dy + dx], t.x()), t.y()),
             mix(mix(v[dz], v[dz + dx], t.x()), mix(v[dz + dy], v[dz + dy + dx], t.x()), t.y()), t.z());
}

}  // namespace transformables
