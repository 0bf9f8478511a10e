#include "finishing/carve.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>

#include "finishing/along_path.h"
#include "finishing/sweep.h"
#include "finishing/topology.h"

namespace transformables::finishing {
namespace {

constexpr double kAround = 0.018;   ///< target units about a place that is carved again: reaches the next one that is told (pair_proof.cpp)
constexpr double kCoreToKeep = 0.5; ///< of a part's core
constexpr double kNoise = 0.05;     ///< steps by which two first-order distances may seem to fall short of a gap: nothing gives way by less

/// Flags of a part's samples around some places.
std::vector<char> mask_around(const PartField& part, const std::vector<Eigen::Vector3d>& places) {
  const GridShape& shape = part.shape();
  std::vector<char> mask(places.empty() ? 0 : shape.count(), 0);
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Array3d centre = (place - shape.origin).array() / shape.step;
    const double radius = kAround / shape.step;
    const Eigen::Array3i low = (centre - radius).ceil().cast<int>().max(0), high = (centre + radius).floor().cast<int>().min(shape.size.array() - 1);
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i)
          if ((Eigen::Array3d(i, j, k) - centre).matrix().norm() <= radius) mask[shape.index(i, j, k)] = 1;
  }
  return mask;
}

/// What a part would be after giving way.
struct Trial {
  Grid<float> psi;
  double lost = 0;          ///< samples, those near the outer surface twice
  std::size_t dropped = 0;  ///< samples of pieces cut off
};

float given_way(float value, float swept, float core, float gap, float noise, bool shielded) {
  const float moved = gap - swept < value + noise ? value : gap - swept;
  return shielded ? std::min(moved, std::max(core, value)) : moved;
}

float noise_of(const PartField& part) { return float(kNoise * part.shape().step); }

double weight_lost(const PartField& part, const Grid<float>& psi) {
  const float near = -2 * float(part.shape().step);
  double weight = 0;
  for (std::size_t n = 0; n < psi.values.size(); ++n)
    if (part.psi[n] < 0 && !(psi[n] < 0)) weight += part.away[n].outer > near ? 2 : 1;
  return weight;
}

/// The share of a part's core that is left.
double core_left(const PartField& part, const Grid<float>& psi) {
  std::size_t before = 0, after = 0;
  for (std::size_t n = 0; n < psi.values.size(); ++n)
    if (part.core[n] < 0 && part.psi[n] < 0) {
      ++before;
      after += psi[n] < 0;
    }
  return double(after) / double(std::max<std::size_t>(1, before));
}

/// How a pair is carved.
struct Manner {
  double gap = 0;
  bool exact = false;   ///< beside what goes, a part's distance takes the place of its inner field, which may be steeper and so hide what is too near
};

/// Calls f(sample, new value of the inner field) for all samples that others come near.
template <class F>
void for_each_given(const PartField& part, const Bricks& bricks, const Swept& swept, const Manner& manner, bool shielded, F&& f) {
  const float gap = float(manner.gap), beside = gap + float(part.shape().step), noise = noise_of(part);
  for (std::size_t n = 0; n < swept.least.size(); ++n) {
    if (swept.least[n] >= swept.reach) continue;
    const std::uint32_t at = bricks.samples[n];
    const float value = manner.exact && swept.least[n] < beside ? part.away[at].inner : part.inner[at];
    f(n, at, given_way(value, swept.least[n], part.core[at], gap, noise, shielded));
  }
}

Trial try_carving(const PartField& part, const Bricks& bricks, const Swept& swept, const Manner& manner, bool shielded) {
  Trial trial;
  trial.psi = part.psi;
  for_each_given(part, bricks, swept, manner, shielded, [&](std::size_t, std::uint32_t at, float inner) {
    trial.psi[at] = std::max(inner, part.away[at].outer);
  });
  trial.dropped = keep_core_piece(trial.psi, part.core);
  trial.lost = weight_lost(part, trial.psi);
  return trial;
}

