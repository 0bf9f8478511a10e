#include "folding/distance_transform.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace transformables::folding {
namespace {

constexpr float kFar = 1e12f;

/// Squared distances along one line of samples, in place (Felzenszwalb and Huttenlocher 2012).
class LineTransform {
 public:
  explicit LineTransform(int longest) : value_(longest), bound_(longest + 1), parabola_(longest), half_inverse_(longest) {
    for (int d = 1; d < longest; ++d) half_inverse_[d] = 0.5 / d;
  }

  void operator()(float* line, std::size_t stride, int n) {
    int last = -1;
    for (int q = 0; q < n; ++q) {
      value_[q] = line[q * stride];
      if (value_[q] >= kFar) continue;
      double meet = -kFar;
      for (; last >= 0; --last) {
        meet = crossing(q, parabola_[last]);
        if (meet > bound_[last]) break;
      }
      parabola_[++last] = q;
      bound_[last] = last > 0 ? meet : -kFar;
    }
    if (last < 0) return;
    bound_[last + 1] = kFar;
    for (int q = 0, at = 0; q < n; ++q) {
      while (bound_[at + 1] < q) ++at;
      const float d = float(q - parabola_[at]);
      line[q * stride] = d * d + value_[parabola_[at]];
    }
  }

 private:
  double crossing(int q, int p) const { return (double(value_[q]) - double(value_[p]) + double(q) * q - double(p) * p) * half_inverse_[q - p]; }

  std::vector<float> value_;
  std::vector<double> bound_;
  std::vector<int> parabola_;
  std::vector<double> half_inverse_;
};

/// Squared distance along each row to the nearest sample that `is_one`, no more than `most` squared.
template <class IsOne>
void along_row(const char* flags, float* row, int n, float most, const IsOne& is_one) {
  float steps = most;
  for (int i = 0; i < n; ++i) {
    steps = is_one(flags[i]) ? 0 : std::min(steps + 1, most);
    row[i] = steps;
  }
  steps = most;
  for (int i = n - 1; i >= 0; --i) {
    steps = is_one(flags[i]) ? 0 : std::min(steps + 1, most);
    row[i] = std::min(row[i], steps);
  }
  for (int i = 0; i < n; ++i) row[i] *= row[i];
}

/// The lesser of each row and its neighbours up to kDeepest away, which lie that much farther: `rows` of `length`, `stride` apart.
void across_rows(const float* from, float* to, int rows, std::size_t stride, std::size_t length) {
  for (int r = 0; r < rows; ++r) {
    float* out = to + std::size_t(r) * stride;
    std::copy_n(from + std::size_t(r) * stride, length, out);
    for (int n = std::max(0, r - kDeepest + 1); n < std::min(rows, r + kDeepest); ++n) {
      const float farther = float((n - r) * (n - r));
      const float* in = from + std::size_t(n) * stride;
      for (std::size_t i = 0; i < length; ++i) out[i] = std::min(out[i], in[i] + farther);
    }
  }
}

}  // namespace

std::vector<float> squared_distances(const std::vector<char>& flags, const Eigen::Vector3i& size) {
  const std::size_t nx = size.x(), ny = size.y(), nz = size.z(), slice = nx * ny;
  std::vector<float> v(slice * nz);
  tbb::parallel_for(std::size_t(0), nz, [&](std::size_t k) {
    LineTransform line{size.y()};
    float* const at = v.data() + k * slice;
    for (std::size_t j = 0; j < ny; ++j)
      along_row(flags.data() + k * slice + j * nx, at + j * nx, int(nx), 1e6f, [](char flag) { return flag != 0; });
    for (std::size_t i = 0; i < nx; ++i) line(at + i, nx, int(ny));
  });
  tbb::parallel_for(std::size_t(0), ny, [&](std::size_t j) {
    LineTransform line{size.z()};
    for (std::size_t i = 0; i < nx; ++i) line(v.data() + j * nx + i, slice, int(nz));
  });
  return v;
}

std::vector<float> squared_depths(const std::vector<char>& flags, const Eigen::Vector3i& size) {
  const std::size_t nx = size.x(), ny = size.y(), nz = size.z(), slice = nx * ny;
  std::vector<float> v(slice * nz), w(slice * nz);
  tbb::parallel_for(std::size_t(0), nz, [&](std::size_t k) {
    for (std::size_t j = 0; j < ny; ++j) {
      const std::size_t row = k * slice + j * nx;
      along_row(flags.data() + row, v.data() + row, int(nx), float(kDeepest), [](char flag) { return flag == 0; });
    }
    across_rows(v.data() + k * slice, w.data() + k * slice, int(ny), nx, nx);
  });
  tbb::parallel_for(std::size_t(0), ny, [&](std::size_t j) { across_rows(w.data() + j * nx, v.data() + j * nx, int(nz), slice, nx); });
  return v;
}

}  // namespace transformables::folding
