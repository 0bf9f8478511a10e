// Which bone is whose mirror image. Not a door: for this room only.
#pragma once

#include <string>

#include "character/character.h"

namespace transformables {

/// Sets each bone's `mirror`, `mirrored`, `mirror_angle` and `mirror_sign`, for the plane X = character.mirror_x.
/// @param size  of the character, the measure for tolerances
void find_mirror(Character& character, double size);

/// The name with its side changed (`.L/.R`, `_l/_r`, `left/right`, `Left/Right`, as a word of its own or, for the long
/// ones, as a word's beginning or end); the same name when it tells no side.
std::string name_of_other_side(const std::string& name);

}  // namespace transformables
