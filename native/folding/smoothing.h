// Interfaces between parts made smooth at the scale of a few samples, as far as the path allows.
#pragma once

#include <cstdint>
#include <vector>

#include "folding/motion.h"

namespace transformables::folding {

/// Owners after some rounds in which each sample near an interface goes to the part that has most of its surroundings
/// (threshold dynamics after Merriman, Bence and Osher), so that islands, fins and stairs vanish. A sample of a core stays; another changes only
/// when it then meets no part along `moves`.
std::vector<std::int16_t> smoothed_owners(const Design& design, const std::vector<std::int16_t>& owner, const std::vector<std::int16_t>& core,
                                          const std::vector<SampledMove>& moves, float tolerance);

}  // namespace transformables::folding
