// Signed distance from any level set, by fast sweeping.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "finishing/part_field.h"

namespace transformables::finishing {
namespace {

constexpr float kFar = 1e9f;
constexpr float kDeepest = 4;     ///< steps: deeper inside nobody asks how deep
constexpr float kFarthest = 20;   ///< steps: farther away a lower bound does as well

/// Which flags of a row differ from one beside them, in the row or in others.
void mark_changes(std::span<const char> row, const std::array<const char*, 4>& others, std::vector<char>& differs) {
  std::fill(differs.begin(), differs.end(), 0);
  for (const char* other : others)
    for (std::size_t i = 0; other && i < row.size(); ++i) differs[i] |= char(row[i] ^ other[i]);
  for (std::size_t i = 0; i + 1 < row.size(); ++i) differs[i] |= char(row[i] ^ row[i + 1]);
  for (std::size_t i = 1; i < row.size(); ++i) differs[i] |= char(row[i] ^ row[i - 1]);
}

bool differ(float a, float b) { return (a < 0) != (b < 0); }

/// Distance to the surface of a sample beside it, in steps, from where the axes cross it; kFar when it is not beside it.
/// @param v     the sample's value
/// @param low, high  along each axis, whether there is a neighbour below, above
float beside_surface(const float* v, const std::array<std::size_t, 3>& stride, const std::array<bool, 3>& low, const std::array<bool, 3>& high) {
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float nearest = kFar;
    const auto look = [&](float other) {
      if (differ(*v, other)) nearest = std::min(nearest, *v / (*v - other));
    };
    if (low[axis]) look(*(v - stride[axis]));
    if (high[axis]) look(v[stride[axis]]);
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

/// Sweeps row by row: what does not change along a row is found for all of it at once, and most rows have nothing to do after the first sweeps.
class Sweeper {
 public:
  Sweeper(Grid<float>& d, const std::vector<char>& fixed)
      : d_(d), fixed_(fixed), nx_(d.shape.size.x()), ny_(d.shape.size.y()), nz_(d.shape.size.z()), beyond_(Row::Constant(nx_, kFar)), least_(nx_), most_(nx_) {}

  void run() {
    // Four orders of the rows, and in each both ways along a row.
    for (int direction = 0; direction < 4; ++direction)
      for (int tk = 0; tk < nz_; ++tk)
        for (int tj = 0; tj < ny_; ++tj) row(direction & 1 ? ny_ - 1 - tj : tj, direction & 2 ? nz_ - 1 - tk : tk);
  }

 private:
  using Row = Eigen::ArrayXf;

  void row(int j, int k) {
    const std::ptrdiff_t nx = nx_, slice = nx * ny_, first = k * slice + j * nx;
    float* d = d_.values.data() + first;
    const auto at = [&](bool there, std::ptrdiff_t offset) { return Eigen::Map<const Row>(there ? d + offset : beyond_.data(), nx); };
    const auto before = at(j > 0, -nx), after = at(j + 1 < ny_, nx), under = at(k > 0, -slice), over = at(k + 1 < nz_, slice);
    least_ = before.min(after);
    most_ = under.min(over);
    const Eigen::Map<const Row> now(d, nx);
    const auto inner = [&](int offset) { return now.segment(offset, nx - 1); };
    if (!(least_.min(most_) + 1 <= now).any() && !(inner(0) + 1 <= inner(1)).any() && !(inner(1) + 1 <= inner(0)).any()) return;
    const auto look = [&](int i) {
      const float x = std::min(i > 0 ? d[i - 1] : kFar, i + 1 < nx_ ? d[i + 1] : kFar);
      if (!fixed_[std::size_t(first + i)] && std::min({x, least_[i], most_[i]}) + 1 <= d[i]) d[i] = std::min(d[i], solve(x, least_[i], most_[i]));
    };
    for (int i = 0; i < nx_; ++i) look(i);
    for (int i = nx_ - 1; i >= 0; --i) look(i);
  }

  Grid<float>& d_;
  const std::vector<char>& fixed_;
  const int nx_, ny_, nz_;
  Row beyond_, least_, most_;   // along a row: what is off the grid; the lesser neighbour along y, along z
};

}  // namespace

Grid<float> redistanced(const Grid<float>& psi) {
  const GridShape& s = psi.shape;
  Grid<float> d(s, kFarthest);
  std::vector<char> fixed(s.count(), 0);
  const std::array<std::size_t, 3> stride{1, std::size_t(s.size.x()), std::size_t(s.size.x()) * std::size_t(s.size.y())};
  const std::size_t nx = stride[1];
  std::vector<char> in(s.count()), beside(nx);
  for (std::size_t n = 0; n < in.size(); ++n) in[n] = psi[n] < 0;
  for (int k = 0; k < s.size.z(); ++k)
    for (int j = 0; j < s.size.y(); ++j) {
      const std::size_t first = s.index(0, j, k);
      mark_changes({&in[first], nx}, {j > 0 ? &in[first - nx] : nullptr, j + 1 < s.size.y() ? &in[first + nx] : nullptr, k > 0 ? &in[first - stride[2]] : nullptr,
                                      k + 1 < s.size.z() ? &in[first + stride[2]] : nullptr}, beside);
      for (std::size_t i = 0, n = first; i < nx; ++i, ++n) {
        if (beside[i]) {
          d[n] = beside_surface(&psi.values[n], stride, {i > 0, j > 0, k > 0}, {i + 1 < nx, j + 1 < s.size.y(), k + 1 < s.size.z()});
          fixed[n] = 1;
        } else if (in[n]) {
          d[n] = kDeepest;
        }
      }
    }
  Sweeper(d, fixed).run();
  const float step = float(s.step);
  for (std::size_t n = 0; n < d.values.size(); ++n) d[n] = psi[n] < 0 ? -d[n] * step : d[n] * step;
  return d;
}

std::size_t inside_count(const Grid<float>& psi) {
  return std::size_t(std::count_if(psi.values.begin(), psi.values.end(), [](float v) { return v < 0; }));
}

}  // namespace transformables::finishing
