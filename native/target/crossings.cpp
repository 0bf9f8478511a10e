// The one translation unit that instantiates CGAL's polygon mesh processing for this room.
#include "target/crossings.h"

#define CGAL_LINKED_WITH_TBB 1
#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/utility.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace transformables {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

Kernel::Point_3 point(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

/// Some 10^4 times what rounding can do to a coordinate of a target.
constexpr double kMargin = 1e-12;

using Eigen::Vector3d;

bool apart_along(const Vector3d& axis, const Vector3d* p, const Vector3d* q) {
  const auto [p_low, p_high] = std::minmax({axis.dot(p[0]), axis.dot(p[1]), axis.dot(p[2])});
  const auto [q_low, q_high] = std::minmax({axis.dot(q[0]), axis.dot(q[1]), axis.dot(q[2])});
  return p_low > q_high + kMargin || q_low > p_high + kMargin;
}

/// Apart by more than rounding, as far as the planes of both and the sides within their planes show.
bool surely_apart(const Vector3d* p, const Vector3d* q) {
  const Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]).normalized(), m = (q[1] - q[0]).cross(q[2] - q[0]).normalized();
  if (apart_along(n, p, q) || apart_along(m, p, q)) return true;
  for (int c = 0; c < 3; ++c)
    if (apart_along(n.cross(p[(c + 1) % 3] - p[c]).normalized(), p, q) ||
        apart_along(m.cross(q[(c + 1) % 3] - q[c]).normalized(), p, q))
      return true;
  return false;
}

/// Two triangles with first corner in common that surely meet nowhere else.
bool surely_only_corner(const Vector3d* p, const Vector3d* q) {
  const Vector3d u[2] = {p[1] - p[0], p[2] - p[0]}, v[2] = {q[1] - p[0], q[2] - p[0]};
  const Vector3d n = u[0].cross(u[1]).normalized(), m = v[0].cross(v[1]).normalized();
  const auto one_side = [](const Vector3d& axis, const Vector3d* w) {
    return (axis.dot(w[0]) > kMargin && axis.dot(w[1]) > kMargin) || (axis.dot(w[0]) < -kMargin && axis.dot(w[1]) < -kMargin);
  };
  if (one_side(n, v) || one_side(m, u)) return true;
  const Vector3d between = (u[0].normalized() + u[1].normalized() - v[0].normalized() - v[1].normalized()).normalized();
  return std::min(between.dot(u[0]), between.dot(u[1])) > kMargin && std::max(between.dot(v[0]), between.dot(v[1])) < -kMargin;
}

/// Quick, and on the safe side: false sends both faces to the exact test. Neighbouring faces that lie nearly in one plane
/// are what exact predicates are slow at, and finely divided meshes consist of them.
bool surely_clear(const TriangleMesh& mesh, int f, int g) {
  const Eigen::Vector3i &s = mesh.triangles[f], &t = mesh.triangles[g];
  int shared = 0, at_s = 0, at_t = 0;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      if (s[c] == t[d]) ++shared, at_s = c, at_t = d;
  Vector3d p[3], q[3];
  for (int c = 0; c < 3; ++c) p[c] = mesh.vertices[s[(at_s + c) % 3]], q[c] = mesh.vertices[t[(at_t + c) % 3]];
  if (shared == 0) return surely_apart(p, q);
  if (shared == 1) return surely_only_corner(p, q);
  const Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]).normalized(), m = (q[1] - q[0]).cross(q[2] - q[0]).normalized();
  return shared == 2 && n.dot(m) > -0.99;  // across an edge they can only meet when folded flat
}

/// Faces that may cross another, ascending.
std::vector<int> suspects(const TriangleMesh& mesh) {
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;
  std::vector<Box> boxes;
  boxes.reserve(mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    CGAL::Bbox_3 box;
    for (int c = 0; c < 3; ++c) box += point(mesh.vertices[mesh.triangles[f][c]]).bbox();
    boxes.emplace_back(box, int(f));
  }
  std::vector<std::atomic<char>> marked(mesh.triangles.size());
  CGAL::box_self_intersection_d<CGAL::Parallel_if_available_tag>(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    if (surely_clear(mesh, a.info(), b.info())) return;
    marked[a.info()].store(1, std::memory_order_relaxed);
    marked[b.info()].store(1, std::memory_order_relaxed);
  });
  std::vector<int> faces;
  for (std::size_t f = 0; f < marked.size(); ++f)
    if (marked[f].load(std::memory_order_relaxed)) faces.push_back(int(f));
  return faces;
}

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
  std::vector<SurfaceMesh::Face_index> unclear;
  for (const int f : suspects(mesh)) {
    const auto place = std::lower_bound(user_face.begin(), user_face.end(), f);
    if (place != user_face.end() && *place == f)
      unclear.push_back(SurfaceMesh::Face_index(SurfaceMesh::size_type(place - user_face.begin())));
  }
  std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections<CGAL::Parallel_if_available_tag>(unclear, surface, std::back_inserter(pairs));
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
