// Triangle meshes as plain arrays, and the few things that are asked of them everywhere.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace transformables {

/// An indexed triangle mesh. Outward is the side from which a triangle's corners run counter-clockwise.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;

  bool empty() const { return triangles.empty(); }
};

/// Box around all vertices (of an empty mesh: an empty box).
inline Eigen::AlignedBox3d bounds(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& v : mesh.vertices) box.extend(v);
  return box;
}

/// Volume enclosed by a closed mesh; negative when it is inside out.
inline double signed_volume(const TriangleMesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6;
}

}  // namespace transformables
