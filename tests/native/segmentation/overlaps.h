// What a child's part and its parent's share while their joint turns, measured finer than the grid.
#pragma once

#include <algorithm>

#include "segmentation/joint.h"
#include "segmentation/segmentation.h"
#include "segmentation/surfaces.h"

namespace transformables::cases {

/// Mean shares of the target's volume.
struct Overlap {
  double whole = 0, deep = 0;   ///< deep: where both parts are deeper than half a voxel
};

/// How deep a point is inside a part: part i is where phi[i] < phi[j] for all j and the target's distance is negative.
inline double depth_in(const Segmentation& s, const Target& target, int bone, const Eigen::Vector3d& p) {
  const double own = segmentation_inner::value_at(s.phi[bone], p);
  if (own > 4 * s.shape.step) return -own;
  double other = 4 * s.shape.step;
  for (int b = 0; b < int(s.phi.size()); ++b)
    if (b != bone) other = std::min(other, double(segmentation_inner::value_at(s.phi[b], p)));
  return std::min(0.5 * (other - own), -double(segmentation_inner::value_at(target.distance, p)));
}

/// Over all motions of the joint; each sample of the child's part stands for eight points about it.
/// @param from_axis  what is nearer to the hinge's axis does not count
inline Overlap overlap_on_the_way(const Segmentation& s, const Target& target, const segmentation_inner::Joint& joint, double from_axis = 0) {
  long whole = 0, deep = 0;
  const double quarter = 0.25 * s.shape.step;
  for (std::size_t i : target.inside) {
    if (segmentation_inner::value_at(s.phi[joint.child], s.shape.position(i)) > 2 * s.shape.step) continue;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d p = s.shape.position(i) + quarter * Eigen::Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      const double in_child = depth_in(s, target, joint.child, p);
      if (in_child <= 0 || joint.radius_of(p) < from_axis) continue;
      for (const Eigen::Isometry3d& motion : joint.motions) {
        const Eigen::Vector3d q = motion * p;
        if (segmentation_inner::value_at(s.phi[joint.parent], q) > s.shape.step) continue;
        const double in_parent = depth_in(s, target, joint.parent, q);
        whole += in_parent > 0;
        deep += std::min(in_parent, in_child) > 0.5 * s.shape.step;
      }
    }
  }
  const double all = 8 * double(target.inside.size()) * double(joint.motions.size());
  return {double(whole) / all, double(deep) / all};
}

}  // namespace transformables::cases
