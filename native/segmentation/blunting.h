// Interfaces that are nowhere sharper than the threshold of Eq. 6. Inner to the room.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// Where the interface of two parts is sharper than the threshold (1 / step), it moves by the curvature's term of Eq. 7 alone until it is not, each side giving what
/// the other takes. Skeletons' samples stay with their bones, and may stay sharp themselves. Where a third part or the target's surface is a neighbour nothing moves.
/// Both level sets change together, so every sample keeps one owner whose level set alone is negative; but a piece may be cut off.
/// It does not depend on the number of threads.
/// @param core  see Skeleton::core, of whole skeletons
/// @param outgrown  flags of the bones whose box has no margin any more: settle them
/// @return whether anything was too sharp
bool blunt(Segmentation& segmentation, const Target& target, const std::vector<std::int16_t>& core, float threshold, int threads, std::vector<char>& outgrown);

}  // namespace transformables::segmentation_inner
