// What a hinge takes and gives at one joint. Inner to the room.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <utility>

#include "finishing/hinge_shape.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// What a joint's hinge takes from its child's part and gives to its parent's, target frame, object mode.
struct HingeSolids {
  Eigen::Vector3d centre;
  double radius = 0;      ///< at which the parent's body begins
  TriangleMesh taken, given;
};

/// A hinge of this size where the child's tongue, or else the parent's, has a neck to hang on and the other's ears have arms; nothing where
/// there is no room for either.
/// @param frame    of the joint, Z along its axis, object mode
/// @param range    angles through which the child turns, object mode being 0
/// @param further  how much further out than usual the parent's body begins, target units
std::optional<HingeSolids> plan_hinge(const Lattice& lattice, const PartField& child, const PartField& parent, const Eigen::Isometry3d& frame,
                                      const HingeSize& size, std::pair<double, double> range, double further);

/// A mesh after a motion.
TriangleMesh moved(TriangleMesh mesh, const Eigen::Isometry3d& by);

}  // namespace transformables::finishing
