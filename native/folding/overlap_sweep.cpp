// Which samples of a part ever meet another one in a move: eight balls of samples, or samples, at a time, level by level. All eight go on by the way that the nearest of
// them allows.
#include <algorithm>
#include <bit>

#include "common/eight.h"
#include "folding/overlap.h"

namespace transformables::folding {
namespace {

constexpr float kClosed = 1e9f;   // steps: as far as those are that are not looked at any more

/// Calls met(n, configuration) for the first meeting of each of some balls, or places.
template <class Met>
EIGHT_INLINE void go_along(const PartField& b, const PairMotion& motion, const EightPlaces& centres, const float* radius, float largest, std::uint32_t open, float speed,
                           int from, float tolerance, const Met& met) {
  const int count = int(motion.a_to_b.size());
  const float pace = 1.02f * speed + 1e-4f;   // see first_hit()
  float aside[8];
  for (std::uint32_t n = 0; n < 8; ++n) aside[n] = open >> n & 1 ? 0 : kClosed;
  for (int t = from; t < count && open;) {
    const auto [close, least] = b.nearness(centres, radius, aside, motion.a_to_b[std::size_t(t)], tolerance);
    for (std::uint32_t bits = close & open; bits; bits &= bits - 1) {
      const int n = std::countr_zero(bits);
      aside[n] = kClosed;
      met(n, t);
    }
    open &= ~close;
    t += 1 + int(std::clamp((least - largest + tolerance) / pace, 0.0f, 1e6f));
  }
}

struct Meetings {
  std::uint32_t which = 0;
  int first[8];
};

EIGHT_INLINE Meetings meetings(const PartField& b, const PairMotion& motion, const PartSamples::EightBalls& balls, float speed, int from, float tolerance) {
  Meetings found;
  const float largest = *std::max_element(balls.radius, balls.radius + 8);
  go_along(b, motion, balls.centres, balls.radius, largest, balls.there, speed, from, tolerance, [&](int n, int t) EIGHT_INLINED { found.which |= 1u << n, found.first[n] = t; });
  return found;
}

EIGHT_INLINE std::uint32_t ever(const PartField& b, const PairMotion& motion, const EightPlaces& points, std::uint32_t which, float speed, int from, float tolerance) {
  std::uint32_t found = 0;
  go_along(b, motion, points, nullptr, 0, which, speed, from, tolerance, [&](int n, int) EIGHT_INLINED { found |= 1u << n; });
  return found;
}

EIGHT_INLINE EightPlaces corners_of(const PartSamples::Cube& cube, float side) {
  EightPlaces places;
  for (int n = 0; n < 8; ++n) {
    places.x[n] = cube.first.x() + float(n & 1) * side;
    places.y[n] = cube.first.y() + float(n >> 1 & 1) * side;
    places.z[n] = cube.first.z() + float(n >> 2) * side;
  }
  return places;
}

/// A cube's points follow each other as its corners do.
void flag(std::vector<char>& hit, std::uint32_t first, std::uint32_t there, std::uint32_t met) {
  for (; met; met &= met - 1) hit[first + std::uint32_t(std::popcount(there & ((met & -met) - 1)))] = 1;
}

EIGHT_INLINE std::size_t swept(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance, std::vector<char>* hit, std::size_t enough) {
  std::size_t hits = 0;
  for (std::size_t eight = 0; eight < a.eights[0].size(); ++eight) {
    const PartSamples::EightBalls& bricks = a.eights[0][eight];
    float speeds[8], fastest = 0;
    for (std::size_t n = 0; n < 8; ++n) {
      if (!(bricks.there >> n & 1)) continue;
      const PartSamples::Brick& brick = a.bricks[8 * eight + n];
      fastest = std::max(fastest, speeds[n] = motion.speed(brick.centre, brick.radius));
    }
    const Meetings near = meetings(b, motion, bricks, fastest, 0, tolerance);
    for (std::uint32_t n = 0; n < 8; ++n) {
      if (!(near.which >> n & 1)) continue;
      const PartSamples::EightBalls& small = a.eights[1][bricks.below + n];
      const Meetings nearer = meetings(b, motion, small, speeds[n], near.first[n], tolerance);
      for (std::uint32_t m = 0; m < 8; ++m) {
        if (!(nearer.which >> m & 1)) continue;
        const PartSamples::Cube& cube = a.cubes[small.below + m];
        const std::uint32_t met = ever(b, motion, corners_of(cube, a.side), cube.there, speeds[n], nearer.first[m], tolerance);
        if (hit) flag(*hit, a.small[small.below + m].first, cube.there, met);
        if ((hits += std::size_t(std::popcount(met))) >= enough) return enough;
      }
    }
  }
  return hits;
}

std::size_t swept_plain(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance, std::vector<char>* hit, std::size_t enough) {
  return swept(a, b, motion, tolerance, hit, enough);
}

EIGHT_AVX2 std::size_t swept_avx2(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance, std::vector<char>* hit, std::size_t enough) {
  return swept(a, b, motion, tolerance, hit, enough);
}

std::uint32_t ever_plain(const PartField& b, const PairMotion& motion, const EightPlaces& points, std::uint32_t which, float speed, int from, float tolerance) {
  return ever(b, motion, points, which, speed, from, tolerance);
}

EIGHT_AVX2 std::uint32_t ever_avx2(const PartField& b, const PairMotion& motion, const EightPlaces& points, std::uint32_t which, float speed, int from, float tolerance) {
  return ever(b, motion, points, which, speed, from, tolerance);
}

/// Whether no ball of A's bricks as a whole ever comes within reach of B.
bool never_near(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance) {
  return first_hit(b, motion, a.whole.centre, motion.speed(a.whole.centre, a.whole.radius), 0, tolerance - a.whole.radius) < 0;
}

}  // namespace

std::size_t swept_samples(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance, std::vector<char>* hit,
                          std::size_t enough) {
  if (hit) hit->assign(a.points.size(), 0);
  if (a.points.empty() || b.empty() || never_near(a, b, motion, tolerance)) return 0;
  return has_avx2() ? swept_avx2(a, b, motion, tolerance, hit, enough) : swept_plain(a, b, motion, tolerance, hit, enough);
}

std::uint32_t ever_deeper(const PartField& b, const PairMotion& motion, const EightPlaces& points, std::uint32_t which, float speed, int from, float tolerance) {
  return has_avx2() ? ever_avx2(b, motion, points, which, speed, from, tolerance) : ever_plain(b, motion, points, which, speed, from, tolerance);
}

}  // namespace transformables::folding
