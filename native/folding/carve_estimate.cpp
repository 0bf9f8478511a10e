#include "folding/carve_estimate.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace transformables::folding {
namespace {

struct Meeting {
  int loser = 0;
  std::vector<std::uint32_t> samples;  // of the loser, that are in the other's way
};

Meeting meeting(const Parts& parts, const SampledMove& move, int a, int b, float tolerance) {
  const PairMotion there = move.pair(a, b);
  std::vector<char> hit_a, hit_b;
  const std::size_t in_b = swept_samples(parts.samples[a], parts.fields[b], there, tolerance, &hit_a);
  if (in_b == 0) return {};
  const std::size_t in_a = swept_samples(parts.samples[b], parts.fields[a], there.reversed(), tolerance, &hit_b);
  Meeting m;
  m.loser = in_b <= in_a ? a : b;
  const auto& hit = in_b <= in_a ? hit_a : hit_b;
  for (std::size_t i = 0; i < hit.size(); ++i)
    if (hit[i]) m.samples.push_back(parts.samples[m.loser].index[i]);
  return m;
}

void rebuild(Parts& parts, const Design& design, const std::vector<std::int16_t>& owner, const std::vector<char>& changed) {
  tbb::parallel_for(0, design.bones(), [&](int bone) {
    if (!changed[bone]) return;
    parts.fields[bone] = PartField(owner, design.segmentation.shape, bone);
    parts.samples[bone] = PartSamples(owner, design.segmentation.shape, design.target.inside, bone);
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
  Parts parts{std::vector<PartField>(design.bones()), std::vector<PartSamples>(design.bones())};
  for (const SampledMove& move : moves) {
    rebuild(parts, design, left, changed);
    std::vector<std::pair<int, int>> pairs;
    for (int a = 0; a < design.bones(); ++a)
      for (int b = a + 1; b < design.bones(); ++b)
        if (move.group(a) != move.group(b)) pairs.push_back({a, b});
    std::vector<Meeting> meetings(pairs.size());
    tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t p) { meetings[p] = meeting(parts, move, pairs[p].first, pairs[p].second, tolerance); });
    changed.assign(design.bones(), 0);
    for (const Meeting& m : meetings)
      for (const std::uint32_t s : m.samples) gone[s] = 1, left[s] = -1, changed[m.loser] = 1;
  }
  return gone;
}

}  // namespace transformables::folding
