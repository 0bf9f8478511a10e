// Small repairs that leave the user's surface where it is.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "target/soup.h"

namespace transformables {

/// Closes every hole with faces; counts the holes.
TriangleMesh cap_holes(const Manifold& open, std::size_t& holes);

/// Leaves out the pieces that enclose nothing, with a warning. @throws InvalidInput when that is all of them.
Manifold drop_sheets(const Manifold& manifold, std::vector<std::string>& warnings);

/// Cuts out the faces that cross, with a few rings about them, and closes the holes anew; nothing when the flaw is too
/// large for that, or the outcome is not clean. Counts the faces cut out.
std::optional<Manifold> mend_crossings(const Manifold& closed, const std::vector<int>& crossing, std::size_t& replaced);

/// "1 hole", "2 holes".
std::string count_of(std::size_t n, const char* one, const char* many);

}  // namespace transformables
