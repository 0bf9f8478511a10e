// Faces that cross, and the filling of holes (CGAL, kept out of sight).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/mesh.h"

namespace transformables {

/// Faces that cross, touch or overlap another, other than along what they share; ascending, each once.
std::vector<int> crossing_faces(const TriangleMesh& mesh);

/// Triangles over a closed row of points, as indices into it; no new points. Empty when CGAL finds none.
std::vector<Eigen::Vector3i> fill_loop(const std::vector<Eigen::Vector3d>& loop);

}  // namespace transformables
