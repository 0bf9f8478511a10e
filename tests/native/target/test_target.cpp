// Dirty meshes become solids or clear errors.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "cases.h"
#include "target/voxels.h"

namespace transformables {
namespace {

// ---- targets ----------------------------------------------------------------------------------------------------

TEST(Target, of_a_ball_has_its_volume_and_distances) {
  const TriangleMesh mesh = ball(Vector3d(3, -2, 8), 2, 40);
  const Target target = target_of(mesh, 64);
  expect_sound(target);
  EXPECT_TRUE(target.exact_surface);
  EXPECT_TRUE(target.warnings.empty());
  EXPECT_NEAR(target.scale, kLongestSide / 4, 1e-12);
  EXPECT_LT((target.centre - Vector3d(3, -2, 8)).norm(), 1e-9);
  const double h = target.distance.shape.step;
  EXPECT_NEAR(h, kLongestSide / 64, 1e-12);
  EXPECT_NEAR(target.volume, 4 * std::numbers::pi / 3 * std::pow(0.25, 3), 0.005 * target.volume);
  EXPECT_NEAR(double(target.inside.size()) * h * h * h, target.volume, 0.01 * target.volume);
  for (std::size_t i = 0; i < target.distance.values.size(); ++i) {
    const double exact = target.distance.shape.position(i).norm() - 0.25;
    ASSERT_NEAR(target.distance[i], exact, 0.1 * h + (std::abs(exact) > 3.9 * h ? 0.4 * h + 0.03 * std::abs(exact) : 0));
  }
}

TEST(Target, of_a_box_keeps_the_users_faces_in_their_place) {
  const TriangleMesh mesh = box(Vector3d(1, 1, 1), Vector3d(5, 3, 2));
  const Target target = target_of(mesh);
  expect_sound(target);
  ASSERT_EQ(target.mesh.vertices.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    EXPECT_LT((target.mesh.vertices[v] - (mesh.vertices[v] - target.centre) * target.scale).norm(), 1e-12);
  EXPECT_EQ(target.mesh.triangles, mesh.triangles);
}

TEST(Target, that_was_inside_out_is_turned) {
  const TriangleMesh mesh = ball(Vector3d::Zero(), 1, 8);
  const Target target = target_of(inside_out(mesh));
  expect_sound(target);
  EXPECT_TRUE(target.exact_surface);
  EXPECT_NEAR(target.volume, target_of(mesh).volume, 1e-12);
  EXPECT_EQ(target.warnings.size(), 1u);
}

TEST(Target, with_faces_turned_at_random_is_the_same_as_without) {
  TriangleMesh mesh = ball(Vector3d::Zero(), 1, 8);
  const Target sound = target_of(mesh);
  for (std::size_t f = 0; f < mesh.triangles.size(); f += 3) std::swap(mesh.triangles[f][0], mesh.triangles[f][1]);
  const Target target = target_of(mesh);
  expect_sound(target);
  EXPECT_EQ(target.inside, sound.inside);
}

TEST(Target, without_shared_vertices_is_welded) {
  const TriangleMesh mesh = ball(Vector3d::Zero(), 1, 8);
  TriangleMesh soup;
  for (const Vector3i& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) soup.vertices.push_back(mesh.vertices[t[c]]);
    soup.triangles.emplace_back(int(soup.vertices.size()) - 3, int(soup.vertices.size()) - 2, int(soup.vertices.size()) - 1);
  }
  const Target target = target_of(soup);
  EXPECT_TRUE(target.exact_surface);
  EXPECT_EQ(target.inside, target_of(mesh).inside);
}

TEST(Target, with_slits_of_rounding_size_is_stitched) {
  TriangleMesh soup;
  const TriangleMesh mesh = ball(Vector3d::Zero(), 1, 6);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (int c = 0; c < 3; ++c) soup.vertices.push_back(mesh.vertices[mesh.triangles[f][c]] * (1 + 1e-8 * double(f % 5)));
    soup.triangles.emplace_back(int(3 * f), int(3 * f + 1), int(3 * f + 2));
  }
  const Target target = target_of(soup);
  expect_sound(target);
  EXPECT_TRUE(target.exact_surface);
  EXPECT_EQ(target.mesh.vertices.size(), mesh.vertices.size());
}

TEST(Target, open_on_one_side_is_capped) {
  TriangleMesh mesh = box(Vector3d::Zero(), Vector3d(2, 1, 1));
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
  const Target target = target_of(mesh);
  expect_sound(target);
  EXPECT_NEAR(target.volume, 0.5 * 0.25 * 0.25, 1e-9);
  EXPECT_EQ(target.warnings.size(), 1u);
}

TEST(Target, of_two_crossing_boxes_is_their_union) {
  const TriangleMesh mesh = joined(box(Vector3d(-2, -1, -1), Vector3d(2, 1, 1)), box(Vector3d(-1, -2, -0.5), Vector3d(1, 2, 0.5)));
  const Target target = target_of(mesh, 64);
  expect_sound(target);
  EXPECT_FALSE(target.exact_surface);
  const double exact = (16 + 8 - 4) * std::pow(target.scale, 3);
  EXPECT_NEAR(target.volume, exact, 0.05 * exact);
  EXPECT_GE(target.volume, exact);
}

TEST(Target, crossed_in_one_small_place_is_mended_there) {
  TriangleMesh mesh = ball(Vector3d::Zero(), 1, 24);
  const Vector3i face = mesh.triangles[600];
  std::swap(mesh.vertices[face[0]], mesh.vertices[face[1]]);
  ASSERT_FALSE(crossing_faces(mesh).empty());
  const Target target = target_of(mesh);
  expect_sound(target);
  EXPECT_TRUE(target.exact_surface);
  EXPECT_EQ(target.warnings.size(), 1u);
  EXPECT_NEAR(target.volume / std::pow(target.scale, 3), 4 * std::numbers::pi / 3, 0.05);
}

TEST(Target, with_numbers_that_are_none_loses_only_those_faces) {
  TriangleMesh mesh = ball(Vector3d::Zero(), 1, 10);
  const double volume = target_of(mesh).volume;
  mesh.vertices[5].x() = std::numeric_limits<double>::quiet_NaN();
  mesh.vertices[40].z() = std::numeric_limits<double>::infinity();
  const Target target = target_of(mesh);
  expect_sound(target);
  EXPECT_NEAR(target.volume, volume, 0.02 * volume);
}

TEST(Target, ignores_vertices_that_no_face_uses) {
  TriangleMesh mesh = ball(Vector3d::Zero(), 1, 8);
  const Target without = target_of(mesh);
  mesh.vertices.emplace_back(1000, 0, 0);
  const Target target = target_of(mesh);
  EXPECT_EQ(target.scale, without.scale);
  EXPECT_EQ(target.inside, without.inside);
}

TEST(Target, that_is_hollow_keeps_its_cavity) {
  const TriangleMesh shell = joined(ball(Vector3d::Zero(), 1, 12), inside_out(ball(Vector3d::Zero(), 0.6, 12)));
  for (const TriangleMesh& mesh : {shell, inside_out(shell)}) {
    const Target target = target_of(mesh);
    expect_sound(target);
    EXPECT_GT(distance_at(target, Vector3d::Zero()), 0.1);
    EXPECT_NEAR(target.volume / std::pow(target.scale, 3), 4 * std::numbers::pi / 3 * (1 - 0.216), 0.1);
  }
}

TEST(Target, with_a_solid_inside_a_solid_is_solid) {
  const TriangleMesh mesh = joined(ball(Vector3d::Zero(), 1, 12), ball(Vector3d::Zero(), 0.6, 12));
  const Target target = target_of(mesh);
  expect_sound(target);
  EXPECT_LT(distance_at(target, Vector3d::Zero()), -0.2);
  EXPECT_EQ(make_manifold(target.mesh).components, 1);
}

TEST(Target, in_two_pieces_fills_the_larger_and_says_so) {
  const TriangleMesh mesh = joined(ball(Vector3d::Zero(), 1, 12), ball(Vector3d(2, 0, 0), 0.5, 12));
  const Target target = target_of(mesh);
  expect_sound(target);
  EXPECT_TRUE(target.exact_surface);
  ASSERT_EQ(target.warnings.size(), 1u);
  EXPECT_NE(target.warnings[0].find("89 %"), std::string::npos) << target.warnings[0];
  for (const std::size_t i : target.inside)
    ASSERT_LT(target.distance.shape.position(i).x() / target.scale + target.centre.x(), 1.01);
}

TEST(Target, is_the_same_at_any_size) {
  const TriangleMesh mesh = turned(joined(box(Vector3d(-2, -1, -1), Vector3d(2, 1, 1)), box(Vector3d(-1, -2, -0.5), Vector3d(1, 2, 0.5))));
  const Target target = target_of(mesh);
  for (const double size : {std::ldexp(1.0, 40), std::ldexp(1.0, -40)}) {
    const Target other = target_of(scaled(mesh, size));
    EXPECT_EQ(other.distance.values, target.distance.values);
    EXPECT_EQ(other.inside, target.inside);
    EXPECT_EQ(other.scale * size, target.scale);
  }
}

TEST(Target, is_the_same_each_time_with_any_number_of_threads) {
  const TriangleMesh mesh = turned(joined(box(Vector3d(-2, -1, -1), Vector3d(2, 1, 1)), ball(Vector3d(1, 1, 1), 1, 9)));
  const Target a = target_of(mesh);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const Target b = target_of(mesh);
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.distance.values, b.distance.values);
}

