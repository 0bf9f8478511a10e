// Line segments and the balls swept along them: the shape of a bone for every collision question.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>

namespace transformables {

struct Segment {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};

inline Segment transformed(const Eigen::Isometry3d& frame, const Segment& s) { return {frame * s.a, frame * s.b}; }

inline double distance(const Segment& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = s.b - s.a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - s.a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - s.a - t * d).norm();
}

/// Least distance of two segments (Ericson, Real-Time Collision Detection, section 5.1.9: the closed form).
double distance(const Segment& s, const Segment& t);

}  // namespace transformables
