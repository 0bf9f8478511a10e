// From a cleaned soup to a closed solid.
#pragma once

#include <string>
#include <vector>

#include "common/mesh.h"
#include "common/progress.h"

namespace transformables {

/// A closed, manifold mesh without self-intersections, its faces looking away from the solid (into cavities, too).
struct Solid {
  TriangleMesh mesh;
  bool exact_surface = true;  ///< the user's own triangles, but for small patches over holes and crossings
};

/// Closes holes, mends small crossings, and wraps what can't be mended. Adds what it did to the warnings.
/// @param mesh   cleaned, target frame
/// @param voxel  size of a voxel, target units: a wrap keeps within about a tenth of it of the surface
/// @throws InvalidInput when the mesh has no volume
/// @throws Cancelled
Solid make_solid(const TriangleMesh& mesh, double voxel, const Progress& progress, std::vector<std::string>& warnings);

}  // namespace transformables
