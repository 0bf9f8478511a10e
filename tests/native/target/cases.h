// Shapes made by hand for the target room's tests, and what every target promises.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "target/crossings.h"
#include "target/nesting.h"
#include "target/soup.h"
#include "target/target.h"

namespace transformables {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// A box with corners at low and high, outward.
inline TriangleMesh box(const Vector3d& low, const Vector3d& high) {
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
inline TriangleMesh ball(const Vector3d& centre, double radius, int n) {
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

inline TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int shift = int(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Vector3i& t : b.triangles) a.triangles.push_back(t + Vector3i::Constant(shift));
  return a;
}

inline TriangleMesh inside_out(TriangleMesh mesh) {
  for (Vector3i& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

inline TriangleMesh scaled(TriangleMesh mesh, double s) {
  for (Vector3d& v : mesh.vertices) v *= s;
  return mesh;
}

/// Turned by an odd angle about an odd axis, so that nothing lines up with the grid.
inline TriangleMesh turned(TriangleMesh mesh) {
  const Eigen::Matrix3d r = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (Vector3d& v : mesh.vertices) v = r * v;
  return mesh;
}

inline Target target_of(const TriangleMesh& mesh, int resolution = 32) {
  return make_target(mesh.vertices, mesh.triangles, {.resolution = resolution}, {});
}

/// The message of the InvalidInput that making a target of the mesh ends in; a failure when it does not.
inline std::string complaint(const TriangleMesh& mesh, int resolution = 32) {
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
inline void expect_sound(const Target& target) {
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
inline void expect_signs(const Target& target, int checks) {
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

inline double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
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

inline double distance_to_mesh(const TriangleMesh& mesh, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3i& t : mesh.triangles)
    least = std::min(least, distance_to_triangle(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  return least;
}

}  // namespace transformables
