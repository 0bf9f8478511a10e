// Which hollows of a solid can't be reached from outside. Inner to the room.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/grid.h"

namespace transformables::finishing {

/// Samples outside a solid to which no way leads from the grid's border but by slits narrower than about two steps: powder, resin and supports
/// stay there, and a measurement on a grid of that step takes them for solid.
/// @param distance  signed distance of the solid, negative inside
std::vector<Eigen::Vector3d> shut_hollows(const Grid<float>& distance);

}  // namespace transformables::finishing
