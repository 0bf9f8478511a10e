// The room `target`: dirty meshes become solids or clear errors, and distances are distances.
#include <gtest/gtest.h>

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

//TESTS

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
