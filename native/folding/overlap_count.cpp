// How much of a part lies in another one, in one configuration: eight balls of samples, or samples, at a time, level by level.
#include <algorithm>
#include <bit>

#include "common/eight.h"
#include "folding/overlap.h"

namespace transformables::folding {
namespace {

constexpr std::size_t kAtOnce = 8;   // eights of bricks whose inside is looked at together: one does not wait for what another one turns out to be

/// What is left to look at, and the samples that count already.
template <std::size_t kMost>
struct Tally {
  std::uint32_t undecided[kMost];   // numbers of what lies below
  std::size_t count = 0, hits = 0;
};

/// Of balls that are clear of B's surface nothing counts, or all of it; the others' numbers are kept. Hardly any branches: how they would go can't be guessed.
template <std::size_t kMost>
EIGHT_INLINE void look(const PartSamples::EightBalls& balls, const PartField& b, const Rigid& a_to_b, float tolerance, Tally<kMost>& tally) {
  const auto [deep, partly] = b.depths(balls.centres, balls.radius, a_to_b, tolerance);
  const std::uint32_t all = deep & balls.there, some = partly & balls.there;
  if ((all | some) == 0) return;
  for (std::uint32_t n = 0; n < 8; ++n) {
    tally.undecided[tally.count] = balls.below + n;
    tally.count += some >> n & 1;
    tally.hits += std::size_t((all >> n & 1) * std::uint32_t(balls.count[n]));
  }
}

EIGHT_INLINE std::size_t count(const PartSamples::Cube& cube, float side, const PartField& b, const Rigid& a_to_b, float tolerance) {
  EightPlaces places;
  for (int n = 0; n < 8; ++n) {
    places.x[n] = cube.first.x() + float(n & 1) * side;
    places.y[n] = cube.first.y() + float(n >> 1 & 1) * side;
    places.z[n] = cube.first.z() + float(n >> 2) * side;
  }
  return std::size_t(std::popcount(b.depths(places, nullptr, a_to_b, tolerance).deep & cube.there));
}

EIGHT_INLINE std::size_t count_all(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) {
  std::size_t hits = 0;
  for (std::size_t first = 0; first < a.eights[0].size(); first += kAtOnce) {
    Tally<8 * kAtOnce + 1> bricks;
    Tally<64 * kAtOnce + 1> cubes;
    const std::size_t end = std::min(first + kAtOnce, a.eights[0].size());
    for (std::size_t n = first; n < end; ++n) look(a.eights[0][n], b, a_to_b, tolerance, bricks);
    for (std::size_t n = 0; n < bricks.count; ++n) look(a.eights[1][bricks.undecided[n]], b, a_to_b, tolerance, cubes);
    for (std::size_t n = 0; n < cubes.count; ++n) hits += count(a.cubes[cubes.undecided[n]], a.side, b, a_to_b, tolerance);
    hits += bricks.hits + cubes.hits;
  }
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
