// Fins, blades and tips that carving leaves and that are too thin to be printed or to look well.
#pragma once

#include <cstddef>

#include "finishing/part_field.h"

namespace transformables::finishing {

/// Takes from a part what is thinner than `wall` and further than a little from anything thicker; its core stays. A part that is thin
/// all over stays as it is.
/// @return the samples that were taken
std::size_t take_thin(PartField& part, double wall);

}  // namespace transformables::finishing
