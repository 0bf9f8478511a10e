#include "embedding/random.h"

#include <bit>
#include <cmath>

namespace transformables {

Random::Random(std::uint64_t seed) {
  for (auto& word : state) {  // splitmix64, which the generator's authors advise for seeding
    seed += 0x9e3779b97f4a7c15u;
    std::uint64_t z = seed;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    word = z ^ (z >> 31);
  }
}

std::uint64_t Random::bits() {
  const std::uint64_t result = std::rotl(state[1] * 5, 7) * 9, shifted = state[1] << 17;
  state[2] ^= state[0];
  state[3] ^= state[1];
  state[1] ^= state[2];
  state[0] ^= state[3];
  state[2] ^= shifted;
  state[3] = std::rotl(state[3], 45);
  return result;
}

double Random::uniform() { return double(bits() >> 11) * 0x1.0p-53; }

double Random::normal() {
  if (has_spare) {
    has_spare = false;
    return spare;
  }
  double u, v, s;
  do {
    u = uniform(-1, 1);
    v = uniform(-1, 1);
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double factor = std::sqrt(-2 * std::log(s) / s);
  spare = v * factor;
  has_spare = true;
  return u * factor;
}

}  // namespace transformables
