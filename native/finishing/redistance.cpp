// Signed distance from any level set, by fast sweeping.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "finishing/part_field.h"

namespace transformables::finishing {
namespace {

constexpr float kFar = 1e9f;

/// Distance to the surface of a sample beside it, in steps, from where the axes cross it; kFar when it is not beside it.
float beside_surface(const Grid<float>& psi, int i, int j, int k) {
  const GridShape& s = psi.shape;
  const std::size_t here = s.index(i, j, k);
  const std::array<std::size_t, 3> stride{1, std::size_t(s.size.x()), std::size_t(s.size.x()) * s.size.y()};
  const std::array<int, 3> at{i, j, k};
  const float value = psi[here];
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float nearest = kFar;
    const auto look = [&](float other) {
      if ((value < 0) != (other < 0)) nearest = std::min(nearest, value / (value - other));
    };
    if (at[axis] > 0) look(psi[here - stride[axis]]);
    if (at[axis] + 1 < s.size[axis]) look(psi[here + stride[axis]]);
    if (nearest < kFar) sum += 1 / std::max(nearest * nearest, 1e-8f);
  }
  return sum > 0 ? 1 / std::sqrt(sum) : kFar;
}

/// The eikonal equation's solution at a sample from the least of its neighbours along each axis, in steps.
float solve(float a, float b, float c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  float d = a + 1;
  if (d <= b) return d;
  d = 0.5f * (a + b + std::sqrt(std::max(0.0f, 2 - (a - b) * (a - b))));
  if (d <= c) return d;
  const float sum = a + b + c;
  return (sum + std::sqrt(std::max(0.0f, sum * sum - 3 * (a * a + b * b + c * c - 1)))) / 3;
}

void sweep(Grid<float>& d, const std::vector<char>& fixed, int direction) {
  const Eigen::Vector3i n = d.shape.size;
  const std::size_t sy = std::size_t(n.x()), sz = sy * n.y();
  const auto order = [](int t, int count, bool backward) { return backward ? count - 1 - t : t; };
  for (int tk = 0; tk < n.z(); ++tk) {
    const int k = order(tk, n.z(), direction & 4);
    for (int tj = 0; tj < n.y(); ++tj) {
      const int j = order(tj, n.y(), direction & 2);
      for (int ti = 0; ti < n.x(); ++ti) {
        const int i = order(ti, n.x(), direction & 1);
        const std::size_t here = std::size_t(k) * sz + std::size_t(j) * sy + i;
        if (fixed[here]) continue;
        const float x = std::min(i > 0 ? d[here - 1] : kFar, i + 1 < n.x() ? d[here + 1] : kFar);
        const float y = std::min(j > 0 ? d[here - sy] : kFar, j + 1 < n.y() ? d[here + sy] : kFar);
        const float z = std::min(k > 0 ? d[here - sz] : kFar, k + 1 < n.z() ? d[here + sz] : kFar);
        if (std::min({x, y, z}) + 1 <= d[here]) d[here] = std::min(d[here], solve(x, y, z));
      }
    }
  }
}

}  // namespace

Grid<float> redistanced(const Grid<float>& psi) {
  const GridShape& s = psi.shape;
  Grid<float> d(s, kFar);
  std::vector<char> fixed(s.count(), 0);
  for (int k = 0; k < s.size.z(); ++k)
    for (int j = 0; j < s.size.y(); ++j)
      for (int i = 0; i < s.size.x(); ++i) {
        const float near = beside_surface(psi, i, j, k);
        if (near >= kFar) continue;
        d[s.index(i, j, k)] = near;
        fixed[s.index(i, j, k)] = 1;
      }
  for (int direction = 0; direction < 8; ++direction) sweep(d, fixed, direction);
  const float step = float(s.step);
  for (std::size_t n = 0; n < d.values.size(); ++n)
    d[n] = psi[n] < 0 ? -std::min(d[n], kFar) * step : std::min(d[n], kFar) * step;
  return d;
}

std::size_t inside_count(const Grid<float>& psi) {
  return std::size_t(std::count_if(psi.values.begin(), psi.values.end(), [](float v) { return v < 0; }));
}

}  // namespace transformables::finishing
