// The target object: any mesh that a user has, made into a closed solid with a signed distance.
//
// Target frame: the user's mesh moved so that its bounding box is centred at the origin and scaled so that its
// longest side is 0.5 (DESIGN section 2). Every other room works in this frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "common/grid.h"
#include "common/mesh.h"
#include "common/progress.h"

namespace transformables {

inline constexpr double kLongestSide = 0.5;  ///< of every target, in target units (DESIGN section 2)

struct TargetOptions {
  int resolution = 64;  ///< voxels along the longest side, 16 to 512
};

struct Target {
  TriangleMesh mesh;                   ///< repaired: closed, outward, target frame
  Grid<float> distance;                ///< signed distance, negative inside; exact within 4 voxels of the surface at least, and growing beyond
  std::vector<std::size_t> inside;     ///< indices of the samples with a negative distance, in the largest connected piece, ascending
  double volume = 0;                   ///< cubic target units, positive
  double scale = 1;                    ///< target units for one Blender unit
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the user's bounding box, Blender units: x_target = (x - centre) * scale
  bool exact_surface = true;           ///< the user's own triangles, but for small patches (holes, crossings); false: wrapped
  std::vector<std::string> warnings;   ///< what was repaired, one sentence each, with counts
  std::optional<int> mirror_axis;      ///< 0, 1, 2: the target is its own mirror image across x, y or z = 0 (the best one), target frame
};

/// Checks, repairs and measures a mesh (DESIGN section 3): drops faces with non-finite vertices and degenerate or
/// duplicate faces, ignores unused vertices, welds, orients, caps holes; small crossings are cut out and patched, others
/// wrapped (CGAL Alpha_wrap_3); then there must be some volume. The grid has 4 samples of padding around the box and
/// is symmetric about the origin.
/// @param vertices   n x 3, Blender units, any position and size
/// @param triangles  m x 3, indices into vertices
/// @throws InvalidInput on no faces, indices out of range, nothing finite left, no volume (a sheet), or a resolution
///         out of range; each says what is wrong and what to do.
/// @throws Cancelled
Target make_target(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Eigen::Vector3i>& triangles,
                   const TargetOptions& options, const Progress& progress);

/// Signed distance of the target's surface on another grid (finer, say), target frame; negative inside. Exact within
/// 4 of its steps of the surface, and of at least that size with the right sign beyond.
Grid<float> signed_distance(const Target& target, const GridShape& shape);

/// Signed distance of a closed outward mesh on a grid, as above: exact to float rounding within 4 steps, beyond that by
/// fast sweeping, within 3 % and half a step (two steps in grids of over 3 million samples). Inside is
/// where the winding number is positive, so cavities are outside. Only the part of the mesh near the grid counts.
/// @throws InvalidInput on an empty mesh or grid, or one of more than 3e8 samples.
Grid<float> signed_distance(const TriangleMesh& mesh, const GridShape& shape);

/// phi-hat of Eq. 5: trilinear inside the grid; outside it, the border's value plus the distance to the border, so
/// that there is a slope back (DESIGN section 3).
double distance_at(const Target& target, const Eigen::Vector3d& p);

}  // namespace transformables
