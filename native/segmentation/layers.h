// Thin layers in which a joint's two parts still meet on their way, parted to a small fraction of a sample. Inner to the room.
#pragma once

#include <vector>

#include "segmentation/joint.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"
#include "segmentation/surfaces.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// Where a point of the child's part lies in the parent's part at one of the joint's motions, both give way: the half differences of the two level sets at the
/// two places become their mean, for which the samples about them change as little as they can (Kaczmarz' projections on the constraints of rounding.h,
/// one by one), until hardly any such point is left or rounds are used up. Points stand half a step apart. What is deeper than half a step in both
/// stays, as do pinned samples and those beside them, cores and inhibited bones. Both level sets change together, so the result is a tiling again. It does
/// not depend on the number of threads.
/// @return what still collides of each joint; empty when that is not known, as something was changed
Found part_layers(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                 int threads);

/// Flags of the samples that are pinned or within two of one that is (along each axis); empty: none. Interfaces there run as the artist wants
/// them, outside the target, too.
std::vector<char> beside_pinned(const Segmentation& segmentation);

}  // namespace transformables::segmentation_inner
