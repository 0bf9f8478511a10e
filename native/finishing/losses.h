// What finished parts have lost, and what to do about it, in words.
#pragma once

#include <string>
#include <vector>

#include "finishing/carve.h"
#include "finishing/part.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// Pieces that were dropped, bones without a part, and parts of which only a speck is left; one sentence each.
/// @param dropped  samples of pieces that carving cut off, by bone
/// @param parts    the finished ones
std::vector<std::string> losses(const Scene& scene, const std::vector<PartField>& fields, const std::vector<std::size_t>& dropped,
                                const std::vector<Part>& parts, double target_volume);

}  // namespace transformables::finishing
