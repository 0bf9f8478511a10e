// The one translation unit that instantiates CGAL's polygon mesh processing for this room.
#include "target/crossings.h"

#define CGAL_LINKED_WITH_TBB 1
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/utility.h>

#include <algorithm>
#include <utility>

namespace transformables {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

Kernel::Point_3 point(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

std::vector<int> crossing_faces(const TriangleMesh& mesh) {
  SurfaceMesh surface;
  surface.reserve(SurfaceMesh::size_type(mesh.vertices.size()), SurfaceMesh::size_type(3 * mesh.triangles.size() / 2),
                  SurfaceMesh::size_type(mesh.triangles.size()));
  for (const auto& v : mesh.vertices) surface.add_vertex(point(v));
  using Index = SurfaceMesh::Vertex_index;
  std::vector<int> faces, user_face;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto& t = mesh.triangles[f];
    if (surface.add_face(Index(t[0]), Index(t[1]), Index(t[2])) != SurfaceMesh::null_face()) user_face.push_back(int(f));
    else faces.push_back(int(f));  // it would be the third at an edge
  }
  std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections<CGAL::Parallel_if_available_tag>(surface, std::back_inserter(pairs));
  for (const auto& [f, g] : pairs) {
    faces.push_back(user_face[std::size_t(f)]);
    faces.push_back(user_face[std::size_t(g)]);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

std::vector<Eigen::Vector3i> fill_loop(const std::vector<Eigen::Vector3d>& loop) {
  std::vector<Kernel::Point_3> points;
  for (const auto& p : loop) points.push_back(point(p));
  using Patch = CGAL::Triple<int, int, int>;
  std::vector<Patch> patch;
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(points, std::back_inserter(patch));
  std::vector<Eigen::Vector3i> triangles;
  for (const Patch& t : patch) triangles.emplace_back(t.first, t.second, t.third);
  return triangles;
}

}  // namespace transformables
