// What the finishing room's tests share: designs made by hand, of beams along Y whose bones turn about X.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "common/mesh.h"
#include "finishing/finishing.h"

namespace transformables {

/// A small generator of our own: what the library's distributions give is not fixed.
struct Random {
  std::uint64_t state;
  double operator()() {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return double(state >> 11) / 9007199254740992.0;
  }
};

/// A closed box, outward.
inline TriangleMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int n = 0; n < 8; ++n)
    mesh.vertices.emplace_back(n & 1 ? high.x() : low.x(), n & 2 ? high.y() : low.y(), n & 4 ? high.z() : low.z());
  for (const auto& q : {Eigen::Vector4i(0, 2, 3, 1), Eigen::Vector4i(4, 5, 7, 6), Eigen::Vector4i(0, 1, 5, 4),
                        Eigen::Vector4i(2, 6, 7, 3), Eigen::Vector4i(0, 4, 6, 2), Eigen::Vector4i(1, 3, 7, 5)}) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return mesh;
}

inline double box_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d outside = (low - p).cwiseMax(p - high);
  return outside.cwiseMax(0.0).norm() + std::min(outside.maxCoeff(), 0.0);
}

struct Design {
  Character character;
  Target target;
  Embedding embedding;
  Segmentation segmentation;
  FoldPath path;
  FinishingOptions options;

  Parts finished() const { return finish(segmentation, character, target, embedding, path, options, {}); }
  void turn(int angle, double to_rad) {
    double from = embedding.pose.angles[angle];
    for (const Move& move : path.moves)
      for (const auto& t : move.turns)
        if (t.angle == angle) from = t.to_rad;
    path.moves.push_back({{{angle, from, to_rad}}});
  }
};

/// A box of half sides `half` (the longest along Y: 0.25), cut among bones by `phi`, bones along Y from y to y.
using LevelSet = std::function<double(const Eigen::Vector3d&)>;
inline Design beam(const Eigen::Vector3d& half, const std::vector<ArmatureBone>& bones, double radius, const std::vector<LevelSet>& phi, double step = kLongestSide / 32) {
  Design d;
  d.character = make_character(bones);
  for (Bone& bone : d.character.bones) bone.radius = radius;
  d.embedding.pose = rest_pose(d.character, d.character.root_rest);
  d.embedding.morphology = Morphology::Ones(d.character.bones.size());
  d.target.mesh = box_mesh(-half, half);
  d.target.volume = signed_volume(d.target.mesh);
  const Eigen::Array3i cells = (half.array() / step).ceil().cast<int>() + 3;
  const GridShape shape{(2 * cells + 1).matrix(), -step * cells.cast<double>().matrix(), step};
  d.target.distance = Grid<float>(shape, 0);
  d.segmentation.shape = shape;
  d.segmentation.owner.assign(shape.count(), -1);
  d.segmentation.frames = forward_kinematics(d.character, d.embedding.pose, d.embedding.morphology);
  d.segmentation.phi.assign(phi.size(), Grid<float>(shape, 0));
  for (std::size_t n = 0; n < shape.count(); ++n) {
    const Eigen::Vector3d p = shape.position(n);
    d.target.distance[n] = float(box_distance(p, -half, half));
    for (std::size_t i = 0; i < phi.size(); ++i) {
      d.segmentation.phi[i][n] = float(std::clamp(phi[i](p), -4 * step, 4 * step));
      if (d.target.distance[n] < 0 && phi[i](p) <= 0) d.segmentation.owner[n] = std::int16_t(i);
    }
    if (d.target.distance[n] < 0) d.target.inside.push_back(n);
  }
  return d;
}

inline ArmatureBone bone(const char* name, int parent, double from_y, double to_y, bool hinged = true) {
  ArmatureBone b{name, parent, {0, from_y, 0}, {0, to_y, 0}, Eigen::Matrix3d::Identity(), {}};
  if (hinged && parent >= 0) b.hinges.push_back({0, -std::numbers::pi, std::numbers::pi});
  return b;
}

inline constexpr double kHalfWidth = 0.08;

/// Two halves that meet at y = 0, the hinge in the middle of the interface.
inline Design halves(double radius = 0.012) {
  return beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.15, 0), bone("child", 0, 0, 0.15)}, radius,
              {[](const Eigen::Vector3d& p) { return p.y(); }, [](const Eigen::Vector3d& p) { return -p.y(); }});
}

/// The nearest number of single precision; `volatile` because GCC 12 drops such roundings at -O2.
inline double to_float(double x) {
  const volatile float rounded = float(x);
  return double(rounded);
}

/// How often a closed mesh winds around a point that is not on it (van Oosterom and Strackee 1983).
inline double winding(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p, c = mesh.vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

/// A cube of samples about the origin.
inline Grid<float> sampled_field(int n, double step, const std::function<double(const Eigen::Vector3d&)>& f) {
  const double half = step * (n - 1) / 2;
  Grid<float> field({{n, n, n}, Eigen::Vector3d::Constant(-half), step}, 0);
  for (std::size_t i = 0; i < field.values.size(); ++i) field[i] = float(f(field.shape.position(i)));
  return field;
}

inline void expect_good(const TriangleMesh& mesh) {
  const MeshCheck c = check(mesh);
  EXPECT_FALSE(c.open);
  EXPECT_FALSE(c.non_manifold);
  EXPECT_FALSE(c.self_intersecting);
  EXPECT_FALSE(c.inside_out);
  EXPECT_EQ(c.extra_pieces, 0);
}

}  // namespace transformables
