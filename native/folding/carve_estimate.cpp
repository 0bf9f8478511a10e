#include "folding/carve_estimate.h"

#include <tbb/parallel_for.h>

#include "folding/cores.h"

namespace transformables::folding {
namespace {

/// What is left of all parts while moves carve them. Each is made anew only when it lost samples, its skin only when it meets another part.
class Carved {
 public:
  Carved(const Design& design, const std::vector<std::int16_t>& owner)
      : gone(owner.size(), 0), design_(design), shape_(design.segmentation.shape), skeletons_(skeletons_of(design)), left_(owner), skin_(skins_of(owner, skeletons_)),
        samples_(std::size_t(design.bones())), changed_(samples_.size(), 1), skin_changed_(samples_.size(), 1) {
    for (const std::size_t s : design.target.inside)
      if (owner[s] >= 0) samples_[std::size_t(owner[s])].push_back(s);
    for (auto* fields : {&parts_.fields, &parts_.skeletons}) fields->resize(samples_.size());
    for (auto* samples : {&parts_.samples, &parts_.skins}) samples->resize(samples_.size());
    tbb::parallel_for(0, design.bones(), [&](int bone) { parts_.skeletons[bone] = skeleton_field(skeletons_, shape_, bone); });
  }

  void carve(const SampledMove& move, float tolerance);
  std::vector<char> gone;

 private:
  struct Pair {
    int a = 0, b = 0;
    PairMotion motion;
    GivingWay loss{};
  };
  std::vector<Pair> meeting(const SampledMove& move, float tolerance) const;
  void rebuild();
  void rebuild_skins(const std::vector<Pair>& pairs);

  const Design& design_;
  const GridShape& shape_;
  const Skeletons skeletons_;
  std::vector<std::int16_t> left_, skin_;
  std::vector<std::vector<std::size_t>> samples_;   // [bone] that it had when its part was last made, brick by brick
  Parts parts_;
  std::vector<char> changed_, skin_changed_;
};

void Carved::rebuild() {
  tbb::parallel_for(0, design_.bones(), [&](int bone) {
    if (!changed_[bone]) return;
    parts_.fields[bone] = PartField(left_, shape_, bone);
    parts_.fields[bone].unite(skeletons_.near[std::size_t(bone)]);
    parts_.samples[bone] = PartSamples(left_, shape_, samples_[bone], bone);
    samples_[bone].assign(parts_.samples[bone].index.begin(), parts_.samples[bone].index.end());
    changed_[bone] = 0, skin_changed_[bone] = 1;
  });
}

void Carved::rebuild_skins(const std::vector<Pair>& pairs) {
  std::vector<char> wanted(samples_.size(), 0);
  for (const Pair& p : pairs) wanted[p.a] = wanted[p.b] = 1;
  tbb::parallel_for(0, design_.bones(), [&](int bone) {
    if (!wanted[bone] || !skin_changed_[bone]) return;
    parts_.skins[bone] = PartSamples(skin_, shape_, samples_[bone], bone);
    skin_changed_[bone] = 0;
  });
}

/// The pairs of which the smaller part meets the other: giving_way() takes nothing from those that do not, and need not be asked.
std::vector<Carved::Pair> Carved::meeting(const SampledMove& move, float tolerance) const {
  std::vector<Pair> pairs;
  for (int a = 0; a < design_.bones(); ++a)
    for (int b = a + 1; b < design_.bones(); ++b)
      if (move.group(a) != move.group(b) && !parts_.fields[a].empty() && !parts_.fields[b].empty()) pairs.push_back({a, b, {}});
  std::vector<char> meets(pairs.size(), 0);
  tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t p) {
    auto& [a, b, motion, loss] = pairs[p];
    motion = move.pair(a, b);
    const bool a_smaller = parts_.samples[a].points.size() <= parts_.samples[b].points.size();
    meets[p] = (a_smaller ? swept_samples(parts_.samples[a], parts_.fields[b], motion, tolerance, nullptr, 1)
                          : swept_samples(parts_.samples[b], parts_.fields[a], motion.reversed(), tolerance, nullptr, 1)) > 0;
  });
  std::vector<Pair> result;
  for (std::size_t p = 0; p < pairs.size(); ++p)
    if (meets[p]) result.push_back(std::move(pairs[p]));
  return result;
}

void Carved::carve(const SampledMove& move, float tolerance) {
  rebuild();
  std::vector<Pair> pairs = meeting(move, tolerance);
  rebuild_skins(pairs);
  tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t p) {
    pairs[p].loss = giving_way(parts_, pairs[p].a, pairs[p].b, pairs[p].motion, tolerance, true);
  });
  for (const Pair& pair : pairs)
    for (const std::uint32_t s : pair.loss.gone) {
      if (left_[s] >= 0) changed_[std::size_t(left_[s])] = 1;
      gone[s] = 1, left_[s] = skin_[s] = -1;
    }
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
  Carved carved(design, owner);
  for (const SampledMove& move : moves) carved.carve(move, tolerance);
  return std::move(carved.gone);
}

}  // namespace transformables::folding
