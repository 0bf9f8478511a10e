// Parts grown anew from their skeletons, each sample going only to a part that can carry it along the whole path.
#pragma once

#include <cstdint>
#include <vector>

#include "folding/carve_estimate.h"
#include "folding/motion.h"

namespace transformables::folding {

struct RegrowthOptions {
  float tolerance = 0.25f;   ///< steps; what is deeper in another part collides
  int patience = 3;          ///< waves that a sample waits for its former owner before another may have it
};

struct Regrown {
  std::vector<std::int16_t> owner;
  std::vector<std::size_t> yielding;   ///< samples that no part could carry freely, given to a neighbour all the same
};

/// Waves of samples, from the cores outward; in every wave each part in turn takes those of its neighbours that meet nothing of what
/// the others have by then, along all of `moves`. What has collided once collides for ever, as parts only grow, so each sample is tried
/// once for each part.
Regrown regrown(const Design& design, const std::vector<std::int16_t>& core, const std::vector<SampledMove>& moves,
                const RegrowthOptions& options, const Progress& progress);

}  // namespace transformables::folding
