#include "segmentation/bending.h"

#include <algorithm>
#include <numeric>

#include "common/eight.h"
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace transformables::segmentation_inner {
namespace {

constexpr std::size_t kLanes = 8;

struct Rows {
  std::size_t count;
  const std::array<const std::int32_t*, 6> beside;
  const float *neighbours, *low, *high;
  float *value, *next, *bend;
};

inline float deviation(const Rows& rows, const float* of, std::size_t k) {
  const auto& b = rows.beside;
  const float sum = of[b[0][k]] + of[b[1][k]] + of[b[2][k]] + of[b[3][k]] + of[b[4][k]] + of[b[5][k]];
  return sum / rows.neighbours[k] - of[k];
}

void step_plain(const Rows& rows) {
  for (std::size_t k = 0; k < rows.count; ++k) rows.bend[k] = deviation(rows, rows.value, k);
  for (std::size_t k = 0; k < rows.count; ++k)
    rows.next[k] = std::clamp(rows.value[k] + 0.5f * rows.bend[k] - 0.3f * deviation(rows, rows.bend, k), rows.low[k], rows.high[k]);
}

#if defined(__x86_64__)
EIGHT_AVX2 EIGHT_INLINE __m256 deviation_of_eight(const Rows& rows, const float* of, std::size_t k) {
  const auto gathered = [&](int n) EIGHT_AVX2 EIGHT_INLINED { return _mm256_i32gather_ps(of, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rows.beside[std::size_t(n)] + k)), 4); };
  __m256 sum = gathered(0);
  for (int n = 1; n < 6; ++n) sum = _mm256_add_ps(sum, gathered(n));
  return _mm256_sub_ps(_mm256_div_ps(sum, _mm256_loadu_ps(rows.neighbours + k)), _mm256_loadu_ps(of + k));
}

EIGHT_AVX2 void step_avx2(const Rows& rows) {
  for (std::size_t k = 0; k < rows.count; k += kLanes) _mm256_storeu_ps(rows.bend + k, deviation_of_eight(rows, rows.value, k));
  const __m256 half = _mm256_set1_ps(0.5f), back = _mm256_set1_ps(0.3f);
  for (std::size_t k = 0; k < rows.count; k += kLanes) {
    const __m256 on = _mm256_add_ps(_mm256_loadu_ps(rows.value + k), _mm256_mul_ps(half, _mm256_loadu_ps(rows.bend + k)));
    const __m256 next = _mm256_sub_ps(on, _mm256_mul_ps(back, deviation_of_eight(rows, rows.bend, k)));
    _mm256_storeu_ps(rows.next + k, _mm256_min_ps(_mm256_max_ps(next, _mm256_loadu_ps(rows.low + k)), _mm256_loadu_ps(rows.high + k)));
  }
}
#else
void step_avx2(const Rows& rows) { step_plain(rows); }
#endif

}  // namespace

Bending::Bending(std::size_t count)
    : count_((count + kLanes - 1) / kLanes * kLanes), value_(count_ + 1, 0.0f), low_(count_, 0.0f), high_(count_, 0.0f), neighbours_(count_, 1.0f) {
  for (auto& row : beside_) row.assign(count_, std::int32_t(count_));
}

std::size_t Bending::add_still(float value) {
  value_.push_back(value);
  return value_.size() - 1;
}

/// The place after those that move holds 0, and stands in for neighbours that are not there. A sample without any is its own: it has no bend.
void Bending::set_beside(std::size_t k, const std::array<std::uint32_t, 6>& beside, int count) {
  for (int n = 0; n < count; ++n) beside_[std::size_t(n)][k] = std::int32_t(beside[std::size_t(n)]);
  if (count == 0) beside_[0][k] = std::int32_t(k);
  neighbours_[k] = float(std::max(count, 1));
}

void Bending::step() {
  next_.resize(value_.size()), bend_.resize(value_.size());
  std::copy(value_.begin() + std::ptrdiff_t(count_), value_.end(), next_.begin() + std::ptrdiff_t(count_));
  const Rows rows{count_, {beside_[0].data(), beside_[1].data(), beside_[2].data(), beside_[3].data(), beside_[4].data(), beside_[5].data()},
                  neighbours_.data(), low_.data(), high_.data(), value_.data(), next_.data(), bend_.data()};
  has_avx2() ? step_avx2(rows) : step_plain(rows);
  std::swap(value_, next_);
}

}  // namespace transformables::segmentation_inner
