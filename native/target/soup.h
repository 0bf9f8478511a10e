// Triangles as a user has them, turned into an oriented manifold, possibly with holes. Plain arrays, no CGAL.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "common/mesh.h"

namespace transformables {

/// What was left out while cleaning, in faces.
struct SoupReport {
  std::size_t non_finite = 0;   ///< faces with a vertex at NaN or infinity
  std::size_t degenerate = 0;   ///< faces without area
  std::size_t duplicates = 0;   ///< faces that repeat another's three corners
};

/// Drops faces that can't be used, merges vertices at the same place, forgets unused vertices.
/// A face without area stays when the mesh is closed only with it.
/// @throws InvalidInput when there are no faces, an index is out of range, or nothing usable is left.
TriangleMesh clean_soup(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Eigen::Vector3i>& triangles,
                        SoupReport& report);

/// For each edge c of a face (corner c to corner c + 1) the face beyond it, -1 where there is none.
using Neighbours = std::vector<std::array<int, 3>>;

/// A mesh in which each vertex has one fan of faces and neighbours agree on what is outward.
struct Manifold {
  TriangleMesh mesh;
  Neighbours neighbours;
  std::vector<int> component;          ///< of each face, numbered by first face
  int components = 0;
  std::size_t open_edges = 0;          ///< edges with a face on one side only
  std::size_t split_vertices = 0;      ///< copies made where sheets met in more than a manifold way
  std::size_t turned_faces = 0;        ///< faces turned round to agree with most of their component

  bool closed() const { return open_edges == 0; }
};

/// Orients each component as most of its faces are, and cuts it apart at edges of three or more faces and at pinched
/// vertices. Where the mesh was already fine, vertices and faces keep their order.
Manifold make_manifold(const TriangleMesh& mesh);

/// Merges border vertices that are nearer than a tolerance; returns the mesh unchanged when that closes no edge.
TriangleMesh stitch_borders(const Manifold& open, double tolerance);

/// The rims of the holes, as closed rows of vertex indices.
std::vector<std::vector<int>> border_loops(const Manifold& open);

/// Volume and area of each component. An open one is measured against the mean of its own vertices.
struct ComponentSize {
  double volume = 0;
  double area = 0;
};
std::vector<ComponentSize> component_sizes(const Manifold& manifold);

/// The mesh without the faces for which drop is true; unused vertices are forgotten.
TriangleMesh without_faces(const TriangleMesh& mesh, const std::vector<char>& drop);

}  // namespace transformables