TEST(Target, distance_outside_the_grid_grows_with_the_distance) {
  const Target target = target_of(ball(Vector3d::Zero(), 1, 16));
  double before = 0;
  for (double x = 0.2; x < 5; x += 0.05) {
    const double here = distance_at(target, Vector3d(x, 0.02, 0));
    EXPECT_GT(here, before - 0.25 * (before == 0));
    EXPECT_NEAR(here, x - 0.25, 0.01);
    before = here;
  }
}

TEST(MirrorAxis, is_the_one_across_which_the_target_is_its_own_image) {
  for (int axis = 0; axis < 3; ++axis) {
    // Three balls of different size in the plane: only the axis at right angles to it mirrors them.
    Vector3d u = Vector3d::Zero(), v = Vector3d::Zero();
    u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1;
    const TriangleMesh mesh = joined(joined(ball(Vector3d::Zero(), 0.7, 10), ball(u, 0.45, 10)), ball(0.9 * v - 0.5 * u, 0.35, 10));
    EXPECT_EQ(target_of(mesh).mirror_axis, axis);
  }
}

TEST(MirrorAxis, of_a_body_with_several_is_the_first_of_the_best) {
  EXPECT_EQ(target_of(ball(Vector3d::Zero(), 1, 16)).mirror_axis, 0);
  EXPECT_EQ(target_of(turned(box(Vector3d(-4, -1, -0.5), Vector3d(4, 1, 0.5)))).mirror_axis, std::nullopt);
}

