// Random numbers that are the same on every machine and compiler (xoshiro256**, by Blackman and Vigna).
#pragma once

#include <array>
#include <cstdint>

namespace transformables {

class Random {
 public:
  explicit Random(std::uint64_t seed = 0);
  std::uint64_t bits();
  double uniform();                            ///< in [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal();                             ///< mean 0, variance 1 (polar method)

  std::array<std::uint64_t, 4> state{};
  double spare = 0;                            ///< the polar method makes two at a time
  bool has_spare = false;
};

}  // namespace transformables
