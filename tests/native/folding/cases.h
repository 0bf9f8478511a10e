// Designs made by hand for the folding room's tests: boxes cut by planes, hinges on their edges, so that what collides is known.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>
#include <string>
#include <vector>

#include "folding/folding.h"

namespace transformables {

using Eigen::Vector3d;
constexpr double kQuarter = std::numbers::pi / 2;

struct Made {
  Character character;
  Target target;
  Embedding embedding;
  Segmentation segmentation;
};

struct MadeBone {
  int parent = -1;
  Vector3d head = Vector3d::Zero();  // object mode
  double folded = 0;                 // angle about Y
  Segment skeleton;                  // object mode
  int mirror = -1;
};

inline double box_distance(const Vector3d& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

inline Character made_character(const std::vector<MadeBone>& bones) {
  Character c;
  for (std::size_t b = 0; b < bones.size(); ++b) {
    Bone bone;
    bone.name = "bone" + std::to_string(b);
    bone.parent = bones[b].parent;
    bone.radius = 0.012;
    bone.mirror = bones[b].mirror;
    // Parents are never turned in these designs, so heads can be given where they stand.
    if (bone.parent >= 0) {
      bone.head_in_parent = bones[b].head - bones[bone.parent].head;
      bone.hinges = {{1, -kQuarter, kQuarter}};
      bone.first_angle = c.angle_count++;
    }
    const Eigen::AngleAxisd back(-bones[b].folded, Vector3d::UnitY());
    bone.segments = {{back * (bones[b].skeleton.a - bones[b].head), back * (bones[b].skeleton.b - bones[b].head)}};
    c.bones.push_back(bone);
  }
  return c;
}

/// A box of the given half extents, cut into parts: `distances(p)[i]` is negative where part i is.
inline Made made(const std::vector<MadeBone>& bones, const Vector3d& half, const std::function<std::vector<double>(const Vector3d&)>& distances,
          double step = 0.0125) {
  Made m;
  m.character = made_character(bones);
  m.embedding.pose.root.translation() = bones[0].head;
  m.embedding.pose.angles = Eigen::VectorXd::Zero(m.character.angle_count);
  for (std::size_t b = 1; b < bones.size(); ++b) m.embedding.pose.angles[m.character.bones[b].first_angle] = bones[b].folded;
  m.embedding.morphology = Morphology::Ones(long(bones.size()));
  GridShape shape;
  shape.step = step;
  const Vector3d margin = half + Vector3d::Constant(3 * step);
  shape.size = (2 * margin / step).array().ceil().matrix().cast<int>();
  shape.origin = -0.5 * step * (shape.size.cast<double>() - Vector3d::Ones());
  m.target.distance = Grid<float>(shape, 0);
  m.segmentation.shape = shape;
  m.segmentation.owner.assign(shape.count(), -1);
  m.segmentation.phi.assign(bones.size(), Grid<float>(shape, 0));
  m.segmentation.frames = forward_kinematics(m.character, m.embedding.pose, m.embedding.morphology);
  for (std::size_t s = 0; s < shape.count(); ++s) {
    const Vector3d p = shape.position(s);
    m.target.distance[s] = float(box_distance(p, half));
    const std::vector<double> d = distances(p);
    for (std::size_t b = 0; b < bones.size(); ++b) m.segmentation.phi[b][s] = float(std::clamp(d[b], -4 * step, 4 * step));
    if (m.target.distance[s] >= 0) continue;
    m.target.inside.push_back(s);
    m.segmentation.owner[s] = std::int16_t(std::min_element(d.begin(), d.end()) - d.begin());
  }
  m.target.volume = 8 * half.prod();
  return m;
}

/// Two boxes side by side, hinged on the top edge between them; the right one opens upward for a positive angle.
inline Made two_boxes(double folded) {
  return made({{-1, {-0.15, 0, 0}, 0, {{-0.2, 0, 0}, {-0.05, 0, 0}}, -1}, {0, {0, 0, 0.1}, folded, {{0.05, 0, 0}, {0.2, 0, 0}}, -1}}, {0.25, 0.1, 0.1},
              [](const Vector3d& p) { return std::vector<double>{p.x(), -p.x()}; });
}

/// A base, a board hinged on its left edge and a lid above the board hinged on its right edge.
inline Made lidded(double lid_folded) {
  return made({{-1, {0, 0, -0.08}, 0, {{-0.15, 0, -0.08}, {0.15, 0, -0.08}}, -1},
               {0, {-0.2, 0, -0.04}, kQuarter, {{-0.15, 0, 0}, {0.15, 0, 0}}, -1},
               {0, {0.2, 0, 0.04}, lid_folded, {{-0.15, 0, 0.075}, {0.15, 0, 0.075}}, -1}},
              {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                return std::vector<double>{p.z() + 0.04, std::abs(p.z()) - 0.04, 0.04 - p.z()};
              });
}

/// A base with two doors above it, hinged left and right, that open to the sides; its own mirror image.
inline Made doors() {
  Made m = made({{-1, {0, 0, -0.05}, 0, {{-0.15, 0, -0.05}, {0.15, 0, -0.05}}, 0},
                 {0, {-0.2, 0, 0}, kQuarter, {{-0.15, 0, 0.05}, {-0.05, 0, 0.05}}, 2},
                 {0, {0.2, 0, 0}, -kQuarter, {{0.05, 0, 0.05}, {0.15, 0, 0.05}}, 1}},
                {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                  return std::vector<double>{p.z(), std::max(-p.z(), p.x()), std::max(-p.z(), -p.x())};
                });
  m.character.mirrored = true;
  m.character.mirror_angle = {1, 0};
  m.character.mirror_sign = {-1, -1};
  m.embedding.symmetric = true;
  return m;
}

/// Two doors that hold each other shut: on one half each reaches under the other, on the other half over it. Neither can open first.
inline Made interlocked() {
  return made({{-1, {0, 0, -0.05}, 0, {{-0.15, 0, -0.05}, {0.15, 0, -0.05}}, -1},
               {0, {-0.2, 0, 0}, kQuarter, {{-0.15, 0, 0.05}, {-0.1, 0, 0.05}}, -1},
               {0, {0.2, 0, 0}, -kQuarter, {{0.1, 0, 0.05}, {0.15, 0, 0.05}}, -1}},
              {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                const double edge = (p.y() < 0) == (p.z() < 0.05) ? 0.04 : -0.04;
                return std::vector<double>{p.z(), std::max(-p.z(), p.x() - edge), std::max(-p.z(), edge - p.x())};
              });
}

/// A bar between a base and a slab that is the base's, too, and in its way.
inline Made slab_in_the_way() {
  return made({{-1, {0, 0, -0.08}, 0, {{-0.15, 0, -0.08}, {0.15, 0, -0.08}}, -1}, {0, {-0.2, 0, -0.04}, kQuarter, {{-0.15, 0, 0}, {0.15, 0, 0}}, -1}},
              {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                return std::vector<double>{0.03 - std::abs(p.z() + 0.01), std::abs(p.z() + 0.01) - 0.03};
              });
}

inline FoldPath greedy(const Made& m, const FoldingOptions& options = {}) {
  return plan_greedy(m.segmentation, m.character, m.target, m.embedding, options, {});
}
inline FoldPath best(const Made& m, const FoldingOptions& options = {}) {
  return plan(m.segmentation, m.character, m.target, m.embedding, options, {});
}
inline FoldPath remeasured(const FoldPath& path, const Made& m) {
  return measured(path, m.segmentation, m.character, m.target, m.embedding, {});
}

inline Eigen::VectorXd end_of(const FoldPath& path, Eigen::VectorXd angles) {
  for (const Move& move : path.moves)
    for (const auto& turn : move.turns) {
      EXPECT_NEAR(angles[turn.angle], turn.from_rad, 1e-12);
      angles[turn.angle] = turn.to_rad;
    }
  return angles;
}

inline bool same(const FoldPath& a, const FoldPath& b) {
  if (a.moves.size() != b.moves.size() || a.overlap_volume != b.overlap_volume || a.collisions.size() != b.collisions.size()) return false;
  for (std::size_t m = 0; m < a.moves.size(); ++m) {
    if (a.moves[m].turns.size() != b.moves[m].turns.size()) return false;
    for (std::size_t t = 0; t < a.moves[m].turns.size(); ++t)
      if (a.moves[m].turns[t].angle != b.moves[m].turns[t].angle || a.moves[m].turns[t].to_rad != b.moves[m].turns[t].to_rad) return false;
  }
  for (std::size_t c = 0; c < a.collisions.size(); ++c)
    if (a.collisions[c].bone_a != b.collisions[c].bone_a || a.collisions[c].volume != b.collisions[c].volume) return false;
  return true;
}

/// Face-connected pieces of a bone's samples.
inline int pieces(const Made& m, const std::vector<std::int16_t>& owner, int bone) {
  const GridShape& g = m.segmentation.shape;
  std::vector<char> seen(owner.size(), 0);
  int count = 0;
  for (const std::size_t first : m.target.inside) {
    if (owner[first] != bone || seen[first]) continue;
    ++count;
    std::queue<std::size_t> open;
    for (open.push(first), seen[first] = 1; !open.empty(); open.pop())
      for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
          Eigen::Vector3i c = g.cell(open.front());
          c[axis] += side;
          if (g.contains(c) && owner[g.index(c)] == bone && !seen[g.index(c)]) seen[g.index(c)] = 1, open.push(g.index(c));
        }
  }
  return count;
}

}  // namespace transformables
