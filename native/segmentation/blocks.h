// Sparse storage for many level sets: blocks of 8^3 samples, each with a layer for every bone that is near. Inner to the room.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/grid.h"
#include "segmentation/growth.h"
#include "segmentation/lattice.h"
#include "segmentation/level_set.h"

namespace transformables::segmentation_inner {

inline constexpr int kSide = 8, kCells = kSide * kSide * kSide;
using Samples = Row<kCells>;   ///< a value for each sample of a block
inline constexpr float kClosed = 0.1f;   ///< a gap between two fronts, in steps, that counts as closed
inline constexpr int kHaloSide = kSide + 2, kHaloCells = kHaloSide * kHaloSide * kHaloSide;

/// One bone's level set in a block, in steps, clamped to the band.
struct Layer {
  std::int16_t bone;
  std::uint8_t faces = 0;                 ///< bit f: the front is near that face of the block
  std::array<float, kCells> phi, next;    ///< before and after the running step; the same while the block sleeps
  std::array<const Layer*, 27> around;    ///< the same bone's in the blocks about this one, and this one itself; null where it has none

  explicit Layer(std::int16_t b) : bone(b) { phi.fill(kBand), next.fill(kBand), around.fill(nullptr); }
};

struct Block {
  std::array<float, kCells> limit;        ///< the target's distance in steps: no level set goes below it
  std::array<char, kCells> inside;
  std::vector<std::unique_ptr<Layer>> layers;   ///< by bone
  std::vector<std::int16_t> bones;              ///< of each layer, once more: quick to look through
  int inside_count = 0;
  int unclaimed = 0;
  int quiet = 0;                          ///< steps since all was claimed

  Layer* layer(int bone) const {
    for (std::size_t k = 0; k < bones.size(); ++k)
      if (bones[k] == bone) return layers[k].get();
    return nullptr;
  }
};

/// All blocks of a grid.
struct Blocks {
  GridShape shape;                 ///< of the samples
  Eigen::Vector3i counts;          ///< blocks along each axis
  std::vector<Block> all;

  /// Blocks without layers.
  explicit Blocks(const Target& target);

  /// Gives a block a layer; false when it has one already.
  bool add(int block, std::int16_t bone);

  /// What has grown in them: layers become half differences, and are read into a grid a bone.
  Grown read(int bones);

  /// Index of a block's sample in the grid, or the grid's count for one beyond its border.
  std::size_t sample(int block, int k) const {
    const Eigen::Vector3i c = kSide * cell(block) + Eigen::Vector3i(k % kSide, k / kSide % kSide, k / (kSide * kSide));
    return shape.contains(c) ? shape.index(c) : shape.count();
  }

  int index(int x, int y, int z) const { return (z * counts.y() + y) * counts.x() + x; }
  Eigen::Vector3i cell(int b) const { return {b % counts.x(), (b / counts.x()) % counts.y(), b / (counts.x() * counts.y())}; }
  bool contains(const Eigen::Vector3i& c) const { return (c.array() >= 0).all() && (c.array() < counts.array()).all(); }
};

/// A layer's values with a border of one sample from the neighbouring blocks.
/// @param values  &Layer::phi or &Layer::next
void gather(const Layer& layer, std::array<float, kCells> Layer::*values, float* out);

inline int halo_index(int cell) {
  const int x = cell % kSide, y = cell / kSide % kSide, z = cell / (kSide * kSide);
  return ((z + 1) * kHaloSide + y + 1) * kHaloSide + x + 1;
}

}  // namespace transformables::segmentation_inner
