// Samples that can't change hands: each bone's own skeleton, and what the artist pinned.
#pragma once

#include <cstdint>
#include <vector>

#include "folding/motion.h"

namespace transformables::folding {

/// The bone whose skeletal core holds a sample, -1 for none; a core is the skeletal shape at 0.9 of its radius, and at least one
/// sample of every bone that owns any. Children's joint housings are the children's. Pinned samples count as their owner's core.
std::vector<std::int16_t> cores_of(const Design& design);

}  // namespace transformables::folding
