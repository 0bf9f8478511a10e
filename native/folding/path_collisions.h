// Whether a sample, as material of a part, meets another part anywhere along a path.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "folding/carve_estimate.h"
#include "folding/motion.h"

namespace transformables::folding {

class PathCollisions {
 public:
  /// @param present  [bone]: it has a part, so others can meet it
  PathCollisions(const Design& design, const std::vector<char>& present, const std::vector<SampledMove>& moves, float tolerance);

  /// What a part is from now on: the samples that `owner` gives it.
  void set_part(const std::vector<std::int16_t>& owner, int bone) {
    fields_[bone] = PartField(owner, shape_, bone);
    fields_[bone].unite(skeletons_.near[std::size_t(bone)]);
    grown_[bone] = 0;
  }
  /// A part has grown by a layer of neighbours since it was set.
  void grew(int bone) { ++grown_[bone]; }
  /// Sets all parts that have grown.
  void refresh(const std::vector<std::int16_t>& owner);

  /// For each sample in how many encounters of the path it would collide as material of `bone`; counts up to `enough`.
  std::vector<int> hits(const std::vector<std::uint32_t>& samples, int bone, int enough) const;
  /// The same while parts grow: those are set again that may be met.
  std::vector<int> hits(const std::vector<std::uint32_t>& samples, int bone, int enough, const std::vector<std::int16_t>& owner);

 private:
  struct Encounter {
    int other = 0;
    PairMotion motion;
  };
  struct Grouped;
  Grouped grouped(const std::vector<std::uint32_t>& samples, int bone) const;
  std::vector<int> hits(const Grouped& samples, int enough) const;
  std::vector<const Encounter*> near(std::span<const Eigen::Vector3f> points, int bone) const;
  void hits_of_brick(std::span<const Eigen::Vector3f> points, const std::vector<const Encounter*>& encounters, int enough, std::span<int> found) const;

  const GridShape& shape_;
  const Skeletons skeletons_;
  float tolerance_;
  std::vector<std::vector<Encounter>> encounters_;  // [bone]
  std::vector<PartField> fields_;
  std::vector<int> grown_;   // [bone] layers that its field knows nothing of
};

}  // namespace transformables::folding
