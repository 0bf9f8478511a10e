// Walking over the samples of a grid. Inner to the room.
#pragma once

#include <tbb/task_arena.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/grid.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// Level sets are kept to within so many steps of their zero; farther values say only the side.
inline constexpr float kBand = 3;
/// Least distance in steps of a sample from an interface: keeps the smallest level set unique where parts touch.
inline constexpr float kLeast = 0.01f;

/// Calls `visit` with the index of each face neighbour of a sample, in a fixed order.
template <class Visit>
inline void for_neighbours(const GridShape& shape, std::size_t index, Visit visit) {
  const auto i = std::uint32_t(index);   // divisions of 32 bits are a good deal faster; no grid is that large
  const std::uint32_t line = i / std::uint32_t(shape.size.x()), layer = line / std::uint32_t(shape.size.y());
  const Eigen::Vector3i c(int(i - line * std::uint32_t(shape.size.x())), int(line - layer * std::uint32_t(shape.size.y())), int(layer));
  const std::size_t row = shape.size.x(), slice = row * shape.size.y();
  if (c.x() > 0) visit(index - 1);
  if (c.x() + 1 < shape.size.x()) visit(index + 1);
  if (c.y() > 0) visit(index - row);
  if (c.y() + 1 < shape.size.y()) visit(index + row);
  if (c.z() > 0) visit(index - slice);
  if (c.z() + 1 < shape.size.z()) visit(index + slice);
}

/// Calls `visit` with the index and the cell of every sample, in order; far cheaper than asking for the cell of each index.
template <class Visit>
inline void for_cells(const GridShape& shape, Visit visit) {
  std::size_t index = 0;
  Eigen::Vector3i c;
  for (c.z() = 0; c.z() < shape.size.z(); ++c.z())
    for (c.y() = 0; c.y() < shape.size.y(); ++c.y())
      for (c.x() = 0; c.x() < shape.size.x(); ++c.x()) visit(index++, std::as_const(c));
}

inline std::vector<char> inside_flags(const Target& target) {
  std::vector<char> flags(target.distance.shape.count(), 0);
  for (std::size_t i : target.inside) flags[i] = 1;
  return flags;
}

inline int arena_size(int threads) { return threads > 0 ? threads : tbb::task_arena::automatic; }

}  // namespace transformables::segmentation_inner
