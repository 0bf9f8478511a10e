// transfer_along() without what comes after it, for one who transfers again and again.
#pragma once

#include "folding/motion.h"

namespace transformables::folding {

/// As transfer_along(), but skeletons stay as the design has them and interfaces are not rounded. The design's own segmentation where no
/// other loses less. @throws InvalidInput, Cancelled
Segmentation transferred_along(const Design& design, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                               TransferAlongResult& result);

}  // namespace transformables::folding
