// Parts that keep the target's own triangles outside: a ball of triangles, cut in two.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "cases.h"
#include "finishing/exact_cut.h"
#include "finishing/finishing.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using finishing::CuttableTarget;
using finishing::SourcedMesh;

/// A ball with rings of vertices about Y.
TriangleMesh ball(double radius, int rings, int segments) {
  TriangleMesh mesh;
  const auto place = [&](double polar, double around) -> Vector3d {
    return Vector3d(std::sin(polar) * std::cos(around), std::cos(polar), std::sin(polar) * std::sin(around)) * radius;
  };
  for (int r = 1; r < rings; ++r)
    for (int s = 0; s < segments; ++s)
      mesh.vertices.push_back(place(std::numbers::pi * r / rings, 2 * std::numbers::pi * s / segments));
  const int top = int(mesh.vertices.size()), bottom = top + 1;
  mesh.vertices.push_back(place(0, 0));
  mesh.vertices.push_back(place(std::numbers::pi, 0));
  const auto at = [&](int r, int s) { return (r - 1) * segments + (s % segments); };
  for (int s = 0; s < segments; ++s) {
    mesh.triangles.emplace_back(top, at(1, s + 1), at(1, s));
    mesh.triangles.emplace_back(bottom, at(rings - 1, s), at(rings - 1, s + 1));
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.triangles.emplace_back(at(r, s), at(r, s + 1), at(r + 1, s));
      mesh.triangles.emplace_back(at(r, s + 1), at(r + 1, s + 1), at(r + 1, s));
    }
  }
  return mesh;
}

double height_over(const TriangleMesh& mesh, int triangle, const Vector3d& p) {
  const auto& t = mesh.triangles[triangle];
  const Vector3d a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized().dot(p - a);
}

void expect_on_sources(const SourcedMesh& part, const TriangleMesh& target, const Eigen::Isometry3d& back, double tolerance) {
  ASSERT_EQ(part.source.size(), part.mesh.triangles.size());
  for (std::size_t n = 0; n < part.source.size(); ++n) {
    if (part.source[n] < 0) continue;
    ASSERT_LT(part.source[n], int(target.triangles.size()));
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(std::abs(height_over(target, part.source[n], back * part.mesh.vertices[part.mesh.triangles[n][k]])), tolerance);
  }
}

TEST(ExactCut, KeepsWholeTrianglesAwayFromTheCutAndPiecesOfThemAtIt) {
  const TriangleMesh target = ball(0.25, 20, 31);
  const auto part = CuttableTarget(target).cut(box_mesh({-1, 0.013, -1}, {1, 1, 1}));
  ASSERT_TRUE(part);
  EXPECT_TRUE(check(part->mesh).good());
  expect_on_sources(*part, target, Eigen::Isometry3d::Identity(), 1e-12);
  std::set<std::int32_t> kept(part->source.begin(), part->source.end());
  EXPECT_TRUE(kept.count(-1));
  for (int n = 0; n < int(target.triangles.size()); ++n) {
    const auto& t = target.triangles[n];
    int above = 0;
    for (int k = 0; k < 3; ++k) above += target.vertices[t[k]].y() > 0.013;
    EXPECT_EQ(kept.count(n), above > 0 ? 1u : 0u) << "triangle " << n;
  }
}

TEST(ExactCut, TwoComplementsMakeUpTheTarget) {
  const TriangleMesh target = ball(0.25, 16, 23);
  const CuttableTarget cuttable(target);
  const auto upper = cuttable.cut(box_mesh({-1, 0.0701, -1}, {1, 1, 1})), lower = cuttable.cut(box_mesh({-1, -1, -1}, {1, 0.0701, 1}));
  ASSERT_TRUE(upper && lower);
  EXPECT_NEAR(signed_volume(upper->mesh) + signed_volume(lower->mesh), signed_volume(target), 1e-9);
}

TEST(ExactCut, GivesTheLargestPieceOnlyAndNothingWhereNothingIsShared) {
  TriangleMesh target = ball(0.1, 12, 16);
  const TriangleMesh second = box_mesh({0.2, -0.01, -0.01}, {0.22, 0.01, 0.01});
  for (const auto& t : second.triangles) target.triangles.push_back(t + Eigen::Vector3i::Constant(int(target.vertices.size())));
  target.vertices.insert(target.vertices.end(), second.vertices.begin(), second.vertices.end());
  const CuttableTarget cuttable(target);
  auto part = cuttable.cut(box_mesh({-1, 0.003, -1}, {1, 1, 1}));
  ASSERT_TRUE(part);
  ASSERT_TRUE(finishing::round_and_tidy(*part, Eigen::Isometry3d::Identity(), 1));
  EXPECT_TRUE(check(part->mesh).good());
  for (const Vector3d& v : part->mesh.vertices) EXPECT_LT(v.x(), 0.15);
  EXPECT_FALSE(cuttable.cut(box_mesh({2, 2, 2}, {3, 3, 3})));
}

TEST(ExactCut, ATargetThatIsOpenOrNotManifoldIsNotUsable) {
  TriangleMesh open = ball(0.2, 8, 9);
  open.triangles.pop_back();
  EXPECT_FALSE(CuttableTarget(open).usable());
  EXPECT_FALSE(CuttableTarget(open).cut(box_mesh({-1, 0.01, -1}, {1, 1, 1})));
  TriangleMesh doubled = ball(0.2, 8, 9);
  doubled.triangles.push_back(doubled.triangles[0]);
  EXPECT_FALSE(CuttableTarget(doubled).usable());
}

constexpr double kScale = 0.37;   // not a power of two, so that numbers of single precision differ from those in target units

TEST(RoundAndTidy, CutsThatPassByVerticesAtAnyTinyDistanceStaySimpleAfterRounding) {
  const TriangleMesh target = ball(0.25, 20, 31);
  const CuttableTarget cuttable(target);
  const double ring = 0.25 * std::cos(std::numbers::pi * 7 / 20);
  Eigen::Isometry3d into = Eigen::Isometry3d::Identity();
  into.linear() = Eigen::Quaterniond(0.3, 0.5, -0.7, 0.2).normalized().toRotationMatrix();
  into.translation() = Vector3d(0.2, 0.1, -0.2);
  for (double beside : {0.0, 1e-16, 1e-12, 3e-9, -3e-9, 2e-8, -6e-8, 1e-7, 4e-7, -1e-6, 5e-6, 1e-4}) {
    auto part = cuttable.cut(box_mesh({-1, ring + beside, -1}, {1, 1, 1}));
    ASSERT_TRUE(part) << beside;
    ASSERT_TRUE(finishing::round_and_tidy(*part, into, kScale)) << beside;
    EXPECT_TRUE(check(part->mesh).good()) << beside;
    expect_on_sources(*part, target, into.inverse(), 2e-5);
    for (const Vector3d& v : part->mesh.vertices)
      for (int k = 0; k < 3; ++k) EXPECT_EQ(v[k], finishing::rounded_to_float(v[k], kScale));
  }
}

TEST(RoundAndTidy, SaysWhenAMeshMeetsItselfBeyondRepair) {
  SourcedMesh crossed{box_mesh({0, 0, 0}, {1, 1, 1}), std::vector<std::int32_t>(12, -1)};
  crossed.mesh.vertices[0] = {0.8, 0.8, 2};
  EXPECT_FALSE(finishing::round_and_tidy(crossed, Eigen::Isometry3d::Identity(), 1));
}

}  // namespace
}  // namespace transformables
