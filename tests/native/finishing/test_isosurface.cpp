// Surfaces of sampled fields, and the check that every part has to pass.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "cases.h"
#include "finishing/finishing.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

TEST(Isosurface, OfASphereIsGoodAndHasItsVolume) {
  const TriangleMesh mesh = isosurface(sampled_field(41, 0.05, [](const Vector3d& p) { return p.norm() - 0.8; }));
  expect_good(mesh);
  const double exact = 4 * std::numbers::pi / 3 * 0.512;
  EXPECT_NEAR(signed_volume(mesh), exact, 0.01 * exact);
  for (const Vector3d& v : mesh.vertices) EXPECT_NEAR(v.norm(), 0.8, 0.05 * 0.05 + 0.001);
}

TEST(Isosurface, OfATorusHasItsGenus) {
  const TriangleMesh mesh = isosurface(sampled_field(51, 0.04, [](const Vector3d& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - 0.6, p.z()) - 0.2;
  }));
  expect_good(mesh);
  EXPECT_EQ(int(mesh.vertices.size()) - int(mesh.triangles.size()) / 2, 0);
}

TEST(Isosurface, OfShapesThatTouchAtACornerIsStillManifold) {
  Grid<float> field = sampled_field(6, 1, [](const Vector3d&) { return 1.0; });
  field.at({2, 2, 2}) = field.at({3, 3, 3}) = -1;
  field.at({2, 3, 2}) = -1;
  const MeshCheck c = check(isosurface(field));
  EXPECT_FALSE(c.open || c.non_manifold || c.self_intersecting || c.inside_out);
}

TEST(Isosurface, OfAnyNoiseIsClosedManifoldAndSimpleAfterTurningAndRoundingToFloat) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, 0.5, -0.7, 0.2).normalized();
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Random random{seed};
    Grid<float> field = sampled_field(16, 0.002, [](const Vector3d&) { return 1.0; });
    for (std::size_t n = 0; n < field.values.size(); ++n) {
      const Eigen::Vector3i c = field.shape.cell(n);
      if ((c.array() == 0).any() || (c.array() == 15).any()) continue;
      const double value = random() - 0.5, kind = random();
      field[n] = float(seed % 3 == 0 ? value : seed % 3 == 1 ? std::copysign(kind < 0.5 ? 1e-7 : 1, value) : kind < 0.3 ? 0 : value);
    }
    TriangleMesh mesh = isosurface(field);
    for (Vector3d& v : mesh.vertices) v = (turn * v + Vector3d(0.2, 0.1, -0.2)).unaryExpr(&to_float);
    const MeshCheck c = check(mesh);
    EXPECT_FALSE(c.open || c.non_manifold || c.self_intersecting || c.inside_out) << "seed " << seed;
  }
}

TEST(Isosurface, RefusesASolidThatReachesTheBorder) {
  EXPECT_THROW(isosurface(sampled_field(8, 1, [](const Vector3d&) { return -1.0; })), InvalidInput);
  Grid<float> nothing = sampled_field(4, 1, [](const Vector3d&) { return std::nan(""); });
  EXPECT_THROW(isosurface(nothing), InvalidInput);
  nothing.values.pop_back();
  EXPECT_THROW(isosurface(nothing), InvalidInput);
}

TEST(Check, SeesEachFault) {
  const TriangleMesh good = box_mesh(Vector3d::Zero(), Vector3d::Ones());
  EXPECT_TRUE(check(good).good());
  TriangleMesh bad = good;
  bad.triangles.pop_back();
  EXPECT_TRUE(check(bad).open);
  bad = good;
  bad.triangles.push_back(bad.triangles[0]);
  EXPECT_TRUE(check(bad).non_manifold);
  bad = good;
  for (auto& t : bad.triangles) std::swap(t[0], t[1]);
  EXPECT_TRUE(check(bad).inside_out);
  bad = good;
  bad.vertices[0] = {0.8, 0.8, 2};
  EXPECT_TRUE(check(bad).self_intersecting);
  bad = good;
  for (const auto& v : good.vertices) bad.vertices.push_back(v + Vector3d(3, 0, 0));
  for (const auto& t : good.triangles) bad.triangles.push_back(t + Eigen::Vector3i::Constant(8));
  EXPECT_EQ(check(bad).extra_pieces, 1);
  bad = good;
  bad.vertices[0].x() = std::nan("");
  EXPECT_FALSE(check(bad).good());
  EXPECT_FALSE(check({}).good());
}

TEST(Check, SeesTwoFansAboutOneVertex) {
  TriangleMesh mesh = box_mesh(Vector3d::Zero(), Vector3d::Ones());
  const TriangleMesh other = box_mesh(Vector3d::Ones(), 2 * Vector3d::Ones());
  for (const auto& v : other.vertices) mesh.vertices.push_back(v);
  for (const auto& t : other.triangles) mesh.triangles.push_back(t.unaryExpr([](int v) { return v == 0 ? 7 : v + 8; }));
  EXPECT_TRUE(check(mesh).non_manifold);
}

}  // namespace
}  // namespace transformables
