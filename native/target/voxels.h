// What the samples of a signed distance say about a solid as a whole.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/grid.h"

namespace transformables {

struct InsidePiece {
  std::vector<std::size_t> samples;  ///< ascending
  double share = 0;                  ///< of all samples with a negative distance
};

/// The largest 6-connected piece of the samples with a negative distance; of equal ones the first. Empty when none is.
InsidePiece largest_inside_piece(const Grid<float>& distance);

/// The axis across which the samples are most nearly their own mirror image about the grid's middle; nothing when
/// fewer than 93 % (of the union) agree. Of equals the lowest axis.
std::optional<int> find_mirror_axis(const GridShape& shape, const std::vector<std::size_t>& inside);

}  // namespace transformables
