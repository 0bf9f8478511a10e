// Targets, characters and invariants that the tests of the segmentation room share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "segmentation/level_set.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"

namespace transformables::cases {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Targets -----------------------------------------------------------------------------------------------------------

inline Target target_of(const std::function<double(const Vector3d&)>& distance, const Vector3d& half, int resolution) {
  Target target;
  GridShape shape;
  shape.step = kLongestSide / resolution;
  for (int a = 0; a < 3; ++a) {
    shape.size[a] = 2 * int(std::ceil(half[a] / shape.step) + 5);
    shape.origin[a] = -0.5 * shape.step * (shape.size[a] - 1);
  }
  target.distance = Grid<float>(shape, 0);
  for (std::size_t i = 0; i < shape.count(); ++i) {
    target.distance[i] = float(distance(shape.position(i)));
    if (target.distance[i] < 0) target.inside.push_back(i);
  }
  target.volume = double(target.inside.size()) * std::pow(shape.step, 3);
  return target;
}

inline double to_box(const Vector3d& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

inline Target box_target(const Vector3d& half, int resolution) {
  return target_of([=](const Vector3d& p) { return to_box(p, half); }, half, resolution);
}
inline Target sphere_target(int resolution) {
  return target_of([](const Vector3d& p) { return p.norm() - 0.25; }, Vector3d::Constant(0.25), resolution);
}
// Two arms along z, joined at the bottom, with a gap of 0.06 between them.
inline Target u_target(int resolution) {
  const Vector3d half(0.25, 0.1, 0.25);
  return target_of([=](const Vector3d& p) { return std::max(to_box(p, half), -to_box(p - Vector3d(0, 0, 0.1), {0.03, 0.3, 0.25})); }, half, resolution);
}

// Characters --------------------------------------------------------------------------------------------------------

inline ArmatureBone bone(const std::string& name, int parent, const Vector3d& head, const Vector3d& tail, const Vector3d& hinge) {
  ArmatureBone b{name, parent, head, tail, Eigen::Matrix3d::Identity(), {}};
  b.axes.col(1) = (tail - head).normalized();
  b.axes.col(0) = (hinge - hinge.dot(b.axes.col(1)) * b.axes.col(1)).normalized();
  b.axes.col(2) = b.axes.col(0).cross(b.axes.col(1));
  if (parent >= 0) b.hinges.push_back({0, -M_PI, M_PI});
  return b;
}

struct Posed {
  Character character;
  Embedding embedding;
};

// A character standing in the target just as its bones are given.
inline Posed as_given(const std::vector<ArmatureBone>& bones, const Target& target) {
  Posed posed;
  posed.character = fitted(make_character(bones), target.volume, kLongestSide, 0.87 * target.distance.shape.step, 1);
  posed.embedding.morphology = Morphology::Ones(Eigen::Index(posed.character.bones.size()));
  posed.embedding.pose = rest_pose(posed.character, posed.character.root_rest);
  return posed;
}

// A random chain with a branch, folded at random within the target's middle.
inline Posed random_pose(const Target& target, unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) { return a + (b - a) * (random() / 4294967296.0); };
  std::vector<ArmatureBone> bones{bone("root", -1, {0, -0.05, -0.17}, {0, 0.05, -0.17}, Vector3d::UnitX())};
  for (int k = 1; k < 7; ++k) {
    const int parent = int(random() % k);
    const Vector3d head = bones[parent].tail;
    Vector3d tail;
    do {
      tail = head + Vector3d(between(-0.12, 0.12), between(-0.12, 0.12), between(-0.12, 0.12));
    } while (sample(target.distance, tail) > -0.02 || (tail - head).norm() < 0.03);
    bones.push_back(bone("b" + std::to_string(k), parent, head, tail, Vector3d(between(-1, 1), between(-1, 1), between(-1, 1))));
  }
  return as_given(bones, target);
}

// Two half boxes, joined by a hinge along y at x = 0 and the given height.
inline Posed half_boxes(const Target& target, double height) {
  return as_given({bone("left", -1, {-0.2, 0, height}, {0, 0, height}, Vector3d::UnitY()),
                   bone("right", 0, {0, 0, height}, {0.2, 0, height}, Vector3d::UnitY())}, target);
}

inline Segmentation cut_in_halves(const Posed& posed, const Target& target) {
  Segmentation s{target.distance.shape, std::vector<std::int16_t>(target.distance.shape.count(), -1), {},
                 forward_kinematics(posed.character, posed.embedding.pose, posed.embedding.morphology)};
  for (std::size_t i : target.inside) s.owner[i] = s.shape.position(i).x() > 0;
  for (double side : {1.0, -1.0}) {
    Grid<float> phi(s.shape, 0);
    for (std::size_t i = 0; i < s.shape.count(); ++i)
      phi[i] = float(std::clamp(side * s.shape.position(i).x(), -3 * s.shape.step, 3 * s.shape.step));
    s.phi.push_back(phi);
  }
  return s;
}

inline Segmentation grown(const Posed& posed, const Target& target, int threads = 0) {
  SegmentationOptions options;
  options.threads = threads;
  return grow(posed.character, target, posed.embedding, options, {});
}

// Invariants --------------------------------------------------------------------------------------------------------

inline float value(const Grid<float>& phi, const GridShape& shape, std::size_t i) {
  if (phi.values.empty()) return 1e9f;
  const Vector3i c = shape.cell(i) - shape.nearest(phi.shape.origin);
  return phi.shape.contains(c) ? phi.at(c) : 1e9f;
}

inline int pieces_of(const Segmentation& s, const Target& target, int bone) {
  std::vector<char> seen(s.owner.size(), 0);
  int pieces = 0;
  for (std::size_t start : target.inside) {
    if (s.owner[start] != bone || seen[start]) continue;
    ++pieces;
    std::vector<std::size_t> open{start};
    seen[start] = 1;
    while (!open.empty()) {
      const Vector3i c = s.shape.cell(open.back());
      open.pop_back();
      for (int f = 0; f < 6; ++f) {
        Vector3i n = c;
        n[f / 2] += f % 2 ? 1 : -1;
        if (!s.shape.contains(n)) continue;
        const std::size_t k = s.shape.index(n);
        if (s.owner[k] == bone && !seen[k]) seen[k] = 1, open.push_back(k);
      }
    }
  }
  return pieces;
}

inline void expect_margins(const Segmentation& s, const Target& target) {
  for (std::size_t i : target.inside) {
    const GridShape& box = s.phi[s.owner[i]].shape;
    const Vector3i first = s.shape.nearest(box.origin), c = s.shape.cell(i);
    for (int a = 0; a < 3; ++a) {
      ASSERT_GE(c[a] - first[a], std::min(3, c[a]));
      ASSERT_GE(first[a] + box.size[a] - 1 - c[a], std::min(3, s.shape.size[a] - 1 - c[a]));
    }
  }
}

// `absent`: bones that must have no part.
inline void expect_tiling(const Segmentation& s, const Posed& posed, const Target& target, const std::set<int>& absent = {}) {
  const int bones = int(posed.character.bones.size());
  std::vector<std::size_t> count(bones, 0);
  std::vector<char> inside(s.owner.size(), 0);
  for (std::size_t i : target.inside) inside[i] = 1;
  for (std::size_t i = 0; i < s.owner.size(); ++i) {
    ASSERT_EQ(s.owner[i] >= 0, inside[i] != 0);
    if (!inside[i]) continue;
    ASSERT_LT(s.owner[i], bones);
    ++count[s.owner[i]];
    for (int b = 0; b < bones; ++b)
      if (b != s.owner[i]) {
        ASSERT_LT(value(s.phi[s.owner[i]], s.shape, i), value(s.phi[b], s.shape, i));
      }
    ASSERT_LT(value(s.phi[s.owner[i]], s.shape, i), 0);
  }
  for (int b = 0; b < bones; ++b) {
    if (absent.count(b)) {
      EXPECT_EQ(count[b], 0u) << "bone " << b;
      EXPECT_TRUE(s.phi[b].values.empty());
      continue;
    }
    EXPECT_GT(count[b], 0u) << "bone " << b << " has no part";
    EXPECT_EQ(pieces_of(s, target, b), 1) << "bone " << b;
    for (float v : s.phi[b].values) ASSERT_LE(std::abs(v), 4 * s.shape.step);
  }
  expect_margins(s, target);
  const auto skeleton = segmentation_inner::skeleton_on_lattice(posed.character, target, posed.embedding);
  for (std::size_t i : target.inside)
    if (skeleton.core[i] >= 0 && !absent.count(skeleton.core[i])) {
      ASSERT_EQ(s.owner[i], skeleton.core[i]);
    }
}

// Curvature (div n, 1 / step) of interfaces where only two parts are near and the target's surface is far, sorted. An interface is where two level sets are
// equal, so it is that of half their difference.
// @param left_out  a bone for each sample that is left out, -1: none; may be empty
inline std::vector<float> interface_curvatures(const Segmentation& s, const Target& target, const std::vector<std::int16_t>& left_out = {}) {
  std::vector<float> found;
  for (std::size_t i : target.inside) {
    if (target.distance[i] > -3 * s.shape.step || (!left_out.empty() && left_out[i] >= 0)) continue;
    const Vector3i c = s.shape.cell(i);
    bool beside = false;
    for (int f = 0; f < 6; ++f) beside |= s.owner[s.shape.index(c + (f % 2 ? 1 : -1) * Vector3i::Unit(f / 2))] != s.owner[i];
    if (!beside) continue;
    std::set<int> near;
    for (int k = 0; k < 125; ++k) near.insert(s.owner[s.shape.index(c + Vector3i(k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2))]);
    if (near.size() != 2) continue;
    const int other = *near.begin() == s.owner[i] ? *near.rbegin() : *near.begin();
    float around[27];
    for (int k = 0; k < 27; ++k) {
      const std::size_t n = s.shape.index(c + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      around[k] = 0.5f * (value(s.phi[s.owner[i]], s.shape, n) - value(s.phi[other], s.shape, n)) / float(s.shape.step);
    }
    found.push_back(std::abs(segmentation_inner::curvature<1>({around + 13, 3, 9})[0]));
  }
  std::sort(found.begin(), found.end());
  return found;
}

inline std::vector<Target> some_targets() { return {sphere_target(32), box_target({0.25, 0.2, 0.25}, 32), u_target(40)}; }

}  // namespace transformables::cases
