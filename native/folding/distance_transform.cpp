#include "folding/distance_transform.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "common/eight.h"

namespace transformables::folding {
namespace {

constexpr std::size_t kLanes = 8;
constexpr int kMost = 1000000;   // steps: where no sample is one

/// Squared distance along each row to the nearest sample that `is_one`, no more than `most` squared; whether there is any.
template <class IsOne>
bool along_row(const char* flags, float* row, int n, int most, std::vector<int>& steps, const IsOne& is_one) {
  int now = most;
  for (int i = 0; i < n; ++i) steps[i] = now = is_one(flags[i]) ? 0 : std::min(now + 1, most);
  if (now == most && std::none_of(flags, flags + n, is_one)) {
    std::fill_n(row, n, float(most) * float(most));
    return false;
  }
  now = most;
  for (int i = n - 1; i >= 0; --i) {
    now = std::min(steps[i], now + 1);
    row[i] = float(now) * float(now);
  }
  return true;
}

/// The least of eight numbers of a row and those of all rows, which lie the farther the more rows they are away. Rows that are farther than
/// the greatest number found so far are not looked at.
EIGHT_INLINE void least_of_eight(const float* from, float* to, int r, int rows, std::size_t stride, std::size_t count) {
  const float* const here = from + std::size_t(r) * stride;
  EIGHT_LOAD(Floats, least, here);
  const int reach = std::max(r, rows - 1 - r);
  for (int d = 1; d <= reach; ++d) {
    const float farther = float(d * d);
    const Eight open = least > farther;
    EIGHT_BITS_OF_EIGHT(any, open);
    if (any == 0) break;
    if (d <= r) {
      EIGHT_LOAD(Floats, other, here - std::size_t(d) * stride);
      other += farther;
      least = other < least ? other : least;
    }
    if (d < rows - r) {
      EIGHT_LOAD(Floats, other, here + std::size_t(d) * stride);
      other += farther;
      least = other < least ? other : least;
    }
  }
  std::memcpy(to + std::size_t(r) * stride, &least, count * sizeof(float));
}

/// The same in loops, which are faster where registers are smaller.
inline void least_of_eight_plain(const float* from, float* to, int r, int rows, std::size_t stride, std::size_t count) {
  const float* const here = from + std::size_t(r) * stride;
  float least[kLanes];
  for (std::size_t n = 0; n < kLanes; ++n) least[n] = here[n];
  const int reach = std::max(r, rows - 1 - r);
  for (int d = 1; d <= reach; ++d) {
    const float farther = float(d * d);
    int open = 0;
    for (std::size_t n = 0; n < kLanes; ++n) open |= least[n] > farther;
    if (!open) break;
    const float* const below = here - std::size_t(std::min(d, r)) * stride;   // at the border one is looked at again, farther away than it is
    const float* const above = here + std::size_t(std::min(d, rows - 1 - r)) * stride;
    for (std::size_t n = 0; n < kLanes; ++n) {
      const float nearer = std::min(below[n], above[n]) + farther;
      least[n] = nearer < least[n] ? nearer : least[n];
    }
  }
  std::memcpy(to + std::size_t(r) * stride, least, count * sizeof(float));
}

/// The same for `length` numbers of each of `rows`, `stride` apart. Reads up to seven numbers beyond.
template <bool kWide>
EIGHT_INLINE void across_all(const float* from, float* to, int rows, std::size_t stride, std::size_t length) {
  for (std::size_t i = 0; i < length; i += kLanes)
    for (int r = 0; r < rows; ++r) {
      const std::size_t count = std::min(kLanes, length - i);
      if constexpr (kWide) least_of_eight(from + i, to + i, r, rows, stride, count);
      else least_of_eight_plain(from + i, to + i, r, rows, stride, count);
    }
}

void across_plain(const float* from, float* to, int rows, std::size_t stride, std::size_t length) { across_all<false>(from, to, rows, stride, length); }

EIGHT_AVX2 void across_avx2(const float* from, float* to, int rows, std::size_t stride, std::size_t length) { across_all<true>(from, to, rows, stride, length); }

void across_rows(const float* from, float* to, int rows, std::size_t stride, std::size_t length) {
  if (has_avx2()) across_avx2(from, to, rows, stride, length);
  else across_plain(from, to, rows, stride, length);
}

/// Squared distance to the nearest sample that `is_one`, no more than `most` squared: along each axis in turn, as squares add up.
template <class IsOne>
std::vector<float> transformed(const std::vector<char>& flags, const Eigen::Vector3i& size, int most, const IsOne& is_one) {
  const std::size_t nx = size.x(), ny = size.y(), nz = size.z(), slice = nx * ny;
  std::vector<float> v(slice * nz + kLanes), w(slice * nz + kLanes);
  tbb::parallel_for(std::size_t(0), nz, [&](std::size_t k) {
    std::vector<int> steps(nx);
    float* const at = v.data() + k * slice;
    bool any = false;
    for (std::size_t j = 0; j < ny; ++j) any = along_row(flags.data() + k * slice + j * nx, at + j * nx, int(nx), most, steps, is_one) || any;
    if (any) across_rows(at, w.data() + k * slice, int(ny), nx, nx);
    else std::copy_n(at, slice, w.data() + k * slice);
  });
  tbb::parallel_for(std::size_t(0), ny, [&](std::size_t j) { across_rows(w.data() + j * nx, v.data() + j * nx, int(nz), slice, nx); });
  v.resize(slice * nz);
  return v;
}

}  // namespace

std::vector<float> squared_distances(const std::vector<char>& flags, const Eigen::Vector3i& size) {
  return transformed(flags, size, kMost, [](char flag) { return flag != 0; });
}

std::vector<float> squared_depths(const std::vector<char>& flags, const Eigen::Vector3i& size) {
  return transformed(flags, size, kDeepest, [](char flag) { return flag == 0; });
}

}  // namespace transformables::folding
