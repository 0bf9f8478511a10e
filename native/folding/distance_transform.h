// Exact Euclidean distances between the samples of a box.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace transformables::folding {

/// For each sample of a box (x fastest) the squared distance to the nearest flagged one, in steps; over 1e11 where nothing is flagged.
std::vector<float> squared_distances(const std::vector<char>& flags, const Eigen::Vector3i& size);

/// For each flagged sample the squared distance to the nearest sample of the box that is not, in steps, but no more than
/// kDeepest squared; for the others 0.
std::vector<float> squared_depths(const std::vector<char>& flags, const Eigen::Vector3i& size);
inline constexpr int kDeepest = 6;

}  // namespace transformables::folding
