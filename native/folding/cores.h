// Samples that can't change hands: each bone's own skeleton, and what the artist pinned.
#pragma once

#include <cstdint>
#include <vector>

#include "folding/motion.h"
#include "folding/overlap.h"

namespace transformables::folding {

/// The bone whose skeletal core holds a sample, -1 for none; a core is the skeletal shape at 0.9 of its radius, and at least one
/// sample of every bone that owns any. Children's joint housings are the children's. Pinned samples count as their owner's core.
std::vector<std::int16_t> cores_of(const Design& design);

/// The skeletal shapes of the bones that have a part, at 0.9 of their radius as above: what carving takes from no bone for another's skin.
Skeletons skeletons_of(const Design& design);

/// The design's segmentation with every skeleton its own bone's, and pinned. Transfer guards no more of it than its axis from a neighbour, but finished
/// parts have all of it: what others seem to have of it would be carved from them, and what it passes through, too. What was pinned stays as it is.
Segmentation with_skeletons(const Design& design);

}  // namespace transformables::folding
