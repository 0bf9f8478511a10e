// Skeletal shapes and their meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "cases.h"
#include "common/error.h"

namespace transformables {
namespace {

// ---- shapes

Character fitted_arm() { return fitted(make_character(arm()), 0.03, 0.5, 0.01); }

TEST(SkeletalShape, ItIsTheCapsulesLessTheRoomsOfItsChildren) {
  Dice dice(18);
  const Character c = fitted_arm();
  const double gap = 0.002;
  const Morphology m = random_morphology(c, dice);
  const auto shapes = skeletal_shapes(c, m, gap);
  ASSERT_EQ(shapes.size(), c.bones.size());
  int inside = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (int n = 0; n < 3000; ++n) {
      const Segment& s = shapes[i].capsules[0];
      const Vector3d p = s.a + dice(-0.2, 1.2) * (s.b - s.a) + dice.point(2 * c.bones[i].radius);
      bool expected = distance(s, p) < c.bones[i].radius;
      for (const Bone& child : c.bones)
        if (child.parent == int(i)) expected = expected && (p - m[i] * child.head_in_parent).norm() > child.radius + gap;
      EXPECT_EQ(shapes[i].distance(p) < 0, expected);
      inside += expected;
    }
  EXPECT_GT(inside, 100);
}

TEST(SkeletalShape, ABoneContainsItsOwnHeadAndKeepsClearOfItsChildrensHousings) {
  const Character c = fitted_arm();
  const auto shapes = skeletal_shapes(c, ones(c), 0.003);
  for (const SkeletalShape& shape : shapes) EXPECT_NEAR(shape.distance(Vector3d::Zero()), -shape.radius, 1e-12);
  for (std::size_t i = 1; i < c.bones.size(); ++i)
    EXPECT_NEAR(shapes[c.bones[i].parent].distance(c.bones[i].head_in_parent), c.bones[i].radius + 0.003, 1e-12);
}

TEST(SkeletalShape, NoBoneIsSwallowedByARoomHoweverNearItsChildsHead) {
  for (const double share : {0.0, 1e-9, 0.5, 1.0, 1.2, 1.5, 2.0, 3.0})
    for (const double gap : {0.0, 0.001, 0.05}) {
      Character c = fitted_arm();
      const double r = c.bones[1].radius;
      c.bones[2].head_in_parent = Vector3d(0, share * r, 0);
      c.bones[1].segments = {{Vector3d::Zero(), c.bones[2].head_in_parent}};
      const SkeletalShape shape = skeletal_shapes(c, ones(c), gap)[1];
      EXPECT_LE(shape.distance(Vector3d::Zero()), -0.2 * r + 1e-12) << share << " " << gap;
    }
}

TEST(SkeletalShape, DistanceNeverChangesFasterThanThePointMoves) {
  Dice dice(19);
  const Character c = fitted_arm();
  for (const SkeletalShape& shape : skeletal_shapes(c, ones(c), 0.002))
    for (int n = 0; n < 1000; ++n) {
      const Vector3d p = dice.point(0.4), q = p + dice.point(0.01);
      EXPECT_LE(std::abs(shape.distance(p) - shape.distance(q)), (p - q).norm() + 1e-12);
    }
}

TEST(SkeletalShape, RefusesAGapOrAMorphologyThatMeansNothing) {
  const Character c = fitted_arm();
  for (const double bad : {-0.001, std::nan(""), HUGE_VAL}) EXPECT_THROW(skeletal_shapes(c, ones(c), bad), InvalidInput);
  EXPECT_THROW(skeletal_shapes(c, Morphology::Ones(2), 0.001), InvalidInput);
}

/// Every edge is used once in each direction.
bool closed(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (!edges.insert({t[k], t[(k + 1) % 3]}).second) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return edges.count({e.second, e.first}) == 1; });
}

TEST(SkeletalMesh, IsClosedAndOutwardAndFollowsItsCapsules) {
  const Character c = fitted(make_character(arm_with_fixed_bones()), 0.03, 0.5, 0.01);
  Morphology m = ones(c);
  m[1] = 1.7;
  for (int i = 0; i < int(c.bones.size()); ++i) {
    const TriangleMesh mesh = skeletal_mesh(c, m, i);
    const double r = c.bones[i].radius;
    EXPECT_TRUE(closed(mesh));
    double capsules = 0;
    const auto segments = skeleton_of(c.bones[i], m[i]);
    for (const Segment& s : segments) capsules += kPi * r * r * ((s.b - s.a).norm() + 4 * r / 3);
    EXPECT_GT(signed_volume(mesh), 0.8 * capsules);
    EXPECT_LT(signed_volume(mesh), capsules);
    for (const Vector3d& v : mesh.vertices) {
      double d = HUGE_VAL;
      for (const Segment& s : segments) d = std::min(d, distance(s, v));
      EXPECT_LT(d, r + 1e-9);
      EXPECT_GT(d, -1e-9);
    }
  }
}

TEST(SkeletalMesh, ABoneWithoutLengthIsABall) {
  auto bones = arm();
  bones[2].head = bones[1].head;
  const Character c = fitted(make_character(bones), 0.03, 0.5, 0.01);
  const TriangleMesh mesh = skeletal_mesh(c, ones(c), 1);
  EXPECT_EQ(mesh.vertices.size(), 42u);
  EXPECT_EQ(mesh.triangles.size(), 80u);
  EXPECT_TRUE(closed(mesh));
  EXPECT_GT(signed_volume(mesh), 0);
}

TEST(SkeletalMesh, RefusesBonesThatDoNotExistOrHaveNoRadius) {
  const Character c = fitted_arm();
  EXPECT_THROW(skeletal_mesh(c, ones(c), -1), InvalidInput);
  EXPECT_THROW(skeletal_mesh(c, ones(c), 3), InvalidInput);
  EXPECT_THROW(skeletal_mesh(c, Morphology::Ones(1), 0), InvalidInput);
  const Character raw = make_character(arm());
  EXPECT_THROW(skeletal_mesh(raw, ones(raw), 0), InvalidInput);
}

}  // namespace
}  // namespace transformables
