// Where the flood starts from: the voxels at bones, each with its distance from the bone's axis.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "embedding/skeleton.h"
#include "embedding/voxels.h"

namespace transformables {

/// A bone's segment, as the flood sees it.
struct Seeded {
  const Skeleton::PosedSegment& segment;
  int bone = 0;
  double radius = 0;    ///< target units
  double excess = 0;    ///< target units that all its distances are larger by: thinner bones start later
};

/// Puts into `field` the voxels in a capsule, where nothing less is there. A seed's start is its distance from the axis, so that of two bones that overlap the
/// nearer wins. @return whether there were any
bool plant_capsule(const Voxels& voxels, const Seeded& seeded, std::int32_t* field);

/// The same for the voxels in a ball about a joint whose nearest point of the segment lies in it too. Where both bones' nearest point is their joint, all that parts
/// them is the bisector: seeds that reach no farther than the bones' thickness, a voxel, tell its direction but roughly.
/// @param reach  the ball's radius, target units; the ball must lie inside the target
bool plant_about_joint(const Voxels& voxels, const Seeded& seeded, const Eigen::Vector3d& joint, double reach, std::int32_t* field);

}  // namespace transformables
