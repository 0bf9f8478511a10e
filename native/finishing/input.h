// What finish() asks of its input.
#pragma once

#include "finishing/finishing.h"

namespace transformables::finishing {

/// @throws InvalidInput, each, with what is wrong and what to do
void check_options(const FinishingOptions& options);
void check_design(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding);
void check_path(const FoldPath& path, const Embedding& embedding);

}  // namespace transformables::finishing
