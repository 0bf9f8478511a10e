// What carving will have to take away: a rehearsal on samples.
#pragma once

#include <vector>

#include "folding/motion.h"

namespace transformables::folding {

/// All moves of a path, sampled one after the other.
std::vector<SampledMove> sampled_moves(const Design& design, const FoldPath& path, double largest_step_rad);

/// For each sample of the grid whether it goes when a path is cleared move by move, each pair losing the lesser of its two
/// colliding sides, what is gone not colliding any more.
std::vector<char> carving_of(const Design& design, const std::vector<std::int16_t>& owner, const std::vector<SampledMove>& moves, float tolerance);

}  // namespace transformables::folding
