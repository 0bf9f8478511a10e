// What must hold of an armature before a character is made of it. Not a door: for this room only.
#pragma once

#include <vector>

#include "character/character.h"

namespace transformables {

/// Armature bones by index, so that parents come before children, each subtree in one run.
struct BoneTree {
  std::vector<int> order;                  ///< the root first
  std::vector<std::vector<int>> children;  ///< of each bone, in the armature's order
  double size = 0;                         ///< diagonal of the box around all heads and tails
};

/// @throws InvalidInput, see make_character
BoneTree checked_tree(const std::vector<ArmatureBone>& bones);

}  // namespace transformables
