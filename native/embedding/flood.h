// The approximate segmentation: every inside voxel goes to the bone that is nearest by the shortest way inside.
#pragma once

#include <cstdint>
#include <vector>

#include "embedding/voxels.h"

namespace transformables {

/// Lets the seeds flow: `field` holds kUnreached or a seed (distance and bone, packed) at every cell, and afterwards
/// the least of seed + way, where a way runs through inside voxels to any of the 26 neighbours, a step costing
/// 32, 45 or 55 units (1, sqrt 2, sqrt 3). Exact: sweeps are repeated until none changes anything.
/// @param rows  room to work in: what is in it does not matter; the second time with the same voxels nothing is allocated
/// @return sweeps that were needed
int flood(const Voxels& voxels, std::int32_t* field, std::vector<std::int32_t>& rows);

}  // namespace transformables
