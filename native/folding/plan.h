// plan() and plan_greedy() without the measurement of what is left colliding, for one who plans again and again.
#pragma once

#include "folding/motion.h"

namespace transformables::folding {

/// As plan(), but FoldPath::collisions and overlap_volume are not filled in. @throws InvalidInput, Cancelled
FoldPath unmeasured_plan(const Design& design, const FoldingOptions& options, const Progress& progress, const FoldPath* start);
/// As plan_greedy(), the same. @throws InvalidInput, Cancelled
FoldPath unmeasured_greedy(const Design& design, const FoldingOptions& options, const Progress& progress);

}  // namespace transformables::folding
