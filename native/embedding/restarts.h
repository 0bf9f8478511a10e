// When a search of many minima begins again, and how.
#pragma once

#include <cstdint>

#include "embedding/random.h"

namespace transformables {

/// BIPOP (Hansen 2009): populations that double take turns with small ones of random size and step, each regime getting about the same number of
/// evaluations.
class BipopRestarts {
 public:
  struct Run {
    int population = 0;
    double sigma_factor = 1;                   ///< of the first sigma
    long evaluations = 0;                      ///< bound for this run; 0: none
  };
  /// @param population  of the first run, 4 at least
  BipopRestarts(int population, std::uint64_t seed);
  Run next();
  void finished(long evaluations);             ///< what the run that `next` gave has used

 private:
  int first_population_ = 0, large_population_ = 0;
  long used_small_ = 0, used_large_ = 0, last_large_ = 0;
  bool first_ = true, last_was_large_ = true;
  Random random_;
};

}  // namespace transformables
