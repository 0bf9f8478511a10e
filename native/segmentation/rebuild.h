// One bone's level set made to agree with the owners of the samples. Inner to the room.
#pragma once

#include <cstdint>
#include <vector>

#include "common/grid.h"
#include "segmentation/surfaces.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

inline constexpr int kRefitReach = 3;   ///< samples around a doubtful one that are fitted anew

/// What all bones' level sets are rebuilt against.
struct Surroundings {
  const Target& target;
  const std::vector<std::int16_t>& owner;
  const std::vector<char>& inside;
  const std::vector<char>& doubtful;
  const std::vector<ShellSample>& shell;
  float reach;   ///< steps outside the target
};

/// Values of before that agree in sign with the owner are kept, and near others the smoothest level set that respects every owner is fitted; outside the target it is continued.
/// @param before  target units, on the same lattice over any box; may be empty
/// @param first   the first sample of the box to fill, in the target's grid
/// @return target units, negative inside
Grid<float> rebuilt(const Grid<float>& before, const Surroundings& around, int bone, const Eigen::Vector3i& first, const GridShape& box);

}  // namespace transformables::segmentation_inner
