// Mesh transfer with the direction chosen joint by joint.
#pragma once

#include <map>
#include <vector>

#include "segmentation/segmentation.h"

namespace transformables {

/// As `transfer`, but for the joints of `direction_of` (by their child) material goes the way that is said there; `options.direction` is for the others.
/// @throws as `transfer`, and InvalidInput when a direction names a bone that does not exist or has no parent
Segmentation transfer_directed(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                               const std::vector<JointRange>& ranges, const TransferOptions& options, const std::map<int, TransferDirection>& direction_of,
                               const Progress& progress, std::vector<TransferResult>* results = nullptr);

}  // namespace transformables
