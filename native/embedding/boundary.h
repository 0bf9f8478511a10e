// The voxels that lie on the boundary of parts, and where parts meet their parents'.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "character/character.h"
#include "embedding/voxels.h"

namespace transformables {

/// One object a thread.
class Boundary {
 public:
  /// A voxel on the boundary, and the row that it is in.
  struct Sample {
    std::int32_t cell = 0, row = 0;
  };
  /// A voxel of a child's part of which some face neighbours are its parent's: bit f of `faces` for the side f of -x, x, -y, y, -z, z.
  struct Interface {
    std::int32_t cell = 0, row = 0;
    std::int16_t faces = 0;
    bool sampled = false;                ///< one in `Voxels::spacing`
  };

  Boundary(const Character& character, const Voxels& voxels);

  /// @param field  labels in the lower bits, kNoLabel outside (a flooded field; `Voxels::wall` is one of a single part)
  void find(const Voxels& voxels, const std::int32_t* field);

  // What was found, in the order of the grid. The arrays are as large as they could ever have to be.
  const Sample* samples() const { return samples_.get(); }         ///< one in `Voxels::spacing`, with a face neighbour of another label or outside
  const Interface* interfaces() const { return interfaces_.get(); }
  std::size_t sample_count() const { return sample_count_; }
  std::size_t interface_count() const { return interface_count_; }
  /// Of a cell, as it was read.
  int label(std::int32_t cell) const { return labels_[std::size_t(cell)]; }

 private:
  std::vector<std::uint8_t> parents_;    ///< of each label, kNoLabel where there is none; a multiple of 32
  std::vector<std::uint32_t> lattice_;   ///< the sampled ones of 32 cells, by which is the first
  std::vector<std::uint8_t> labels_;     ///< of each cell
  std::unique_ptr<Sample[]> samples_;    // not a vector: most of it is never touched
  std::unique_ptr<Interface[]> interfaces_;
  std::size_t sample_count_ = 0, interface_count_ = 0;
};

}  // namespace transformables
