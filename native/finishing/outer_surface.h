// From fields to meshes: outside, the target's own triangles; at interfaces, the fields' surfaces.
#pragma once

#include <string>
#include <vector>

#include "finishing/carve.h"
#include "finishing/finishing.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// The part's solid without the target's bound: it agrees with the part inside the target, and goes on smoothly for a
/// few samples outside, so that its surface crosses the target's where the interfaces do.
/// @param unbounded  the part before carving, made as if the target were everywhere
Grid<float> cutter_field(const PartField& unbounded, const PartField& part, const Lattice& lattice);

/// Parts with something inside, in order, each a closed simple solid in one piece in its bone's frame. Where an exact surface is
/// wanted but can't be had, the part's level set is meshed instead, and a warning says so.
std::vector<Part> mesh_parts(const std::vector<PartField>& fields, const Scene& scene, const Target& target,
                             std::vector<std::string>& warnings);

}  // namespace transformables::finishing
