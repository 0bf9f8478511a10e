#include <gtest/gtest.h>

#include <map>

#include "segmentation/cases.h"
#include "segmentation/division.h"

namespace transformables {
namespace {

using namespace cases;

const Vector3d kHalf(0.25, 0.1, 0.08);

// Twelve triangles, corner k at the side that each of its bits says.
TriangleMesh box_mesh(const Vector3d& centre, const Vector3d& half) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) mesh.vertices.push_back(centre + half.cwiseProduct(Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Target meshed_box(int resolution) {
  Target target = box_target(kHalf, resolution);
  target.mesh = box_mesh(Vector3d::Zero(), kHalf);
  return target;
}

TEST(Division, HasNoLongEdgeAndNoCrackAndIsTheTargetsSurfaceStill) {
  const Target target = meshed_box(32);
  const Segmentation s = cut_in_halves(half_boxes(target, 0), target);
  const double h = target.distance.shape.step;
  for (const double spacing : {1.0, 3.7}) {
    const TriangleMesh mesh = division(s, target, spacing).mesh;
    std::map<std::pair<int, int>, int> edges;
    for (const auto& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        ++edges[{t[k], t[(k + 1) % 3]}];
        ASSERT_LE((mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm(), spacing * h);
      }
    for (const auto& [edge, count] : edges) {
      ASSERT_EQ(count, 1);
      ASSERT_EQ(edges.count({edge.second, edge.first}), 1u) << "a triangle on the edge's other side";
    }
    EXPECT_NEAR(signed_volume(mesh), 8 * kHalf.prod(), 1e-9);
  }
}

TEST(Division, GivesEachVertexThePartThatIsThere) {
  const Target target = meshed_box(48);
  const Segmentation s = cut_in_halves(half_boxes(target, 0), target);
  const double h = target.distance.shape.step;
  const Division parts = division(s, target);
  ASSERT_EQ(parts.bones.size(), parts.mesh.vertices.size());
  for (std::size_t i = 0; i < parts.bones.size(); ++i) {
    const double x = parts.mesh.vertices[i].x();
    if (std::abs(x) > 0.1 * h) {
      ASSERT_EQ(parts.bones[i], x < 0 ? 0 : 1) << x;
    }
  }
}

TEST(Division, LeavesAPieceOfTheTargetThatIsNotFilledToNoBone) {
  Target target = meshed_box(32);
  const Segmentation s = cut_in_halves(half_boxes(target, 0), target);
  const TriangleMesh apart = box_mesh({0, 0.4, 0}, Vector3d::Constant(0.02));
  const int first = int(target.mesh.vertices.size());
  target.mesh.vertices.insert(target.mesh.vertices.end(), apart.vertices.begin(), apart.vertices.end());
  for (const auto& t : apart.triangles) target.mesh.triangles.push_back(t + Vector3i::Constant(first));
  const Division parts = division(s, target);
  for (std::size_t i = 0; i < parts.bones.size(); ++i) ASSERT_EQ(parts.bones[i] < 0, parts.mesh.vertices[i].y() > 0.3);
}

TEST(Division, RefusesASegmentationOfAnotherTargetAndASpacingOutOfRange) {
  const Target target = meshed_box(32);
  const Segmentation s = cut_in_halves(half_boxes(target, 0), target);
  EXPECT_THROW(division(s, meshed_box(24)), InvalidInput);
  for (const double spacing : {0.2, 17.0, std::nan("")}) EXPECT_THROW(division(s, target, spacing), InvalidInput);
}

}  // namespace
}  // namespace transformables
