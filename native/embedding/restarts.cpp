#include "embedding/restarts.h"

#include <algorithm>
#include <cmath>

namespace transformables {

BipopRestarts::BipopRestarts(int population, std::uint64_t seed) : first_population_(population), large_population_(population), random_(seed) {}

BipopRestarts::Run BipopRestarts::next() {
  if (first_) {
    first_ = false;
    return {first_population_, 1, 0};
  }
  last_was_large_ = used_large_ <= used_small_;
  if (last_was_large_) {
    large_population_ *= 2;
    return {large_population_, 1, 0};
  }
  const double u = random_.uniform(), ratio = 0.5 * large_population_ / first_population_;
  const int small = std::max(4, int(first_population_ * std::pow(ratio, u * u)));
  return {small, std::pow(10.0, -2 * random_.uniform()), std::max(1L, last_large_ / 2)};
}

void BipopRestarts::finished(long evaluations) {
  (last_was_large_ ? used_large_ : used_small_) += evaluations;
  if (last_was_large_) last_large_ = evaluations;
}

}  // namespace transformables
