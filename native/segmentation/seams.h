// Seams: where two parts meet on the target's surface (paper, section 5, "Editing skin meshes").
#pragma once

#include <Eigen/Core>
#include <vector>

#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables {

/// A contour Q_ij. It runs once round when closed, else from one end to the other (where a third part begins).
struct Seam {
  int bone_a = 0, bone_b = 0;             ///< a < b
  bool closed = false;
  std::vector<Eigen::Vector3d> points;    ///< target frame, on the surface, about the spacing apart
};

/// All contours, each traced by Eq. 12 from a seed: a step along the surface and the interface, then projection onto both. The same pair
/// of bones may have several. Contours shorter than three spacings are left out.
/// @param spacing_steps  h of Eq. 12, in steps of the grid, 0.25 to 4
/// @throws InvalidInput when the segmentation belongs to another target, or the spacing is out of range
std::vector<Seam> traced_seams(const Segmentation& segmentation, const Target& target, double spacing_steps = 1);

}  // namespace transformables
