// Which side of each closed surface is solid.
#pragma once

#include <string>
#include <vector>

#include "target/soup.h"

namespace transformables {

/// Winding number of a closed mesh about a point (sum of solid angles, van Oosterom and Strackee 1983): 1 inside an
/// outward mesh, 0 outside.
double winding_number(const TriangleMesh& mesh, const Eigen::Vector3d& p);

/// Turns every piece so that its faces look away from the solid. A piece within another is a cavity when it is turned
/// the other way; turned the same way it changes nothing, and is left out with a warning.
/// @param manifold  closed, no two pieces crossing
TriangleMesh turn_outward(const Manifold& manifold, std::vector<std::string>& warnings);

}  // namespace transformables
