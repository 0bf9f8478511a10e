// Owners of samples made a tiling: every inside sample one bone, every bone one face-connected piece. Inner to the room.
#pragma once

#include <cstdint>
#include <vector>

#include "target/target.h"

namespace transformables::segmentation_inner {

/// Repairs `owner` in place. Bones that own nothing stay without a part; every other owns its core afterwards, and only the piece
/// that holds it. Cut-off pieces go to the neighbour that they share most faces with, unowned samples to the bone that is
/// nearest by a way inside the target.
/// @param core      see Skeleton::core
/// @param growing   a flag for each bone: it may be given what others leave; empty: all may. Others get only what no growing bone can reach
/// @throws InvalidInput when an owner is no bone, or nothing is owned, or the inside is not one face-connected piece
void make_tiling(const Target& target, const std::vector<std::int16_t>& core, int bones, std::vector<std::int16_t>& owner,
                 const std::vector<char>& growing = {});

}  // namespace transformables::segmentation_inner
