// Level sets that agree with the owners of the samples and whose interfaces are smooth. Inner to the room.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::segmentation_inner {

/// An outside sample near the target's surface.
struct ShellSample {
  std::size_t index;
  Eigen::Vector3i cell;
};

inline constexpr float kAllOutside = 1e9f;   ///< steps

/// What rebuilding level sets needs to know of the target; made once, used often.
class Surfaces {
 public:
  explicit Surfaces(const Target& target);

  /// Rebuilds segmentation.phi for its owners. Values that agree in sign with the owner are kept; around those that do not, and around
  /// `doubtful` samples, the smoothest level set that respects every owner is fitted. Outside the target each level set is continued
  /// along the target's normals, so that interfaces run on through its surface.
  /// @param doubtful  a flag for each sample whose values, though of the right sign, mean nothing; may be empty
  /// @param bones  flags of those whose level set or samples changed; empty: all
  /// @param reach  steps outside the target that level sets are continued to, but no farther than `shell()`
  void settle(Segmentation& segmentation, const std::vector<char>& doubtful, int threads, const std::vector<char>& bones = {}, float reach = kAllOutside) const;

  /// Makes a tiling of owners again, and flags the bones that this changed besides those that are flagged; tells whether there were any.
  bool tile(Segmentation& segmentation, const std::vector<std::int16_t>& core, std::vector<char>& bones) const;

  /// Owners that samples of some bones were handed to made a tiling again, and the level sets of those bones settled, with any that the tiling changed.
  void settle_tiling(Segmentation& segmentation, const std::vector<std::int16_t>& core, std::vector<char> bones, int threads, float reach = kAllOutside) const;

  /// Rounds off what is rough at the scale of single samples: a few steps of diffusion near each level set's zero, inside the
  /// target only; then owned samples go to the least level set, but for those of the core, which stay as they are.
  /// @param where  flags of the samples that may change; empty: all
  void polish(std::vector<std::int16_t>& owner, std::vector<Grid<float>>& phi, const std::vector<std::int16_t>& core,
              const std::vector<char>& where, int threads) const;

  /// Samples within reach of one that its owner's level set does not hold: where owners were changed since phi was built.
  std::vector<char> changed(const Segmentation& segmentation) const;

  /// Owners that were changed made a tiling with smooth interfaces again; nothing is touched away from the change.
  void retile(Segmentation& segmentation, const std::vector<std::int16_t>& core, int threads) const;

  /// Samples outside the target up to which level sets go on, nearest first.
  const std::vector<ShellSample>& shell() const { return shell_; }

 private:
  const Target& target_;
  std::vector<char> inside_;
  std::vector<ShellSample> shell_;
};

/// A level set at a point: trilinear in its box, far outside of it.
inline float value_at(const Grid<float>& phi, const Eigen::Vector3d& p) {
  if (phi.values.empty()) return 1e9f;
  const Eigen::Vector3d q = (p - phi.shape.origin) / phi.shape.step;
  if ((q.array() < 0).any() || (q.array() > phi.shape.size.cast<double>().array() - 1).any()) return 1e9f;
  return sample(phi, p);
}

}  // namespace transformables::segmentation_inner
