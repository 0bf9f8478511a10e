// Level set growth to the letter of the paper (section 5): every level set dense over the whole grid, every step in full.
// Slow on purpose: it is the oracle for the production code and the baseline for its speed.
#pragma once

#include <cstdint>
#include <vector>

#include "character/character.h"
#include "common/grid.h"
#include "embedding/embedding.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::reference {

struct Growth {
  std::vector<Grid<float>> phi;        ///< one a bone, over target.distance's grid, target units
  std::vector<std::int16_t> owner;     ///< argmin phi at inside samples, -1 outside
  int steps = 0;
};

/// Signed distance from the zero level of `phi`, by fast marching (Sethian 1995): upwind, first order, the samples next to
/// the front by their value over the slope, which leaves the zero where it is also where `phi` is no distance (Russo and Smereka 2000).
void redistance(Grid<float>& phi);

/// Eqs. 6 and 7 with the projection of Losasso et al. (2006). Two departures, both shared with the production code, without which the fronts
/// drift (measured: thousands of stray pieces): the speed is capped by half the gap that remains between two skins, and where more than two level sets
/// overlap all are shifted by the mean of the two smallest. Ends when every inside sample is claimed, or nothing moves for 20 steps.
Growth grow(const Character& character, const Target& target, const Embedding& embedding, const SegmentationOptions& options);

}  // namespace transformables::reference
