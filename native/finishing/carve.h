// Carving: parts that would meet along the path give way, and what is left is measured.
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "character/character.h"
#include "common/progress.h"
#include "embedding/embedding.h"
#include "finishing/part_field.h"
#include "folding/folding.h"
#include "segmentation/segmentation.h"

namespace transformables::finishing {

/// The design that parts move in; refers to what finish() was given.
struct Scene {
  const Character& character;
  const Embedding& embedding;
  const Segmentation& segmentation;
  const FoldPath& path;
  const FinishingOptions& options;
  const Lattice& lattice;
};

/// Where a pair of parts must stand further apart than others that pass each other.
struct Demand {
  double extra = 0;                                ///< target units
  std::vector<Eigen::Vector3d> on_a, on_b;         ///< around these places, each in object mode on its own part; none: all over
};
using Demands = std::map<std::pair<int, int>, Demand>;   ///< by bones, the lesser first

/// Removes from the parts what comes nearer to another part, somewhere along the path, than parts may that pass each other. A part's core gives way only to
/// another's core: that of the part that loses less, unless it would keep hardly any of its core and the other one keeps more. Pieces that
/// are cut off are dropped.
/// @param dropped  samples dropped, added up for each part
void carve(const Scene& scene, std::vector<PartField>& parts, std::vector<std::size_t>& dropped, const Progress& progress);

/// The same for single pairs, at places where they were found too near, and with a wider gap.
/// @return for each part whether anything was removed
std::vector<char> carve_again(const Scene& scene, const Demands& demands, std::vector<PartField>& parts, std::vector<std::size_t>& dropped,
                              const Progress& progress);

struct Measured {
  std::vector<Collision> collisions;   ///< worst first
  double least_gap = 0;                ///< a lower bound over the whole motion on samples, `cover` taken off
};
Measured measure(const Scene& scene, const std::vector<PartField>& parts, const Progress& progress);

}  // namespace transformables::finishing
