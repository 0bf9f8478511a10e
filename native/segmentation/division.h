// The division of the target as it shows: which bone each place of its surface belongs to.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables {

struct Division {
  TriangleMesh mesh;                 ///< the target's surface, no edge longer than the spacing; target frame
  std::vector<std::int16_t> bones;   ///< for each vertex the bone whose part it is of; -1: of none (a piece of the target that is not filled)
};

/// The target's surface, its long edges halved until none is longer than the spacing, and the part at each vertex: that of the least level set.
/// @param spacing_steps  in steps of the grid, 0.25 to 16
/// @throws InvalidInput when the segmentation belongs to another target, or the spacing is out of range
Division division(const Segmentation& segmentation, const Target& target, double spacing_steps = 1);

}  // namespace transformables
