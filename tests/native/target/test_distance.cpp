// Distances to a mesh are distances.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cases.h"

namespace transformables {
namespace {

// ---- distances --------------------------------------------------------------------------------------------------

GridShape grid_of(int size, double half) {
  return {Vector3i::Constant(size), Vector3d::Constant(-half), 2 * half / (size - 1)};
}

TEST(SignedDistance, of_a_ball_is_the_distance_to_its_faces_near_it_and_grows_beyond) {
  const TriangleMesh mesh = ball(Vector3d(0.01, 0, -0.02), 0.2, 12);
  const Grid<float> grid = signed_distance(mesh, grid_of(48, 0.5));
  const double h = grid.shape.step;
  for (std::size_t i = 0; i < grid.values.size(); i += 7) {
    const Vector3d p = grid.shape.position(i);
    const double exact = distance_to_mesh(mesh, p) * (winding_number(mesh, p) > 0.5 ? -1 : 1);
    if (std::abs(exact) < 3.99 * h) {
      ASSERT_NEAR(grid[i], exact, 1e-6) << p.transpose();
    } else {
      ASSERT_GE(std::abs(grid[i]), 3.99 * h);
      ASSERT_NEAR(grid[i], exact, 0.5 * h + 0.03 * std::abs(exact)) << p.transpose();
    }
  }
}

TEST(SignedDistance, of_a_box_on_the_very_samples_has_the_right_sign_everywhere) {
  // Corners, edges and diagonals of the faces all lie on samples.
  const TriangleMesh mesh = box(Vector3d::Constant(-0.25), Vector3d(0.25, 0.125, 0.25));
  const Grid<float> grid = signed_distance(mesh, grid_of(33, 0.5));
  for (std::size_t i = 0; i < grid.values.size(); ++i) {
    const Vector3d p = grid.shape.position(i);
    const double outside = std::max({std::abs(p.x()) - 0.25, p.y() - 0.125, -0.25 - p.y(), std::abs(p.z()) - 0.25});
    if (std::abs(outside) < 1e-9) ASSERT_NEAR(grid[i], 0, 1e-7);
    else ASSERT_EQ(grid[i] < 0, outside < 0) << p.transpose();
  }
}

TEST(SignedDistance, of_a_turned_box_agrees_with_the_winding_number) {
  const TriangleMesh mesh = turned(box(Vector3d(-0.2, -0.01, -0.15), Vector3d(0.2, 0.01, 0.15)));
  const Grid<float> grid = signed_distance(mesh, grid_of(40, 0.3));
  for (std::size_t i = 0; i < grid.values.size(); ++i)
    ASSERT_EQ(grid[i] < 0, winding_number(mesh, grid.shape.position(i)) > 0.5);
}

TEST(SignedDistance, keeps_a_cavity_empty) {
  const TriangleMesh mesh = joined(ball(Vector3d::Zero(), 0.2, 8), inside_out(ball(Vector3d::Zero(), 0.1, 8)));
  const Grid<float> grid = signed_distance(mesh, grid_of(33, 0.5));
  EXPECT_GT(sample(grid, Vector3d::Zero()), 0.05f);
  EXPECT_LT(sample(grid, Vector3d(0.15, 0, 0)), 0);
}

TEST(SignedDistance, on_a_grid_that_the_surface_does_not_reach_still_has_the_right_sign) {
  const TriangleMesh mesh = ball(Vector3d::Zero(), 0.2, 8);
  GridShape shape{Vector3i::Constant(5), Vector3d(0.3, 0.3, 0.3), 0.001};
  for (const float v : signed_distance(mesh, shape).values) EXPECT_NEAR(v, std::sqrt(0.27) - 0.2, 0.02);
  shape.origin = Vector3d::Zero();
  for (const float v : signed_distance(mesh, shape).values) EXPECT_NEAR(v, -0.195, 0.02);
}

TEST(SignedDistance, of_a_large_grid_is_exact_near_the_surface_and_close_beyond) {
  const TriangleMesh mesh = ball(Vector3d::Zero(), 0.3, 40);
  const Grid<float> grid = signed_distance(mesh, grid_of(160, 0.5));  // large enough to be swept at every second sample
  for (std::size_t i = 0; i < grid.values.size(); i += 101) {
    const double exact = grid.shape.position(i).norm() - 0.3;
    ASSERT_NEAR(grid[i], exact, std::abs(exact) > 3.9 * grid.shape.step ? 2 * grid.shape.step + 0.03 * std::abs(exact) : 0.1 * grid.shape.step);
  }
}

TEST(SignedDistance, of_nothing_or_on_no_grid_is_an_error) {
  const TriangleMesh mesh = box(Vector3d::Zero(), Vector3d::Ones());
  EXPECT_THROW(signed_distance(TriangleMesh{}, grid_of(8, 1)), InvalidInput);
  EXPECT_THROW(signed_distance(mesh, GridShape{Vector3i(0, 4, 4), Vector3d::Zero(), 1}), InvalidInput);
  EXPECT_THROW(signed_distance(mesh, GridShape{Vector3i(4, 4, 4), Vector3d::Zero(), 0}), InvalidInput);
  EXPECT_THROW(signed_distance(mesh, GridShape{Vector3i::Constant(2000), Vector3d::Zero(), 1}), InvalidInput);
}

}  // namespace
}  // namespace transformables