void apply(PartField& part, const Bricks& bricks, Trial&& trial, const Swept& swept, const Manner& manner, bool shielded) {
  const float gap = float(manner.gap), noise = noise_of(part);
  for_each_given(part, bricks, swept, manner, shielded, [&](std::size_t n, std::uint32_t at, float inner) {
    part.away[at].inner = given_way(part.away[at].inner, swept.least[n], part.core[at], gap, noise, shielded);
    part.inner[at] = inner;
    part.psi[at] = std::max(inner, part.away[at].outer);
    if (!shielded) part.core[at] = std::max(part.core[at], gap - swept.least[n]);
  });
  if (trial.dropped == 0) return;
  // Dropped pieces are no longer there to keep others away.
  adopt(part, std::move(trial.psi));
  refresh(part);
}

/// A part and the samples of it that may go.
struct Side {
  PartField* part = nullptr;
  const Bricks* bricks = nullptr;
};

/// What parts lost, by bone.
struct Losses {
  std::vector<std::size_t>& dropped;   ///< samples of pieces that were cut off
  std::vector<char> changed;           ///< flags
};

class PairCarver {
 public:
  PairCarver(const Scene& scene, const MoveMotion& motion, Side a, Side b, Manner manner)
      : lattice_(scene.lattice), motion_(motion), a_(a), b_(b), manner_(manner) {
    if (b.part->shape().count() < a.part->shape().count()) std::swap(a_, b_);
  }

  /// Makes the pair free of collisions in this move.
  void resolve(Losses& losses) {
    if (!collide(a_, b_)) return;
    Swept into_a, into_b;
    Trial trial_a, trial_b;
    const auto go = [&](const Side& side, const Side& other, Swept& into, Trial& trial) {
      into = swept(side, other);
      trial = try_carving(*side.part, *side.bricks, into, manner_, true);
    };
    tbb::parallel_invoke([&] { go(a_, b_, into_a, trial_a); }, [&] { go(b_, a_, into_b, trial_b); });
    const bool a_yields = trial_a.lost <= trial_b.lost;
    const Side &loser = a_yields ? a_ : b_, &winner = a_yields ? b_ : a_;
    take(loser, a_yields ? std::move(trial_a) : std::move(trial_b), a_yields ? into_a : into_b, true, losses);
    // What is left colliding is mostly the loser's core, to which the winner's skin gives way, and at last core against core.
    yield(winner, loser, losses);
    yield_cores(loser, winner, losses);
  }

 private:
  Swept swept(const Side& a, const Side& b) const {
    std::vector<Matter> matters;
    if (!manner_.exact)  // else samples change beside what goes, too
      for (const std::uint32_t at : a.bricks->samples)
        matters.push_back({float(manner_.gap) - std::min(a.part->inner[at], a.part->away[at].inner), std::numeric_limits<float>::lowest()});
    const double reach = reach_of(lattice_, manner_.gap);
    return sweep(*a.part, *a.bricks, *b.part, PairConfigurations(motion_, *a.part, *b.part), lattice_.cover, reach, 0, matters);
  }
  /// Looks only at places between the two.
  bool collide(const Side& side, const Side& other) const {
    const float window = float(window_of(lattice_, manner_.gap)), least = float(manner_.gap - kNoise * lattice_.step());
    std::vector<float> below;
    for (const std::uint32_t at : side.bricks->samples) {
      const float own = side.part->bound(at);
      below.push_back(own < window ? std::min(window, least - own) : std::numeric_limits<float>::lowest());
    }
    return any_nearer(*side.part, *side.bricks, *other.part, PairConfigurations(motion_, *side.part, *other.part), lattice_.cover, below);
  }
  void take(const Side& side, Trial&& done, const Swept& s, bool shielded, Losses& losses) const {
    losses.dropped[std::size_t(side.part->bone)] += done.dropped;
    losses.changed[std::size_t(side.part->bone)] = 1;
    apply(*side.part, *side.bricks, std::move(done), s, manner_, shielded);
  }
  /// All but its core.
  void yield(const Side& side, const Side& other, Losses& losses) const {
    if (!collide(side, other)) return;
    const Swept s = swept(side, other);
    take(side, try_carving(*side.part, *side.bricks, s, manner_, true), s, true, losses);
  }

