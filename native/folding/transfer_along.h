// transfer_along() without what comes after it, for one who transfers again and again.
#pragma once

#include <limits>
#include <vector>

#include "folding/motion.h"

namespace transformables::folding {

/// The ways to grow parts anew that are tried, one after the other.
struct TransferWays {
  std::vector<int> patience{3, 0};   ///< RegrowthOptions::patience of each: the first keeps parts most like they were, the last takes most freely
  double worth = std::numeric_limits<double>::infinity();   ///< cubic target units: when the first leaves more to carve, the others are not tried
};

/// As transfer_along(), but skeletons stay as the design has them and interfaces are not rounded. The design's own segmentation where no
/// other loses less. @throws InvalidInput, Cancelled
Segmentation transferred_along(const Design& design, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                               TransferAlongResult& result, const TransferWays& ways = {});

}  // namespace transformables::folding
