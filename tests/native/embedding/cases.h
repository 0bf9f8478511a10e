// Targets and characters made by hand, for the tests of the embedding room.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "embedding/cma_es.h"
#include "embedding/embedding.h"
#include "embedding/evaluator.h"

namespace transformables {

using Eigen::Vector3d;
using Eigen::VectorXd;

inline double box_distance(const Vector3d& p, const Vector3d& low, const Vector3d& high) {
  const Vector3d q = (p - 0.5 * (low + high)).cwiseAbs() - 0.5 * (high - low);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

template <class Distance>
inline Target target_of(const Vector3d& half, int resolution, Distance distance) {
  Target target;
  GridShape& shape = target.distance.shape;
  shape.step = kLongestSide / resolution;
  shape.size = (2 * half / shape.step).array().round().matrix().cast<int>() + Eigen::Vector3i::Constant(8);
  // Samples stand half a step off the box's faces, so that none is on the surface.
  shape.origin = -0.5 * shape.step * (shape.size - Eigen::Vector3i::Ones()).cast<double>();
  target.distance.values.resize(shape.count());
  for (std::size_t i = 0; i < shape.count(); ++i) {
    target.distance[i] = float(distance(shape.position(i)));
    if (target.distance[i] < 0) target.inside.push_back(i);
  }
  target.volume = double(target.inside.size()) * std::pow(shape.step, 3);
  return target;
}

inline Target box_target(const Vector3d& half, int resolution = 64) {
  Target target = target_of(half, resolution, [&](const Vector3d& p) { return box_distance(p, -half, half); });
  target.mirror_axis = 0;
  return target;
}

inline Target ball_target() {
  return target_of(Vector3d::Constant(0.25), 40, [](const Vector3d& p) { return p.norm() - 0.25; });
}

/// Two towers on a base: the short way from tower to tower leads outside.
inline Target u_target() {
  return target_of({0.25, 0.06, 0.25}, 64, [](const Vector3d& p) {
    return std::min({box_distance(p, {-0.25, -0.06, -0.25}, {-0.03, 0.06, 0.25}), box_distance(p, {0.03, -0.06, -0.25}, {0.25, 0.06, 0.25}),
                     box_distance(p, {-0.25, -0.06, -0.25}, {0.25, 0.06, -0.15})});
  });
}

inline ArmatureBone armature_bone(const std::string& name, int parent, const Vector3d& head, const Vector3d& tail, std::vector<Hinge> hinges) {
  ArmatureBone bone;
  bone.name = name;
  bone.parent = parent;
  bone.head = head;
  bone.tail = tail;
  const Vector3d y = (tail - head).normalized();
  const Vector3d x = std::abs(y.x()) > 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  bone.axes.col(1) = y;
  bone.axes.col(0) = (x - x.dot(y) * y).normalized();
  bone.axes.col(2) = bone.axes.col(0).cross(y);
  bone.hinges = std::move(hinges);
  return bone;
}

inline Character with_radius(Character character, double radius) {
  for (Bone& bone : character.bones) bone.radius = radius;
  return character;
}

/// Bones end to end along Y, each turning about its X.
inline Character chain(int count, double length, double radius, Hinge hinge = {0, -1.5, 1.5}) {
  std::vector<ArmatureBone> bones;
  for (int i = 0; i < count; ++i)
    bones.push_back(armature_bone("b" + std::to_string(i), i - 1, {0, i * length, 0}, {0, (i + 1) * length, 0},
                                  i == 0 ? std::vector<Hinge>{} : std::vector<Hinge>{hinge}));
  return with_radius(make_character(bones), radius);
}

/// A body along Y with an arm of two bones to each side.
inline Character armed(double radius = 0.012) {
  std::vector<ArmatureBone> bones{armature_bone("body", -1, {0, 0, 0}, {0, 0.12, 0}, {})};
  bones.push_back(armature_bone("neck", 0, {0, 0.12, 0}, {0, 0.2, 0}, {{0, -1.2, 1.2}}));
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? ".L" : ".R";
    const int upper = int(bones.size());
    bones.push_back(armature_bone("upper" + end, 0, {side * 0.06, 0.1, 0}, {side * 0.16, 0.1, 0}, {{0, -1.5, 1.5}}));
    bones.push_back(armature_bone("lower" + end, upper, {side * 0.16, 0.1, 0}, {side * 0.26, 0.1, 0}, {{0, -2.0, 2.0}}));
  }
  return with_radius(make_character(bones), radius);
}

inline Pose pose_at(const Character& character, const Vector3d& head) {
  Pose pose{Eigen::Isometry3d::Identity(), VectorXd::Zero(character.angle_count)};
  pose.root.translation() = head;
  return pose;
}

inline Morphology unscaled(const Character& character) { return Morphology::Ones(Eigen::Index(character.bones.size())); }

inline Evaluator evaluator_of(const Character& character, const Target& target) {
  return Evaluator(character, target, std::make_shared<const Voxels>(target), {});
}

inline Pose random_pose(const Character& character, Random& random, double spread) {
  Pose pose = pose_at(character, Vector3d(random.uniform(-spread, spread), random.uniform(-spread, spread), random.uniform(-spread, spread)));
  pose.root.linear() = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix();
  for (double& angle : pose.angles) angle = random.uniform(-1, 1);
  return pose;
}

/// A search that takes well under a second.
inline EmbeddingOptions quick() {
  EmbeddingOptions options;
  options.runs = 1;
  options.starts = 8;
  options.evaluations = 900;
  return options;
}

}  // namespace transformables
