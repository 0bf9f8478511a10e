// How much of a part lies in another one, in one configuration: eight balls of samples, or samples, at a time.
#include <bit>

#include "common/eight.h"
#include "folding/overlap.h"

namespace transformables::folding {
namespace {

/// Of a ball that is clear of B's surface nothing counts, or all of it; else what lies below it is looked at.
template <int kLevel>
EIGHT_INLINE std::size_t count(const PartSamples& a, const PartSamples::EightBalls& balls, const PartField& b, const Rigid& a_to_b, float tolerance) {
  float values[8];
  b.at(balls.centres, a_to_b, values);
  EIGHT_LOAD(Floats, value, values);
  EIGHT_LOAD(Floats, reach, balls.radius);
  EIGHT_LOAD(Eight, held, balls.count);
  value += tolerance;
  const Eight within = (value < -reach) & held;
  std::size_t hits = 0;
  for (int n = 0; n < 8; ++n) hits += std::size_t(within[n]);
  if constexpr (kLevel < 2) {
    const Eight near = (value < reach) & (value >= -reach) & (held > 0);
    EIGHT_BITS_OF_EIGHT(undecided, near);
    for (std::uint32_t bits = undecided; bits != 0; bits &= bits - 1)
      hits += count<kLevel + 1>(a, a.eights[kLevel + 1][balls.below + std::uint32_t(std::countr_zero(bits))], b, a_to_b, tolerance);
  }
  return hits;
}

EIGHT_INLINE std::size_t count_all(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) {
  std::size_t hits = 0;
  for (const PartSamples::EightBalls& bricks : a.eights[0]) hits += count<0>(a, bricks, b, a_to_b, tolerance);
  return hits;
}

std::size_t count_plain(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) { return count_all(a, b, a_to_b, tolerance); }

EIGHT_AVX2 std::size_t count_avx2(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) { return count_all(a, b, a_to_b, tolerance); }

}  // namespace

std::size_t overlapping_samples(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) {
  if (a.points.empty() || b.empty() || b.at(a_to_b(a.whole.centre)) > a.whole.radius - tolerance) return 0;
  return has_avx2() ? count_avx2(a, b, a_to_b, tolerance) : count_plain(a, b, a_to_b, tolerance);
}

}  // namespace transformables::folding
