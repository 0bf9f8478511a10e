// What is new in a part that was made again.
#pragma once

#include <optional>

#include "common/mesh.h"
#include "finishing/box_tree.h"

namespace transformables::finishing {

/// The triangles of a mesh that were not there before, to the last bit; nothing when there are none.
std::optional<BoxTree> fresh_of(const TriangleMesh& now, const TriangleMesh& before);

}  // namespace transformables::finishing