TEST(TargetErrors, say_what_is_wrong) {
  const TriangleMesh good = box(Vector3d::Zero(), Vector3d::Ones());
  EXPECT_NE(complaint({}).find("no faces"), std::string::npos);
  EXPECT_NE(complaint({good.vertices, {}}).find("no faces"), std::string::npos);
  for (const int index : {-1, 8, 1 << 30}) {
    TriangleMesh mesh = good;
    mesh.triangles[3][1] = index;
    EXPECT_NE(complaint(mesh).find("face 3"), std::string::npos);
  }
  TriangleMesh nowhere = good;
  for (Vector3d& v : nowhere.vertices) v.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(complaint(nowhere).find("not a number"), std::string::npos);
  TriangleMesh point = good;
  for (Vector3d& v : point.vertices) v.setConstant(3);
  EXPECT_NE(complaint(point).find("no usable face"), std::string::npos);
  TriangleMesh huge = scaled(good, 1e300);
  for (Vector3d& v : huge.vertices) v -= Vector3d::Constant(5e299);
  complaint(huge);
  EXPECT_NE(complaint(good, 15).find("15"), std::string::npos);
  EXPECT_NE(complaint(good, 513).find("513"), std::string::npos);
}

TEST(TargetErrors, a_sheet_has_no_volume) {
  TriangleMesh sheet;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) sheet.vertices.emplace_back(i, j, 0.5 * i);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      sheet.triangles.emplace_back(5 * i + j, 5 * i + j + 5, 5 * i + j + 6);
      sheet.triangles.emplace_back(5 * i + j, 5 * i + j + 6, 5 * i + j + 1);
    }
  EXPECT_NE(complaint(sheet).find("no volume"), std::string::npos);
  EXPECT_NE(complaint(turned(box(Vector3d::Zero(), Vector3d(1, 1, 0.001)))).find("thinner"), std::string::npos);
}

TEST(TargetErrors, a_plate_has_to_be_more_than_two_voxels_thick) {
  const auto plate = [](double voxels) { return box(Vector3d::Zero(), Vector3d(1, 1, voxels / 32)); };
  EXPECT_NE(complaint(plate(1)).find("two voxels"), std::string::npos);
  EXPECT_NE(complaint(plate(2)).find("two voxels"), std::string::npos);
  expect_sound(target_of(plate(3), 32));
}

TEST(Target, can_be_stopped_at_any_time) {
  const TriangleMesh mesh = ball(Vector3d::Zero(), 1, 8);
  int calls = 0;
  make_target(mesh.vertices, mesh.triangles, {.resolution = 32}, {[&](double, std::string_view) { return ++calls, true; }});
  EXPECT_GE(calls, 4);
  for (int stop = 1; stop <= calls; ++stop) {
    int left = stop;
    EXPECT_THROW(make_target(mesh.vertices, mesh.triangles, {.resolution = 32}, {[&](double, std::string_view) { return --left > 0; }}),
                 Cancelled);
  }
}

}  // namespace
}  // namespace transformables
