// Level sets that agree with the owners of the samples and whose interfaces are smooth. Inner to the room.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// Rebuilds segmentation.phi for its owners. Values that agree in sign with the owner are kept; around those that do not, and around
/// `doubtful` samples, the smoothest level set that respects every owner is fitted. Outside the target each level set is continued
/// along the target's normals, so that interfaces run on through its surface.
/// @param doubtful  a flag for each sample whose values, though of the right sign, mean nothing; may be empty
void settle(Segmentation& segmentation, const Target& target, const std::vector<char>& doubtful, int threads);

/// Rounds off what growth leaves at the scale of single samples: a few steps of diffusion near each level set's zero, inside the
/// target only; then owned samples go to the least level set.
/// @param phi  over boxes of the target's lattice, target units
void polish(const Target& target, std::vector<std::int16_t>& owner, std::vector<Grid<float>>& phi, int threads);

/// A level set at a point: trilinear in its box, far outside of it.
inline float value_at(const Grid<float>& phi, const Eigen::Vector3d& p) {
  if (phi.values.empty()) return 1e9f;
  const Eigen::Vector3d q = (p - phi.shape.origin) / phi.shape.step;
  if ((q.array() < 0).any() || (q.array() > phi.shape.size.cast<double>().array() - 1).any()) return 1e9f;
  return sample(phi, p);
}

}  // namespace transformables::segmentation_inner
