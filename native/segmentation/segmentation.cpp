#include "segmentation/segmentation.h"

#include <algorithm>
#include <cmath>

#include "segmentation/blunting.h"
#include "segmentation/growth.h"
#include "segmentation/rounding.h"
#include "segmentation/skeleton.h"
#include "segmentation/surfaces.h"
#include "segmentation/tiling.h"

namespace transformables {
namespace {

using namespace segmentation_inner;

constexpr int kBluntings = 8;  // pieces that this cuts off are given away, which may leave sharp places
constexpr int kMotions = 24;   // across a range, as in transfer

void check(const SegmentationOptions& options) {
  if (!(std::isfinite(options.speed) && options.speed > 0))
    throw InvalidInput("segmentation: the speed of growth must be a positive number");
  if (!(options.curvature >= 0 && options.curvature <= 0.5))
    throw InvalidInput("segmentation: the curvature factor must be 0 to 0.5; beyond that growth is unstable");
  if (!(std::isfinite(options.curvature_limit) && options.curvature_limit >= 0))
    throw InvalidInput("segmentation: the curvature limit must be a number of 0 or more");
  if (options.threads < 0) throw InvalidInput("segmentation: the number of threads must be 0 (all cores) or more");
}

void check_same_grid(const Segmentation& segmentation, const Character& character, const Target& target) {
  if (!(segmentation.shape == target.distance.shape) || segmentation.owner.size() != segmentation.shape.count())
    throw InvalidInput("the segmentation belongs to another target or resolution; segment again");
  if (segmentation.phi.size() != character.bones.size())
    throw InvalidInput("the segmentation belongs to another character; segment again");
}

}  // namespace

// The speed v0 only sets the unit of time: a step of growth is half a voxel, however long that takes, and `curvature` is relative to v0.
Segmentation grow(const Character& character, const Target& target, const Embedding& embedding, const SegmentationOptions& options,
                  const Progress& progress) {
  check(options);
  progress(0, "placing the skeleton");
  Skeleton skeleton = skeleton_on_lattice(character, target, embedding);
  skeleton.core = whole_skeletons(skeleton, target);
  Grown growth = grown(character, target, skeleton, options, progress);
  for (std::size_t i : target.inside)   // also for a bone whose front was swallowed
    if (skeleton.core[i] >= 0) growth.owner[i] = skeleton.core[i];
  const Surfaces surfaces(target);
  surfaces.polish(growth.owner, growth.phi, skeleton.core, {}, options.threads);
  const std::vector<std::int16_t> claimed = growth.owner;
  Segmentation result{target.distance.shape, std::move(growth.owner), std::move(growth.phi), skeleton.frames};
  make_tiling(target, skeleton.core, int(character.bones.size()), result.owner);
  std::vector<char> doubtful(claimed.size(), 0);
  for (std::size_t i : target.inside) doubtful[i] = claimed[i] != result.owner[i];
  surfaces.settle(result, doubtful, options.threads);
  std::vector<char> changed;
  for (int k = 0; k < kBluntings && blunt(result, target, skeleton.core, float(options.curvature_limit), options.threads, changed); ++k) {
    const bool cut_off = surfaces.tile(result, skeleton.core, changed);
    if (cut_off || std::find(changed.begin(), changed.end(), 1) != changed.end()) surfaces.settle(result, {}, options.threads, changed);
    if (!cut_off) break;
  }
  progress(1, "skins grown");
  return result;
}

Segmentation retiled(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding) {
  check_same_grid(segmentation, character, target);
  Segmentation result = segmentation;
  Surfaces(target).retile(result, skeleton_of_edited(character, target, embedding, segmentation).core, 0);
  return result;
}

Segmentation rounded(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                     const std::vector<JointRange>& ranges, int threads) {
  check_same_grid(segmentation, character, target);
  if (threads < 0) throw InvalidInput("segmentation: the number of threads must be 0 (all cores) or more");
  Segmentation result = segmentation;
  round_joints(result, target, skeleton_of_edited(character, target, embedding, segmentation), Surfaces(target), joints_of(character, embedding, ranges, kMotions), threads);
  return result;
}

}  // namespace transformables
