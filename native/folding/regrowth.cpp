#include "folding/regrowth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "folding/path_collisions.h"

namespace transformables::folding {
namespace {

std::vector<char> bones_with_core(const Design& design, const std::vector<std::int16_t>& core) {
  std::vector<char> has_core(design.bones(), 0);
  for (const std::size_t s : design.target.inside)
    if (core[s] >= 0) has_core[core[s]] = 1;
  return has_core;
}

class Regrowth {
 public:
  Regrowth(const Design& design, const std::vector<std::int16_t>& core, const std::vector<SampledMove>& moves, const RegrowthOptions& options);
  void grow(const Progress& progress);
  std::vector<std::size_t> fill();
  std::vector<std::int16_t> owner;

 private:
  template <class Visit>
  void each_neighbour(std::size_t s, const Visit& visit) const;
  void take(std::size_t s, int bone);
  bool wave(int bone, int number);
  bool may_try(std::size_t s, int bone, int number) const;
  bool may_take(std::size_t s, int bone) const { return design_.segmentation.may_grow(bone) || design_.segmentation.owner[s] == bone; }
  char& dead(std::size_t s, int bone) { return dead_[std::size_t(place_[s]) * bones_ + bone]; }
  char dead(std::size_t s, int bone) const { return dead_[std::size_t(place_[s]) * bones_ + bone]; }

  const Design& design_;
  const GridShape& shape_;
  const RegrowthOptions options_;
  std::size_t bones_;
  PathCollisions collisions_;
  std::vector<int> place_;                          // of a sample among the inside ones, -1 outside
  std::vector<int> reached_;                        // wave in which some part first touched it
  std::vector<char> dead_;                          // [place][bone]: it would collide
  std::vector<std::vector<std::uint32_t>> fringe_;  // [bone]: samples to be tried
  int wave_ = 0;
};

Regrowth::Regrowth(const Design& design, const std::vector<std::int16_t>& core, const std::vector<SampledMove>& moves, const RegrowthOptions& options)
    : owner(core.size(), -1), design_(design), shape_(design.segmentation.shape), options_(options), bones_(std::size_t(design.bones())),
      collisions_(design, bones_with_core(design, core), moves, options.tolerance), place_(core.size(), -1), reached_(core.size(), -1), dead_(design.target.inside.size() * bones_, 0),
      fringe_(bones_) {
  for (std::size_t i = 0; i < design.target.inside.size(); ++i) place_[design.target.inside[i]] = int(i);
  for (const std::size_t s : design.target.inside)
    if (core[s] >= 0) take(s, core[s]);
  tbb::parallel_for(0, int(bones_), [&](int b) { collisions_.set_part(owner, b); });
}

template <class Visit>
void Regrowth::each_neighbour(std::size_t s, const Visit& visit) const {
  const Eigen::Vector3i c = shape_.cell(s);
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      Eigen::Vector3i n = c;
      n[axis] += side;
      if (shape_.contains(n) && place_[shape_.index(n)] >= 0) visit(shape_.index(n));
    }
}

void Regrowth::take(std::size_t s, int bone) {
  owner[s] = std::int16_t(bone);
  each_neighbour(s, [&](std::size_t n) {
    if (owner[n] >= 0 || !may_take(n, bone)) return;
    if (reached_[n] < 0) reached_[n] = wave_;
    fringe_[bone].push_back(std::uint32_t(n));
  });
}

bool Regrowth::may_try(std::size_t s, int bone, int number) const {
  const int former = design_.segmentation.owner[s];
  return former == bone || dead(s, former) || number >= reached_[s] + options_.patience;
}

bool Regrowth::wave(int bone, int number) {
  auto& fringe = fringe_[bone];
  std::sort(fringe.begin(), fringe.end());
  fringe.erase(std::unique(fringe.begin(), fringe.end()), fringe.end());
  std::vector<std::uint32_t> tried, waiting;
  for (const std::uint32_t s : fringe) {
    if (owner[s] >= 0 || dead(s, bone)) continue;
    (may_try(s, bone, number) ? tried : waiting).push_back(s);
  }
  fringe = waiting;
  const std::vector<int> found = collisions_.hits(tried, bone, 1, owner);
  bool grew = false;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    if (found[i] == 0) take(tried[i], bone), grew = true;
    else dead(tried[i], bone) = 1;
  }
  if (grew) collisions_.grew(bone);
  return grew || !waiting.empty();
}

void Regrowth::grow(const Progress& progress) {
  const double longest = double(shape_.size.maxCoeff());
  bool more = true;
  for (wave_ = 1; more; ++wave_) {
    progress(std::min(0.9, double(wave_) / longest), "giving material to parts that can carry it");
    more = false;
    for (std::size_t b = 0; b < bones_; ++b) more = wave(int(b), wave_) || more;
  }
}

/// Gives what is left to the neighbour with which it collides least, layer by layer.
std::vector<std::size_t> Regrowth::fill() {
  std::vector<std::size_t> left;
  for (const std::size_t s : design_.target.inside)
    if (owner[s] < 0) left.push_back(s);
  const std::vector<std::size_t> all = left;
  constexpr int kMany = 1000;
  collisions_.refresh(owner);
  bool to_anyone = false;  // inhibited bones, too: only for what no other can reach
  while (!left.empty()) {
    std::vector<int> choice(left.size(), -1);
    tbb::parallel_for(std::size_t(0), left.size(), [&](std::size_t i) {
      int least = kMany + 1;
      std::array<int, 6> seen{-1, -1, -1, -1, -1, -1};
      std::size_t count = 0;
      each_neighbour(left[i], [&](std::size_t n) {
        const int bone = owner[n];
        if (bone < 0 || std::find(seen.begin(), seen.end(), bone) != seen.end()) return;
        if (!to_anyone && !may_take(left[i], bone)) return;
        seen[count++] = bone;
        const int found = collisions_.hits({std::uint32_t(left[i])}, bone, kMany).front();
        if (found < least || (found == least && bone == design_.segmentation.owner[left[i]])) least = found, choice[i] = bone;
      });
    });
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < left.size(); ++i) {
      if (choice[i] >= 0) owner[left[i]] = std::int16_t(choice[i]);
      else rest.push_back(left[i]);
    }
    if (rest.size() == left.size() && to_anyone) throw InvalidInput("folding: the target's inside samples are not one connected piece; repair the target");
    to_anyone = rest.size() == left.size();
    left = std::move(rest);
  }
  return all;
}

}  // namespace

Regrown regrown(const Design& design, const std::vector<std::int16_t>& core, const std::vector<SampledMove>& moves,
                const RegrowthOptions& options, const Progress& progress) {
  Regrowth growth(design, core, moves, options);
  growth.grow(progress);
  Regrown result;
  result.yielding = growth.fill();
  result.owner = std::move(growth.owner);
  return result;
}

}  // namespace transformables::folding
