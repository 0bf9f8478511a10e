// Moving a seam over the target's surface (Eqs. 13 to 16). Inner to the room.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "segmentation/segmentation.h"
#include "segmentation/surfaces.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// A seam of two bones, and where its points are to be: both target frame, on the surface, as many. Points that stay are given, too: they
/// hold the rest of the seam.
struct SeamMove {
  int a = 0, b = 0;
  std::vector<Eigen::Vector3d> from, to;
};

/// Moves the interface of two parts with its seam, within both parts only, and settles their level sets so that they are equal at `to`.
/// `core` samples keep their owners. Says in words why it was left out; empty: it was done.
std::string move_seam(Segmentation& segmentation, const Target& target, const Surfaces& surfaces, const std::vector<std::int16_t>& core,
                      const SeamMove& move, int threads);

/// Samples of the two parts beside the points of a seam that were moved: what holds it there.
std::vector<std::size_t> beside_seam(const Segmentation& segmentation, const SeamMove& move);

}  // namespace transformables::segmentation_inner