  /// Core against core. A part that would hardly keep any of its core is nothing to hold on to: then the other gives way, when it keeps more.
  void yield_cores(const Side& side, const Side& other, Losses& losses) const {
    if (!collide(side, other)) return;
    const Swept s = swept(side, other);
    Trial trial = try_carving(*side.part, *side.bricks, s, manner_, false);
    const double left = core_left(*side.part, trial.psi);
    if (left < kCoreToKeep) {
      const Swept s_other = swept(other, side);
      Trial trial_other = try_carving(*other.part, *other.bricks, s_other, manner_, false);
      if (core_left(*other.part, trial_other.psi) > left) return take(other, std::move(trial_other), s_other, false, losses);
    }
    take(side, std::move(trial), s, false, losses);
  }

  const Lattice& lattice_;
  const MoveMotion& motion_;
  Side a_, b_;   // the smaller one first
  const Manner manner_;
};

/// Calls f(pair) for all pairs as if one after the other: those that share no part go on at the same time.
template <class F>
void for_each_in_turn(const std::vector<std::pair<int, int>>& pairs, std::size_t parts, F&& f) {
  std::vector<std::vector<std::pair<int, int>>> rounds;
  std::vector<std::size_t> free_from(parts, 0);   // for each part, the round from which on it is free
  for (const auto& [a, b] : pairs) {
    const std::size_t round = std::max(free_from[std::size_t(a)], free_from[std::size_t(b)]);
    if (round == rounds.size()) rounds.emplace_back();
    rounds[round].emplace_back(a, b);
    free_from[std::size_t(a)] = free_from[std::size_t(b)] = round + 1;
  }
  for (const auto& round : rounds) tbb::parallel_for(std::size_t(0), round.size(), [&](std::size_t n) { f(round[n]); });
}

}  // namespace

void carve(const Scene& scene, std::vector<PartField>& parts, std::vector<std::size_t>& dropped, const Progress& progress) {
  const double reach = reach_of(scene.lattice, scene.lattice.passing);
  const std::vector<Bricks> bricks = all_bricks(parts, reach);
  Losses losses{dropped, std::vector<char>(parts.size(), 0)};
  for_each_move(scene, parts, reach, progress, "carving along the path", [&](std::size_t, const MoveMotion& motion, const auto& pairs) {
    for_each_in_turn(pairs, parts.size(), [&](const auto& pair) {
      const auto [a, b] = pair;
      PairCarver(scene, motion, {&parts[a], &bricks[a]}, {&parts[b], &bricks[b]}, {scene.lattice.passing, false}).resolve(losses);
    });
  });
}

std::vector<char> carve_again(const Scene& scene, const Demands& demands, std::vector<PartField>& parts, std::vector<std::size_t>& dropped,
                              const Progress& progress) {
  Losses losses{dropped, std::vector<char>(parts.size(), 0)};
  double extra = 0;
  for (const auto& [pair, demand] : demands) extra = std::max(extra, demand.extra);
  const double reach = reach_of(scene.lattice, scene.lattice.passing + extra);
  std::map<std::pair<int, int>, std::pair<Bricks, Bricks>> around;
  for (const auto& [pair, demand] : demands) {
    const PartField &a = parts[std::size_t(pair.first)], &b = parts[std::size_t(pair.second)];
    around[pair] = {bricks_of(a, reach, mask_around(a, demand.on_a)), bricks_of(b, reach, mask_around(b, demand.on_b))};
  }
  for_each_move(scene, parts, reach, progress, "carving where parts are too near", [&](std::size_t, const MoveMotion& motion, const auto& pairs) {
    for_each_in_turn(pairs, parts.size(), [&](const auto& pair) {
      const auto found = demands.find(pair);
      if (found == demands.end()) return;
      const auto [a, b] = pair;
      const auto& [on_a, on_b] = around.at(pair);
      const Manner manner{scene.lattice.passing + found->second.extra, true};
      PairCarver(scene, motion, {&parts[a], &on_a}, {&parts[b], &on_b}, manner).resolve(losses);
    });
  });
  return std::move(losses.changed);
}

}  // namespace transformables::finishing
