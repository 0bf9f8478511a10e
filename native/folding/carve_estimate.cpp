#include "folding/carve_estimate.h"

#include <tbb/parallel_for.h>

#include "folding/cores.h"

namespace transformables::folding {
namespace {

void rebuild(Parts& parts, const Design& design, const std::vector<std::int16_t>& owner, const Skeletons& skeletons, const std::vector<char>& changed) {
  const GridShape& shape = design.segmentation.shape;
  const std::vector<std::int16_t> skin = skins_of(owner, skeletons);
  tbb::parallel_for(0, design.bones(), [&](int bone) {
    if (!changed[bone]) return;
    parts.fields[bone] = PartField(owner, shape, bone);
    parts.fields[bone].unite(skeletons.near[std::size_t(bone)]);
    parts.samples[bone] = PartSamples(owner, shape, design.target.inside, bone);
    parts.skins[bone] = PartSamples(skin, shape, design.target.inside, bone);
  });
}

}  // namespace

std::vector<SampledMove> sampled_moves(const Design& design, const FoldPath& path, double largest_step_rad) {
  std::vector<SampledMove> moves;
  Eigen::VectorXd angles = design.embedding.pose.angles;
  for (const Move& move : path.moves) {
    moves.emplace_back(design, angles, move, largest_step_rad);
    angles = angles_at(angles, move, 1);
  }
  return moves;
}

std::vector<char> carving_of(const Design& design, const std::vector<std::int16_t>& owner, const std::vector<SampledMove>& moves, float tolerance) {
  std::vector<std::int16_t> left = owner;
  std::vector<char> gone(owner.size(), 0), changed(design.bones(), 1);
  const std::size_t bones = std::size_t(design.bones());
  Parts parts{std::vector<PartField>(bones), std::vector<PartSamples>(bones), std::vector<PartField>(bones), std::vector<PartSamples>(bones)};
  const Skeletons skeletons = skeletons_of(design);
  tbb::parallel_for(0, design.bones(), [&](int bone) { parts.skeletons[bone] = skeleton_field(skeletons, design.segmentation.shape, bone); });
  for (const SampledMove& move : moves) {
    rebuild(parts, design, left, skeletons, changed);
    std::vector<std::pair<int, int>> pairs;
    for (int a = 0; a < design.bones(); ++a)
      for (int b = a + 1; b < design.bones(); ++b)
        if (move.group(a) != move.group(b)) pairs.push_back({a, b});
    std::vector<GivingWay> meetings(pairs.size());
    tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t p) {
      const auto [a, b] = pairs[p];
      meetings[p] = giving_way(parts, a, b, move.pair(a, b), tolerance, true);
    });
    changed.assign(bones, 0);
    for (const GivingWay& m : meetings)
      for (const std::uint32_t s : m.gone) {
        if (left[s] >= 0) changed[std::size_t(left[s])] = 1;
        gone[s] = 1, left[s] = -1;
      }
  }
  return gone;
}

}  // namespace transformables::folding
