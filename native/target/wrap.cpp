// The one translation unit that instantiates CGAL's alpha wrapping.
#include "target/wrap.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <vector>

namespace transformables {

TriangleMesh alpha_wrap(const TriangleMesh& soup, double alpha, double offset) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_3> points;
  for (const auto& v : soup.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<std::array<int, 3>> faces;
  for (const auto& t : soup.triangles) faces.push_back({t[0], t[1], t[2]});
  CGAL::Surface_mesh<Kernel::Point_3> wrap;
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap);
  wrap.collect_garbage();

  TriangleMesh out;
  for (const auto v : wrap.vertices()) {
    const auto& p = wrap.point(v);
    out.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : wrap.faces()) {
    Eigen::Vector3i t;
    int c = 0;
    for (const auto v : wrap.vertices_around_face(wrap.halfedge(f))) t[c++] = int(v);
    out.triangles.push_back(t);
  }
  return out;
}

}  // namespace transformables
