// The place where two level sets are equal, and the target's surface: values, gradients, projections (Eq. 12). Inner to the room.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <optional>

#include "segmentation/segmentation.h"
#include "segmentation/surfaces.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

class Contour {
 public:
  Contour(const Segmentation& segmentation, const Target& target, int a, int b)
      : segmentation_(segmentation), target_(target), a_(a), b_(b), step_(segmentation.shape.step) {}

  /// Half the difference of the two level sets: near their interface a distance, negative in a's part. Target units.
  double side(const Eigen::Vector3d& p) const { return 0.5 * (level(a_, p) - level(b_, p)); }
  Eigen::Vector3d side_slope(const Eigen::Vector3d& p) const {
    return slope([this](const Eigen::Vector3d& q) { return side(q); }, p);
  }
  double outside(const Eigen::Vector3d& p) const { return distance_at(target_, p); }
  Eigen::Vector3d normal(const Eigen::Vector3d& p) const {
    return slope([this](const Eigen::Vector3d& q) { return outside(q); }, p);
  }

  /// True where a third part is nearer than these two.
  bool is_others(const Eigen::Vector3d& p) const {
    const double mine = std::max(level(a_, p), level(b_, p)) - 0.05 * step_;
    for (int k = 0; k < int(segmentation_.phi.size()); ++k)
      if (k != a_ && k != b_ && level(k, p) < mine) return true;
    return false;
  }

  /// The point of both surfaces that is reached from p by least steps (Newton for both at once, where the paper projects in turn);
  /// nothing when there is none near.
  std::optional<Eigen::Vector3d> projected(Eigen::Vector3d p) const {
    const Eigen::Vector3d start = p;
    for (int k = 0; k < 12; ++k) {
      const Eigen::Vector2d value(outside(p), side(p));
      if (value.norm() < 0.01 * step_) return p;
      Eigen::Matrix<double, 2, 3> slopes;
      slopes.row(0) = normal(p);
      slopes.row(1) = side_slope(p);
      const Eigen::Matrix2d gram = slopes * slopes.transpose();
      if (gram.determinant() < 0.02) return {};  // nearly tangent to each other, or flat
      const Eigen::Vector3d by = slopes.transpose() * gram.inverse() * value;
      p -= by * std::min(1.0, 0.7 * step_ / by.norm());
      if ((p - start).norm() > 3 * step_) return {};
    }
    return std::abs(outside(p)) + std::abs(side(p)) < 0.1 * step_ ? std::optional(p) : std::nullopt;
  }

 private:
  double level(int bone, const Eigen::Vector3d& p) const {
    return std::min(double(value_at(segmentation_.phi[std::size_t(bone)], p)), 4 * step_);
  }
  template <class F>
  Eigen::Vector3d slope(const F& f, const Eigen::Vector3d& p) const {
    Eigen::Vector3d g;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d d = 0.5 * step_ * Eigen::Vector3d::Unit(axis);
      g[axis] = (f(p + d) - f(p - d)) / step_;
    }
    return g;
  }

  const Segmentation& segmentation_;
  const Target& target_;
  int a_, b_;
  double step_;
};

}  // namespace transformables::segmentation_inner
