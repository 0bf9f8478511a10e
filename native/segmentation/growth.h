// Multiple level sets that grow until they fill the target (Eqs. 6 and 7, with projection). Inner to the room.
#pragma once

#include <cstdint>
#include <vector>

#include "character/character.h"
#include "common/progress.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// What growth leaves: who claimed each sample, and half the difference between each level set and the least of the others there,
/// so that interfaces are its zero set.
struct Grown {
  std::vector<std::int16_t> owner;             ///< -1: outside, or never reached
  std::vector<Grid<float>> phi;                ///< target units; over the boxes of the blocks that each bone came near
};

Grown grown(const Character& character, const Target& target, const Skeleton& skeleton, const SegmentationOptions& options,
            const Progress& progress);

}  // namespace transformables::segmentation_inner
