// Is a mesh a printable solid? CGAL answers for self-intersections; the rest is counting.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "finishing/finishing.h"

namespace transformables {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

std::uint32_t surface_size(std::size_t n) { return std::uint32_t(n); }

std::uint64_t half_edge(int a, int b) { return std::uint64_t(std::uint32_t(a)) << 32 | std::uint32_t(b); }

bool indices_are_sound(const TriangleMesh& mesh) {
  const int n = int(mesh.vertices.size());
  for (const auto& t : mesh.triangles)
    if (t.minCoeff() < 0 || t.maxCoeff() >= n || t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
  return true;
}

/// Every edge is used once each way; the triangles about a vertex form one fan.
void check_edges(const TriangleMesh& mesh, MeshCheck& result) {
  std::unordered_map<std::uint64_t, int> opposite;  // half edge -> the third corner
  opposite.reserve(mesh.triangles.size() * 3);
  std::vector<int> degree(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      ++degree[t[k]];
      if (!opposite.emplace(half_edge(t[k], t[(k + 1) % 3]), t[(k + 2) % 3]).second) result.non_manifold = true;
    }
  for (const auto& [edge, corner] : opposite)
    if (!opposite.count(edge << 32 | edge >> 32)) result.open = true;
  if (result.open || result.non_manifold) return;
  std::vector<char> seen(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int centre = t[k];
      if (seen[centre]) continue;
      seen[centre] = 1;
      const int start = t[(k + 1) % 3];
      int at = start, steps = 0;
      do {
        at = opposite.at(half_edge(centre, at));
        ++steps;
      } while (at != start && steps <= degree[centre]);
      if (steps != degree[centre]) result.non_manifold = true;
    }
}

int count_pieces(const TriangleMesh& mesh) {
  std::vector<int> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    root[find(t[1])] = find(t[0]);
    root[find(t[2])] = find(t[0]);
  }
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles) used[find(t[0])] = 1;
  return int(std::count(used.begin(), used.end(), 1));
}

/// Of a closed manifold mesh.
bool intersects_itself(const TriangleMesh& mesh) {
  CGAL::Surface_mesh<Kernel::Point_3> surface;
  surface.reserve(surface_size(mesh.vertices.size()), surface_size(mesh.triangles.size() * 3 / 2),
                  surface_size(mesh.triangles.size()));
  using Vertex = CGAL::SM_Vertex_index;
  for (const auto& v : mesh.vertices) surface.add_vertex({v.x(), v.y(), v.z()});
  for (const auto& t : mesh.triangles)
    surface.add_face(Vertex(surface_size(t[0])), Vertex(surface_size(t[1])), Vertex(surface_size(t[2])));
  return CGAL::Polygon_mesh_processing::does_self_intersect(surface);
}

}  // namespace

MeshCheck check(const TriangleMesh& mesh, bool simple) {
  MeshCheck result;
  const bool finite = std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](const auto& v) { return v.allFinite(); });
  if (mesh.empty() || !finite || !indices_are_sound(mesh)) {
    result.open = mesh.empty();
    result.non_manifold = !mesh.empty();
    return result;
  }
  check_edges(mesh, result);
  result.extra_pieces = count_pieces(mesh) - 1;
  // Two sheets joined along an edge, or a hole's rim, leave no question that CGAL's structure could hold.
  if (!simple && !result.open && !result.non_manifold) result.self_intersecting = intersects_itself(mesh);
  result.inside_out = !(signed_volume(mesh) > 0);
  return result;
}

}  // namespace transformables
