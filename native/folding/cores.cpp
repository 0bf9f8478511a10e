#include "folding/cores.h"

#include <tbb/parallel_for.h>

#include <limits>

namespace transformables::folding {

std::vector<std::int16_t> cores_of(const Design& design) {
  constexpr double kShare = 0.9;
  const auto& [character, segmentation, target, embedding] = design;
  const std::vector<SkeletalShape> shapes = skeletal_shapes(character, embedding.morphology, 0);
  std::vector<std::int16_t> core(segmentation.owner.size(), -1);
  std::vector<float> depth(target.inside.size());
  tbb::parallel_for(std::size_t(0), target.inside.size(), [&](std::size_t i) {
    const std::size_t s = target.inside[i];
    const int bone = segmentation.owner[s];
    const double d = shapes[bone].distance(segmentation.frames[bone].inverse() * segmentation.shape.position(s));
    depth[i] = float(d + (1 - kShare) * shapes[bone].radius);
    if (depth[i] < 0 || segmentation.is_pinned(s)) core[s] = std::int16_t(bone);
  });
  // A capsule can be thinner than the lattice: its nearest sample stands for it then.
  std::vector<float> least(character.bones.size(), std::numeric_limits<float>::max());
  std::vector<std::size_t> nearest(character.bones.size(), 0);
  for (std::size_t i = 0; i < target.inside.size(); ++i) {
    const int bone = segmentation.owner[target.inside[i]];
    if (depth[i] < least[bone]) least[bone] = depth[i], nearest[bone] = target.inside[i];
  }
  for (std::size_t b = 0; b < least.size(); ++b)
    if (least[b] < std::numeric_limits<float>::max()) core[nearest[b]] = std::int16_t(b);
  return core;
}

}  // namespace transformables::folding
