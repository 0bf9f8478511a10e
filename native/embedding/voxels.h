// The inside of a target as the flood wants it: a padded array in rows of eight, and the runs of inside voxels.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/grid.h"
#include "target/target.h"

namespace transformables {

/// A voxel of the flood: distance (in 1/kUnitsPerStep of a step) in the upper 24 bits, bone in the lower 8.
inline constexpr int kUnitsPerStep = 32;
inline constexpr int kLabelBits = 8;
inline constexpr std::int32_t kNoLabel = (1 << kLabelBits) - 1;
inline constexpr std::int32_t kUnreached = 0x7f000000 | kNoLabel;
inline constexpr int kMostBones = kNoLabel;
inline constexpr int kMostVoxels = 64;  ///< along the target's longest side: the embedding needs no finer

/// Everything about a target that no evaluation changes. May be shared by threads.
struct Voxels {
  struct Run {
    std::int32_t begin = 0, end = 0;   ///< cells [begin, end), all inside
  };
  struct Row {
    std::int32_t begin = 0, count = 0; ///< cells that hold all inside ones of the row; count is a multiple of 8
    std::int32_t first_run = 0, end_run = 0;
    std::int32_t y = 0, z = 0;
    std::int32_t phase = 0;            ///< cells from `begin` to the first one at which a boundary sample may be
  };

  /// The target's own samples.
  /// @param most  voxels along the target's longest side: of finer grids every second, third, ... sample is taken
  /// @param few   with fewer voxels inside, each one on a boundary is a sample; else one in three, from twice as many on one in five
  explicit Voxels(const Target& target, int most = kMostVoxels, std::size_t few = kAlways);
  /// A grid of its own, `step` apart (target units), that begins `shift` steps (0 to 1) from the target's first sample: what is inside is read between samples.
  Voxels(const Target& target, double step, const Eigen::Vector3d& shift, std::size_t few);
  /// Samples of the target's grid a voxel would be, along each axis.
  static int stride_of(const Target& target, int most);

  std::int32_t cell(int x, int y, int z) const { return (z + 1) * slice + (y + 1) * pitch + x + kPad; }
  /// First x >= 0 of a row at which boundary samples are taken; they go on every `spacing` voxels.
  int first_sampled(int y, int z) const { return (spacing - (2 * y + 4 * z) % spacing) % spacing; }
  Eigen::Vector3i place(const Row& row, std::int32_t c) const { return {c - cell(0, row.y, row.z), row.y, row.z}; }
  Eigen::Vector3d position(const Row& row, std::int32_t c) const { return origin + step * place(row, c).cast<double>(); }
  Eigen::Vector3d position(double x, double y, double z) const { return origin + step * Eigen::Vector3d(x, y, z); }

  static constexpr std::size_t kAlways = std::numeric_limits<std::size_t>::max();
  static constexpr int kPad = 8;       ///< cells between rows, so that neighbours may be read blindly
  Eigen::Vector3i size;                ///< of the box of inside voxels
  Eigen::Vector3d origin;              ///< of voxel (0, 0, 0), target frame
  double step = 0;
  int pitch = 0, slice = 0, cells = 0;
  int stride = 1;                      ///< target.distance samples a voxel, along each axis; means nothing for a grid of its own
  Eigen::Vector3i first_sample;        ///< sample of target.distance at voxel (0, 0, 0); likewise
  std::vector<std::int32_t> wall;      ///< 0 inside, kUnreached outside: the largest of it and a value is the value, walled
  std::vector<Row> rows;
  std::vector<Run> runs;
  std::size_t inside = 0;              ///< voxels inside
  int spacing = 1;                     ///< one voxel in so many may be a boundary sample
  double samples_weight = 1;           ///< makes a sum over sampled boundary voxels the sum at the paper's step of 0.01

 private:
  void lay_out(const std::vector<Eigen::Vector3i>& taken, std::size_t few);
};

}  // namespace transformables
