// Carving: parts that would meet along the path give way, and what is left is measured.
#pragma once

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

/// Removes from the parts what comes nearer than the lattice's gap to another part somewhere along the path. A part's
/// core gives way only to another's core. Pieces that are cut off are dropped, and so is what is left too thin.
/// @param dropped  samples dropped, added up for each part
/// @param exact    replace the field of a part that must give way by its distance first: for all passes but the first
/// @return whether anything was removed
bool carve(const Scene& scene, std::vector<PartField>& parts, std::vector<std::size_t>& dropped, bool exact, const Progress& progress);

struct Measured {
  std::vector<Collision> collisions;   ///< worst first
  double least_gap = 0;                ///< a lower bound over the whole motion, `cover` taken off
};
Measured measure(const Scene& scene, const std::vector<PartField>& parts, const Progress& progress);

}  // namespace transformables::finishing
