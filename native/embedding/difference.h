// How much two embeddings differ: by what they do to the target, not by their angles.
#pragma once

#include <cstdint>
#include <vector>

#include "character/character.h"
#include "embedding/voxels.h"
#include "target/target.h"

namespace transformables {

/// The bone of each inside voxel, in the order of `Voxels::runs` (Evaluator::read_partition).
using Partition = std::vector<std::int16_t>;

class PartitionDifference {
 public:
  /// @param voxels  those of the partitions that are to be compared
  PartitionDifference(const Character& character, const Target& target, const Voxels& voxels);

  /// Share (0 to 1) of inside voxels that belong to another bone. When character and target both have a mirror plane: the
  /// lesser of that and the same with one of the two mirrored.
  double operator()(const Partition& a, const Partition& b) const;

 private:
  std::vector<std::int16_t> mirror_bone_;   ///< empty without a mirror plane
  std::vector<std::int32_t> mirror_voxel_;  ///< place in the partition; -1: that place is outside
};

}  // namespace transformables
