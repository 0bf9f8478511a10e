// Interfaces that slide along each other made to fit at every angle, to a fraction of a sample. Inner to the room.
#pragma once

#include <vector>

#include "segmentation/joint.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"
#include "segmentation/surfaces.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// Moves the interface of each joint's parent and child, by little more than a sample at most, so that what slides is round about the hinge.
///
/// On each circle about a hinge nothing of the parent may lie ahead of the child within the range: along the way that the child goes, half the
/// difference of their level sets must not rise. Each sample gets its value in the nearest such sequence (least largest change: isotonic regression),
/// a constant where the range runs both ways. Pinned samples and cores stay. Both level sets change together, so the result is a tiling again.
/// Each hinge of several is rounded with the others at their folded angles. The result does not depend on the number of threads.
/// @return as part_layers() (layers.h), which is the last that is done
Found round_joints(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                  int threads);

/// The same just outside the target, as far as level sets are read there between samples: what `Surfaces::settle` continues along normals is not round.
void round_outside(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                   int threads);

}  // namespace transformables::segmentation_inner
