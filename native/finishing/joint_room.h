// What is about a joint: where on a sphere just beyond the housing a part is solid, and where another passes. Inner to the room.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <utility>
#include <vector>

#include "common/grid.h"
#include "finishing/hinge_shape.h"

namespace transformables::finishing {

/// Cells of a sphere about a joint, by polar angle from its axis and azimuth.
class SphereMap {
 public:
  static constexpr int kRows = 60, kColumns = 120;

  SphereMap() : flags_(kRows * kColumns, 0) {}
  bool at(int row, int column) const { return flags_[std::size_t(row * kColumns + column % kColumns)]; }
  void set(int row, int column, bool flag) { flags_[std::size_t(row * kColumns + column)] = flag; }

  /// The largest rectangle of flagged cells in rows [first, last], as a block without radii; nothing when all are too small to carry anything.
  /// @param radius  of the sphere, target units
  std::optional<Block> largest(int first, int last, double radius) const;

 private:
  std::vector<char> flags_;
};

/// Polar angles of a row's two edges, and a column's first azimuth.
double polar_edge(int row);
double azimuth_edge(int column);

/// Where a solid fills the layer between two radii about a joint.
/// @param frame  of the joint, Z along its axis
SphereMap solid_between(const Grid<float>& psi, const Eigen::Isometry3d& frame, double from, double to, double depth);

/// Where nothing of a solid is in that layer, or within `gap` beside a cell, while it turns about the axis by angles of a range.
SphereMap free_between(const Grid<float>& psi, const Eigen::Isometry3d& frame, double from, double to, double gap, std::pair<double, double> turned);

}  // namespace transformables::finishing
