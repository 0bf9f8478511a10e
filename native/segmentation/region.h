// What lies behind painted faces of the target. Inner to the room.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "target/target.h"

namespace transformables::segmentation_inner {

struct Region {
  std::vector<std::size_t> samples;   ///< inside ones, ascending
  std::vector<std::size_t> shown;     ///< those of them that lie right under the painted faces
  double on_target = 0;               ///< share of the painted area that lies on the target's surface
};

/// Inside samples whose nearest place on the target's surface is painted, no deeper than half the width of the painted area; three
/// steps at least. The way to a sample is looked for within the target, so nothing is taken across a gap.
/// @param painted  triangles, target frame
Region region_of(const Target& target, const std::vector<std::array<Eigen::Vector3d, 3>>& painted);

}  // namespace transformables::segmentation_inner
