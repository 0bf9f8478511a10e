// How near two triangles are, and between which points.
#pragma once

#include <Eigen/Core>

#include "finishing/box_tree.h"

namespace transformables::finishing {

struct Nearest {
  Eigen::Vector3d on_a, on_b;
  double distance = 0;   ///< 0 when they meet
};

Nearest nearest(const Triangle& a, const Triangle& b);

}  // namespace transformables::finishing
