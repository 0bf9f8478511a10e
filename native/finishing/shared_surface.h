// The surfaces of parts that nothing parts yet: what ends one is the beginning of another, to the last bit.
#pragma once

#include <vector>

#include "common/grid.h"
#include "common/mesh.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// The surface of a part that was made without a gap: closed, manifold, without self-intersections. Neighbours have it in common, with an edge where three of
/// them meet and a corner where four do; isosurface() of a field alone rounds those off, and has fewer triangles.
/// @param field  the part's, on the same box, as it is to be meshed, positive at the border; where it is no longer what was made, it is taken as it is
/// @param parts  all of them, each at its bone's place
TriangleMesh shared_surface(const Grid<float>& field, const PartField& part, const std::vector<PartField>& parts);

}  // namespace transformables::finishing
