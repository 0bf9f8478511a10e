// What the parts of the reference objective share.
#pragma once

#include <cstdlib>
#include <vector>

#include "reference/objective.h"

namespace transformables::reference {

// A pose laid out: each bone's segments in the target's frame.
struct Objective::Posed {
  std::vector<std::vector<Segment>> segments;
  std::vector<Eigen::Vector3d> heads;
  std::vector<Eigen::Vector3d> axes;   ///< of each hinge, unit
};

/// Calls visit(voxel, along how many axes it is a step away, in all) for the voxels about one.
template <class Visit>
void for_around(const GridShape& shape, std::size_t voxel, int reach, const Visit& visit) {
  const Eigen::Vector3i c = shape.cell(voxel);
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const Eigen::Vector3i n = c + Eigen::Vector3i(x, y, z);
        if ((x || y || z) && shape.contains(n)) visit(shape.index(n), std::abs(x) + std::abs(y) + std::abs(z));
      }
}

}  // namespace transformables::reference
