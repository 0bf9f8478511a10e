// The skeleton on the lattice: which samples a bone must keep, whatever happens to its skin. Inner to the room.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "character/character.h"
#include "embedding/embedding.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

struct Skeleton {
  std::vector<Eigen::Isometry3d> frames;   ///< object mode, target frame
  std::vector<SkeletalShape> shapes;
  std::vector<std::int16_t> core;          ///< for each sample the bone whose axis runs through it, -1: none. The samples
                                           ///< of a bone are one face-connected piece, and at least one.
};

/// @throws InvalidInput when sizes do not fit; Infeasible when a bone has no room in the target
Skeleton skeleton_on_lattice(const Character& character, const Target& target, const Embedding& embedding);

/// The same for a segmentation that was edited: bones without a part have no core, and pinned samples count as their owner's core.
/// @throws as above, and InvalidInput when `pinned` or `inhibited` has another size than the samples or bones
Skeleton skeleton_of_edited(const Character& character, const Target& target, const Embedding& embedding, const Segmentation& segmentation);

/// For each sample the bone in whose skeletal shape, at 0.9 of its radius, it lies deepest, -1: none. The core, and of the shapes what hangs together with it.
std::vector<std::int16_t> whole_skeletons(const Skeleton& skeleton, const Target& target);

/// Signed distance (target units) from a point in the target frame to a bone's skeletal shape.
double distance_to_bone(const Skeleton& skeleton, int bone, const Eigen::Vector3d& p);

/// Samples that transfer must leave with their bone: the core, and the capsule within 0.9 of its radius.
bool is_protected(const Skeleton& skeleton, const GridShape& shape, int bone, std::size_t sample);

}  // namespace transformables::segmentation_inner
