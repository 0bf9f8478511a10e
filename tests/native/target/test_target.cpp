// The room `target`: dirty meshes become solids or clear errors, and distances are distances.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>

#include "target/crossings.h"
#include "target/nesting.h"
#include "target/soup.h"
#include "target/target.h"
#include "target/voxels.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// ---- shapes -----------------------------------------------------------------------------------------------------

/// A box with corners at low and high, outward.
TriangleMesh box(const Vector3d& low, const Vector3d& high) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.vertices.emplace_back(c & 1 ? high.x() : low.x(), c & 2 ? high.y() : low.y(), c & 4 ? high.z() : low.z());
  const int quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& q : quads) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return mesh;
}

/// A ball: a box's faces cut into n x n squares, blown up to a sphere.
TriangleMesh ball(const Vector3d& centre, double radius, int n) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const auto vertex = [&](const Vector3i& c) {
    const auto [place, fresh] = known.try_emplace({c[0], c[1], c[2]}, int(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(centre + radius * (2.0 * c.cast<double>() - Vector3d::Constant(n)).normalized());
    return place->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int di, int dj) {
            Vector3i c;
            c[axis] = side * n, c[(axis + 1) % 3] = i + di, c[(axis + 2) % 3] = j + dj;
            return vertex(c);
          };
          int q[4] = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (side == 0) std::swap(q[1], q[3]);
          mesh.triangles.emplace_back(q[0], q[1], q[2]);
          mesh.triangles.emplace_back(q[0], q[2], q[3]);
        }
  return mesh;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int shift = int(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Vector3i& t : b.triangles) a.triangles.push_back(t + Vector3i::Constant(shift));
  return a;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  for (Vector3i& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double s) {
  for (Vector3d& v : mesh.vertices) v *= s;
  return mesh;
}

/// Turned by an odd angle about an odd axis, so that nothing lines up with the grid.
TriangleMesh turned(TriangleMesh mesh) {
  const Eigen::Matrix3d r = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (Vector3d& v : mesh.vertices) v = r * v;
  return mesh;
}

Target target_of(const TriangleMesh& mesh, int resolution = 32) {
  return make_target(mesh.vertices, mesh.triangles, {.resolution = resolution}, {});
}

/// The message of the InvalidInput that making a target of the mesh ends in; a failure when it does not.
std::string complaint(const TriangleMesh& mesh, int resolution = 32) {
  try {
    target_of(mesh, resolution);
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

/// What every target promises, whatever it was made from.
void expect_sound(const Target& target) {
  const Manifold m = make_manifold(target.mesh);
  EXPECT_TRUE(m.closed());
  EXPECT_EQ(m.split_vertices, 0u) << "not manifold";
  EXPECT_EQ(m.turned_faces, 0u) << "not consistently turned";
  EXPECT_TRUE(crossing_faces(target.mesh).empty());
  EXPECT_GT(target.volume, 0);
  EXPECT_NEAR(target.volume, signed_volume(target.mesh), 1e-12);
  ASSERT_FALSE(target.inside.empty());
  EXPECT_TRUE(std::is_sorted(target.inside.begin(), target.inside.end()));
  for (const std::size_t i : target.inside) ASSERT_LT(target.distance[i], 0);
  EXPECT_NEAR(bounds(target.mesh).sizes().maxCoeff(), kLongestSide, 0.01);
  const GridShape& s = target.distance.shape;
  for (std::size_t i = 0; i < s.count(); ++i) {
    const Vector3i c = s.cell(i);
    if ((c.array() < 3).any() || (c.array() >= s.size.array() - 3).any()) { ASSERT_GT(target.distance[i], 0); }
  }
}

/// Compares the sign of the distance with the winding number at some samples; close to the surface either is right.
void expect_signs(const Target& target, int checks) {
  const GridShape& s = target.distance.shape;
  std::uint64_t state = 12345;
  int wrong = 0;
  for (int n = 0; n < checks; ++n) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    const std::size_t i = std::size_t(state >> 33) % s.count();
    if (std::abs(target.distance[i]) < 1e-6f) continue;
    wrong += (winding_number(target.mesh, s.position(i)) > 0.5) != (target.distance[i] < 0);
  }
  EXPECT_EQ(wrong, 0);
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a).normalized();
  const Vector3d on = p - n * n.dot(p - a);
  const auto beside = [&](const Vector3d& u, const Vector3d& v) { return n.dot((v - u).cross(on - u)) < 0; };
  const auto to_edge = [&](const Vector3d& u, const Vector3d& v) {
    const double t = std::clamp((p - u).dot(v - u) / (v - u).squaredNorm(), 0.0, 1.0);
    return (p - u - t * (v - u)).norm();
  };
  if (!beside(a, b) && !beside(b, c) && !beside(c, a)) return std::abs(n.dot(p - a));
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

double distance_to_mesh(const TriangleMesh& mesh, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3i& t : mesh.triangles)
    least = std::min(least, distance_to_triangle(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  return least;
}

// ---- files of the shared data set -------------------------------------------------------------------------------

TriangleMesh read_obj(std::istream& in) {
  TriangleMesh mesh;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind, word;
    words >> kind;
    if (kind == "v") {
      double p[3];
      for (double& x : p) words >> word, x = std::strtod(word.c_str(), nullptr);
      mesh.vertices.emplace_back(p[0], p[1], p[2]);
    } else if (kind == "f") {
      std::vector<int> corners;
      while (words >> word) corners.push_back(std::atoi(word.c_str()) - 1);
      for (std::size_t c = 2; c < corners.size(); ++c) mesh.triangles.emplace_back(corners[0], corners[c - 1], corners[c]);
    }
  }
  return mesh;
}

TriangleMesh read_off(std::istream& in) {
  TriangleMesh mesh;
  std::string word;
  std::size_t vertices = 0, faces = 0, edges = 0;
  in >> word >> vertices >> faces >> edges;
  for (std::size_t v = 0; v < vertices; ++v) {
    Vector3d p;
    in >> p[0] >> p[1] >> p[2];
    mesh.vertices.push_back(p);
  }
  for (std::size_t f = 0; f < faces; ++f) {
    int n = 0;
    in >> n;
    std::vector<int> c(std::size_t(n), 0);
    for (int& i : c) in >> i;
    for (int i = 2; i < n; ++i) mesh.triangles.emplace_back(c[0], c[std::size_t(i) - 1], c[std::size_t(i)]);
  }
  return mesh;
}

/// Binary PLY as the data set has it: float x, y, z alone, then lists of a byte and 32-bit indices.
TriangleMesh read_ply(std::istream& in) {
  TriangleMesh mesh;
  std::size_t vertices = 0, faces = 0;
  for (std::string line; std::getline(in, line) && line != "end_header";) {
    std::istringstream words(line);
    std::string a, b;
    words >> a >> b;
    if (b == "vertex") words >> vertices;
    if (b == "face") words >> faces;
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    float p[3];
    in.read(reinterpret_cast<char*>(p), sizeof p);
    mesh.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (std::size_t f = 0; f < faces; ++f) {
    const int n = in.get();
    std::vector<std::int32_t> c(std::size_t(n), 0);
    in.read(reinterpret_cast<char*>(c.data()), std::streamsize(c.size() * 4));
    for (int i = 2; i < n; ++i) mesh.triangles.emplace_back(c[0], c[std::size_t(i) - 1], c[std::size_t(i)]);
  }
  return mesh;
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  if (path.extension() == ".obj") return read_obj(in);
  return path.extension() == ".off" ? read_off(in) : read_ply(in);
}

/// The mesh files of a folder of the shared data set, sorted; none, loudly, when the variable is not set.
std::vector<std::filesystem::path> shared_files(const std::string& folder) {
  const char* shared = std::getenv("TRANSFORMABLES_SHARED");
  std::vector<std::filesystem::path> files;
  if (!shared) {
    std::cout << "*** SKIPPED: TRANSFORMABLES_SHARED is not set, so no file of data/" << folder << " was tried ***\n";
    return files;
  }
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(shared) / "data" / folder))
    if (entry.path().extension() != ".py") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void print_row(const std::string& name, const Target& t, double seconds) {
  std::cout << name << ": " << seconds << " s, " << t.mesh.triangles.size() << " faces, volume " << t.volume
            << ", inside " << t.inside.size() << (t.exact_surface ? ", exact" : ", wrapped") << ", mirror "
            << (t.mirror_axis ? *t.mirror_axis : -1) << "\n";
  for (const std::string& w : t.warnings) std::cout << "    " << w << "\n";
}

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

// ---- real files -------------------------------------------------------------------------------------------------

TEST(SharedFiles, clean_targets_keep_their_own_surface) {
  const auto files = shared_files("targets");
  if (files.empty()) GTEST_SKIP() << "TRANSFORMABLES_SHARED is not set";
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    const TriangleMesh mesh = read_mesh(file);
    Target target;
    const double seconds = seconds_of([&] { target = target_of(mesh, 64); });
    print_row(file.filename().string(), target, seconds);
    expect_sound(target);
    expect_signs(target, 300);
    EXPECT_TRUE(target.exact_surface);
    EXPECT_NEAR(target.volume / std::pow(target.scale, 3) / signed_volume(mesh), 1, 0.01);
    EXPECT_LT(seconds, 5);
  }
}

TEST(SharedFiles, dirty_meshes_become_sound_targets_or_clear_errors) {
  const auto files = shared_files("dirty");
  if (files.empty()) GTEST_SKIP() << "TRANSFORMABLES_SHARED is not set";
  const std::vector<std::string> hopeless = {"empty.obj", "fan3_nonmanifold.obj", "flat_sheet.ply"};
  for (const auto& file : files) {
    const std::string name = file.filename().string();
    SCOPED_TRACE(name);
    const TriangleMesh mesh = read_mesh(file);
    if (std::find(hopeless.begin(), hopeless.end(), name) != hopeless.end()) {
      std::cout << name << ": " << complaint(mesh, 64) << "\n";
      continue;
    }
    Target target;
    const double seconds = seconds_of([&] { target = target_of(mesh, 64); });
    print_row(name, target, seconds);
    expect_sound(target);
    expect_signs(target, 300);
    EXPECT_LT(seconds, 20);
  }
}

}  // namespace
}  // namespace transformables
