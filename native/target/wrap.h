// A closed surface around anything (CGAL's 3D alpha wrapping, kept out of sight).
#pragma once

#include "common/mesh.h"

namespace transformables {

/// A closed, manifold, outward surface without self-intersections that encloses all triangles, offset away from
/// them, and that does not pass through openings narrower than alpha (Portaneri et al. 2022).
TriangleMesh alpha_wrap(const TriangleMesh& soup, double alpha, double offset);

}  // namespace transformables
