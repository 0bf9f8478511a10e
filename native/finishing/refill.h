// What carving left empty goes to a part that can carry it.
#pragma once

#include <vector>

#include "common/progress.h"
#include "finishing/carve.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// Lets parts grow, one after the other, into what is empty beside them, as far as they come no nearer to any other part than the lattice's gap
/// anywhere along the path: carving takes all that another part passes over, and leaves more room than that part needs wherever the two do not slide
/// along each other smoothly. A part grows by a few samples at most. Bones that may not grow, or have no skin, stay as they are, and so do
/// places that the artist gave to another bone.
void refill(const Scene& scene, std::vector<PartField>& parts, const Progress& progress);

}  // namespace transformables::finishing
