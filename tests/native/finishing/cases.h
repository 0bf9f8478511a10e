// What the finishing room's tests share.
#pragma once

#include "common/mesh.h"

namespace transformables {

/// A closed box, outward.
inline TriangleMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int n = 0; n < 8; ++n)
    mesh.vertices.emplace_back(n & 1 ? high.x() : low.x(), n & 2 ? high.y() : low.y(), n & 4 ? high.z() : low.z());
  for (const auto& q : {Eigen::Vector4i(0, 2, 3, 1), Eigen::Vector4i(4, 5, 7, 6), Eigen::Vector4i(0, 1, 5, 4),
                        Eigen::Vector4i(2, 6, 7, 3), Eigen::Vector4i(0, 4, 6, 2), Eigen::Vector4i(1, 3, 7, 5)}) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return mesh;
}

}  // namespace transformables
