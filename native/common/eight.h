// Loops over several numbers at once, compiled twice: for every machine, and for those (nearly all) whose registers hold 32 bytes.
// A vector is neither passed to nor from a function: that would change the binary interface with the machine. Hence the macros.
#pragma once

#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#define EIGHT_INLINED __attribute__((always_inline))   // of a lambda
#define EIGHT_INLINE inline EIGHT_INLINED
#define EIGHT_LOAD(Vector, name, from) \
  Vector name;                             \
  std::memcpy(&name, from, sizeof name)

namespace transformables {

typedef std::int32_t Eight __attribute__((vector_size(32)));
typedef std::uint8_t Bytes __attribute__((vector_size(32)));
typedef float Floats __attribute__((vector_size(32)));
typedef double Four __attribute__((vector_size(32)));
typedef std::int64_t Lanes __attribute__((vector_size(32)));   // of a Four, for shuffles

#if defined(__x86_64__)
#define EIGHT_AVX2 __attribute__((target("avx2")))
inline bool has_avx2() { return __builtin_cpu_supports("avx2"); }
#else
#define EIGHT_AVX2
inline bool has_avx2() { return false; }
#endif

// Declares Floats `roots`: the square roots of Floats that are not negative.
#if defined(__SSE2__)
#define EIGHT_SQRT(roots, squares)                                                                            \
  const __m128 roots##_low = _mm_sqrt_ps(__m128(__builtin_shufflevector(squares, squares, 0, 1, 2, 3))),      \
               roots##_high = _mm_sqrt_ps(__m128(__builtin_shufflevector(squares, squares, 4, 5, 6, 7)));     \
  const Floats roots = __builtin_shufflevector(roots##_low, roots##_high, 0, 1, 2, 3, 4, 5, 6, 7)
#else
#define EIGHT_SQRT(roots, squares) \
  Floats roots = squares;          \
  for (int lane = 0; lane < 8; ++lane) roots[lane] = __builtin_sqrtf(roots[lane])
#endif

// Puts into `bits` a bit for each number of a mask (all of its bits set, or none).
#if defined(__SSE2__)
#define EIGHT_BITS_OF_BYTES(bits, mask)                                                                    \
  const std::uint32_t bits = std::uint32_t(_mm_movemask_epi8(__m128i(__builtin_shufflevector(mask, mask, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)))) | \
                             std::uint32_t(_mm_movemask_epi8(__m128i(__builtin_shufflevector(mask, mask, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31)))) << 16
#define EIGHT_BITS_OF_EIGHT(bits, mask)                                                                    \
  const std::uint32_t bits = std::uint32_t(_mm_movemask_ps(__m128(__builtin_shufflevector(mask, mask, 0, 1, 2, 3)))) | \
                             std::uint32_t(_mm_movemask_ps(__m128(__builtin_shufflevector(mask, mask, 4, 5, 6, 7)))) << 4
#else
#define EIGHT_BITS_OF_BYTES(bits, mask) \
  std::uint32_t bits = 0;                   \
  for (int lane = 0; lane < 32; ++lane) bits |= std::uint32_t((mask)[lane] != 0) << lane
#define EIGHT_BITS_OF_EIGHT(bits, mask) \
  std::uint32_t bits = 0;                   \
  for (int lane = 0; lane < 8; ++lane) bits |= std::uint32_t((mask)[lane] != 0) << lane
#endif

}  // namespace transformables
