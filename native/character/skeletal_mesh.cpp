#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <cmath>
#include <string>

#include "character/character.h"
#include "common/error.h"

namespace transformables {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Hull = CGAL::Surface_mesh<Kernel::Point_3>;

/// Corners and edge middles of an icosahedron, on the unit sphere: 42 points.
std::vector<Eigen::Vector3d> ball_samples() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::Vector3d> points;
  for (int axis = 0; axis < 3; ++axis)
    for (const double one : {-1.0, 1.0})
      for (const double long_side : {-golden, golden}) {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        p[(axis + 1) % 3] = one;
        p[(axis + 2) % 3] = long_side;
        points.push_back(p);
      }
  constexpr double kEdge = 2;  // of this icosahedron
  const std::size_t corners = points.size();
  for (std::size_t i = 0; i < corners; ++i)
    for (std::size_t j = i + 1; j < corners; ++j)
      if ((points[i] - points[j]).norm() < 1.1 * kEdge) points.push_back(points[i] + points[j]);
  for (Eigen::Vector3d& p : points) p.normalize();
  return points;
}

void append_hull(const Segment& segment, double radius, const std::vector<Eigen::Vector3d>& ball, TriangleMesh& mesh) {
  std::vector<Kernel::Point_3> points;
  for (const Eigen::Vector3d& end : {segment.a, segment.b})
    for (const Eigen::Vector3d& direction : ball) {
      const Eigen::Vector3d p = end + radius * direction;
      points.emplace_back(p.x(), p.y(), p.z());
    }
  Hull hull;
  CGAL::convex_hull_3(points.begin(), points.end(), hull);
  const int first = int(mesh.vertices.size());
  for (const auto v : hull.vertices()) {
    const auto& p = hull.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : hull.faces()) {
    Eigen::Vector3i corners;
    int k = 0;
    for (const auto v : hull.vertices_around_face(hull.halfedge(f))) corners[k++] = first + int(v.idx());
    mesh.triangles.push_back(corners);
  }
}

}  // namespace

TriangleMesh skeletal_mesh(const Character& character, const Morphology& morphology, int bone) {
  if (bone < 0 || bone >= int(character.bones.size()))
    throw InvalidInput("the character has no bone with index " + std::to_string(bone));
  if (morphology.size() != Eigen::Index(character.bones.size()))
    throw InvalidInput("a morphology of this character needs " + std::to_string(character.bones.size()) +
                       " factors, not " + std::to_string(morphology.size()));
  const Bone& source = character.bones[bone];
  if (!(source.radius > 0))
    throw InvalidInput("bone '" + source.name + "' has no radius yet: fit the character to a target first");
  const std::vector<Eigen::Vector3d> ball = ball_samples();
  TriangleMesh mesh;
  for (const Segment& s : skeleton_of(source, morphology[bone])) append_hull(s, source.radius, ball, mesh);
  return mesh;
}

}  // namespace transformables
