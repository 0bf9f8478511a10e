// Armatures made by hand, and random poses, for the character room's tests.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "character/character.h"

namespace transformables {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) { return low + (high - low) * double(engine_()) / double(engine_.max()); }
  Vector3d point(double reach = 1) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }
  Isometry3d motion() {
    Isometry3d m = Isometry3d::Identity();
    m.translation() = point();
    m.linear() = Eigen::AngleAxisd((*this)(-3, 3), point().normalized()).toRotationMatrix();
    return m;
  }

 private:
  std::mt19937 engine_;
};

inline Hinge hinge(int axis, double low = -1, double high = 1) { return {axis, low, high}; }

/// Axes with Y from head to tail, X as near to `side` as that allows.
inline Matrix3d axes_along(const Vector3d& along, const Vector3d& side) {
  Matrix3d axes;
  axes.col(1) = along.normalized();
  axes.col(2) = side.cross(axes.col(1)).normalized();
  axes.col(0) = axes.col(1).cross(axes.col(2));
  return axes;
}

inline ArmatureBone bone(const std::string& name, int parent, const Vector3d& head, const Vector3d& tail, std::vector<Hinge> hinges = {},
                  const Vector3d& side = {1, 0.1, 0.2}) {
  return {name, parent, head, tail, axes_along(tail - head, side), std::move(hinges)};
}

/// A root at the origin, an upper and a lower arm; the arm starts away from the root's tail.
inline std::vector<ArmatureBone> arm() {
  return {bone("root", -1, {0, 0, 0}, {0, 0, 1}), bone("upper", 0, {0.5, 0, 1}, {1.5, 0, 1}, {hinge(0)}),
          bone("lower", 1, {1.5, 0, 1}, {2.5, 0.5, 1}, {hinge(0), hinge(2)})};
}

/// 'upper' leads: plate and hook (a chain of two) are fixed to it, and 'lower' hangs on the hook's end.
inline std::vector<ArmatureBone> arm_with_fixed_bones() {
  std::vector<ArmatureBone> bones{arm()[0], arm()[1]};
  bones.push_back(bone("plate", 1, {1, 0.2, 1}, {1, 1, 1}));
  bones.push_back(bone("hook", 2, {1, 1, 1.2}, {1, 1, 2}));
  bones.push_back(bone("spike", 1, {0.7, 0, 1}, {0.7, 0, 2}));
  bones.push_back(bone("lower", 3, {1, 1, 2.1}, {2, 1, 2.1}, {hinge(0)}));
  return bones;
}

/// A mirror-symmetric walker: spine in the plane, two legs of two bones (knee of two hinges), names given or not.
inline std::vector<ArmatureBone> walker(bool named = true, const Vector3d& at = {0, 0, 0}) {
  std::vector<ArmatureBone> bones{
      bone("hips", -1, {0, 0, 1}, {0, 0.2, 1.2}, {}, {1, 0, 0}),
      bone("chest", 0, {0, 0.2, 1.3}, {0, 0.1, 2}, {hinge(0, -0.5, 1), hinge(1), hinge(2)}, {1, 0, 0}),
      bone("head", 1, {0, 0.1, 2.1}, {0, 0, 2.5}, {hinge(0, -0.2, 0.9)}, {1, 0, 0})};
  for (const double s : {1.0, -1.0}) {
    const std::string side = named ? (s > 0 ? ".L" : ".R") : (s > 0 ? "a" : "b");
    const int thigh = int(bones.size());
    // The sides' frames are turned differently about the bones, so that axes map with either sign.
    bones.push_back(bone("thigh" + side, 0, {0.2 * s, 0, 1}, {0.3 * s, 0.05, 0.5}, {hinge(0, -0.7, 0.7)}, {1, 0.3 * s, 0}));
    bones.push_back(bone("shin" + side, thigh, {0.3 * s, 0.05, 0.45}, {0.25 * s, 0.1, 0},
                         {hinge(0, -0.4, 0.6), s > 0 ? hinge(2, -0.2, 0.8) : hinge(2, -0.8, 0.2)}, {1, -0.2 * s, 0.1 * s}));
  }
  for (ArmatureBone& b : bones) b.head += at, b.tail += at;
  return bones;
}

inline Pose random_pose(const Character& c, Dice& dice) {
  Pose pose = rest_pose(c, dice.motion());
  for (double& angle : pose.angles) angle = dice(-2, 2);
  return pose;
}

inline Morphology random_morphology(const Character& c, Dice& dice) {
  Morphology m(c.bones.size());
  for (double& factor : m) factor = dice(0.5, 2);
  return m;
}

inline Morphology ones(const Character& c) { return Morphology::Ones(Eigen::Index(c.bones.size())); }

}  // namespace transformables
