// CGAL's halfedge mesh with a source for each triangle. Inner to the room: heavy to compile.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <cstdint>
#include <vector>

#include "finishing/exact_cut.h"

namespace transformables::finishing {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using HalfedgeMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using SourceMap = HalfedgeMesh::Property_map<HalfedgeMesh::Face_index, std::int32_t>;

inline SourceMap source_map(HalfedgeMesh& mesh) {
  return mesh.add_property_map<HalfedgeMesh::Face_index, std::int32_t>("f:source", -1).first;
}

/// False when a triangle does not fit: the mesh is not manifold, or not oriented.
inline bool fill(HalfedgeMesh& into, const TriangleMesh& mesh) {
  using Size = HalfedgeMesh::size_type;
  using Vertex = HalfedgeMesh::Vertex_index;
  into.reserve(Size(mesh.vertices.size()), Size(mesh.triangles.size() * 3 / 2), Size(mesh.triangles.size()));
  for (const auto& v : mesh.vertices) into.add_vertex({v.x(), v.y(), v.z()});
  for (const auto& t : mesh.triangles)
    if (into.add_face(Vertex(Size(t[0])), Vertex(Size(t[1])), Vertex(Size(t[2]))) == HalfedgeMesh::null_face()) return false;
  return true;
}

/// As arrays, in order, without vertices that no triangle uses.
inline SourcedMesh arrays_of(const HalfedgeMesh& mesh, const SourceMap& source) {
  SourcedMesh out;
  std::vector<int> index(mesh.number_of_vertices() + mesh.number_of_removed_vertices(), -1);
  for (const auto f : mesh.faces()) {
    Eigen::Vector3i triangle;
    int corner = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      int& at = index[std::size_t(v)];
      if (at < 0) {
        at = int(out.mesh.vertices.size());
        const auto& p = mesh.point(v);
        out.mesh.vertices.emplace_back(p.x(), p.y(), p.z());
      }
      triangle[corner++] = at;
    }
    out.mesh.triangles.push_back(triangle);
    out.source.push_back(source[f]);
  }
  return out;
}

}  // namespace transformables::finishing
