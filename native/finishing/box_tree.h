// A part's triangles in a tree of oriented boxes, as flat arrays.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/mesh.h"

namespace transformables::finishing {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// All triangles under a node lie in its box, and in the ball about the box's centre.
struct BoxNode {
  Eigen::Matrix3d axes;              ///< columns, a rotation
  Eigen::Vector3d centre, half;      ///< half: extents along the axes
  double radius = 0;
  std::int32_t first = 0, count = 0; ///< of the triangles
  std::int32_t children = -1;        ///< index of the first of two; -1: a leaf
  bool leaf() const { return children < 0; }
};

struct BoxTree {
  std::vector<BoxNode> nodes;        ///< nodes[0] holds all
  std::vector<Triangle> triangles;   ///< in the tree's order
};

/// @param mesh  not empty
BoxTree box_tree(const TriangleMesh& mesh);

}  // namespace transformables::finishing
