// A finished part.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace transformables {

/// A printable part, one rigid piece.
struct Part {
  int bone = 0;
  TriangleMesh mesh;            ///< bone frame, target units: closed, manifold, free of self-intersections, one piece, outward
  std::vector<std::int32_t> source;  ///< for each triangle the triangle of target.mesh that it is (a piece of); -1: an interface, or re-meshed
  double volume = 0;            ///< cubic target units
};

}  // namespace transformables
