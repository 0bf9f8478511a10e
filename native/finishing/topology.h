// One connected piece a part, without hollows. Inside samples are connected through six neighbours, outside samples
// through 26: so isosurface() connects them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/grid.h"

namespace transformables::finishing {

/// Makes all inside samples outside, except the piece that holds most of the core (the largest piece when none does).
/// @return the samples that were dropped
std::size_t keep_core_piece(Grid<float>& psi, const Grid<float>& core);

/// Outside samples that are cut off from the border, as flags; empty when there are none.
std::vector<char> hollows(const Grid<float>& psi);

/// Makes the flagged samples inside.
void fill(Grid<float>& psi, const std::vector<char>& flags);

}  // namespace transformables::finishing
