#include "finishing/carve.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

#include "finishing/motion.h"
#include "finishing/sweep.h"
#include "finishing/thin.h"
#include "finishing/topology.h"

namespace transformables::finishing {
namespace {

constexpr double kReach = 1.5;      ///< steps beyond the gap to which swept values are known, so that carving interpolates
constexpr double kWindow = 0.6;     ///< steps: at least one sample is as near to any surface
constexpr double kThinnest = 0.0034; ///< target units: 1 mm of 150 mm
constexpr double kNoise = 0.05;     ///< steps by which two first-order distances may seem to fall short of a gap

double reach_of(const Lattice& lattice) { return lattice.gap + kReach * lattice.step(); }

/// How near the two parts come: at a place between them, the sum of its distances to both. Places further from one
/// of them than half a step beyond the middle of the gap tell nothing that a nearer one does not tell better.
struct Nearest {
  float gap = std::numeric_limits<float>::max();
  std::int32_t where = 0;
};

Nearest nearest(const PartField& part, const Swept& swept, const Lattice& lattice) {
  Nearest best;
  const float window = float(lattice.gap / 2 + kWindow * lattice.step());
  for (std::size_t n = 0; n < swept.least.size(); ++n)
    if (swept.least[n] < window && part.distance[n] < window && part.distance[n] + swept.least[n] < best.gap)
      best = {part.distance[n] + swept.least[n], swept.where[n]};
  return best;
}

/// What a part would be after giving way.
struct Trial {
  Grid<float> psi;
  double lost = 0;          ///< samples, those near the outer surface twice
  std::size_t dropped = 0;  ///< samples of pieces cut off
};

float given_way(float value, float swept, float core, float gap, bool shielded) {
  const float moved = std::max(value, gap - swept);
  return shielded ? std::min(moved, std::max(core, value)) : moved;
}

double weight_of(const PartField& part, const Grid<float>& psi, const Lattice& lattice) {
  const float near = float(-2 * lattice.step());
  double weight = 0;
  std::size_t n = 0;
  const Eigen::Vector3i size = part.shape().size;
  for (int k = 0; k < size.z(); ++k)
    for (int j = 0; j < size.y(); ++j)
      for (int i = 0; i < size.x(); ++i, ++n)
        if (psi[n] < 0) weight += lattice.outer.at(part.corner + Eigen::Vector3i(i, j, k)) > near ? 2 : 1;
  return weight;
}

Trial try_carving(const PartField& part, const Swept& swept, const Lattice& lattice, bool shielded) {
  Trial trial;
  trial.psi = part.psi;
  const float gap = float(lattice.gap);
  for (std::size_t n = 0; n < swept.least.size(); ++n)
    if (swept.least[n] < swept.reach) trial.psi[n] = given_way(part.psi[n], swept.least[n], part.core[n], gap, shielded);
  trial.dropped = keep_core_piece(trial.psi, part.core);
  trial.lost = weight_of(part, part.psi, lattice) - weight_of(part, trial.psi, lattice);
  return trial;
}

void apply(PartField& part, Trial&& trial, const Swept& swept, const Lattice& lattice, bool shielded) {
  const float gap = float(lattice.gap);
  for (std::size_t n = 0; n < swept.least.size(); ++n) {
    if (swept.least[n] >= swept.reach) continue;
    part.distance[n] = given_way(part.distance[n], swept.least[n], part.core[n], gap, shielded);
    if (!shielded) part.core[n] = std::max(part.core[n], gap - swept.least[n]);
  }
  part.psi = std::move(trial.psi);
  // Dropped pieces are no longer there to keep others away.
  if (trial.dropped > 0) part.distance = redistanced(part.psi);
}

class PairCarver {
 public:
  PairCarver(const Scene& scene, const MoveMotion& motion, std::vector<PartField>& parts, std::vector<std::size_t>& dropped, bool exact)
      : lattice_(scene.lattice), motion_(motion), parts_(parts), dropped_(dropped), exact_(exact) {}

  /// Makes a pair free of collisions in this move; false when it was already.
  bool resolve(int i, int j) {
    PartField *a = &parts_[i], *b = &parts_[j];
    if (b->shape().count() < a->shape().count()) std::swap(a, b);
    const Swept into_a = swept(*a, *b);
    if (!collide(*a, into_a)) return false;
    // A field that is no distance would hide what is still too near from the carving below.
    if (exact_) a->psi = a->distance, b->psi = b->distance;
    const Swept into_b = swept(*b, *a);
    Trial trial_a = try_carving(*a, into_a, lattice_, true), trial_b = try_carving(*b, into_b, lattice_, true);
    const bool a_yields = trial_a.lost <= trial_b.lost;
    PartField *loser = a_yields ? a : b, *winner = a_yields ? b : a;
    take(*loser, a_yields ? std::move(trial_a) : std::move(trial_b), a_yields ? into_a : into_b, true);
    // What is left colliding is the loser's core, to which the winner's skin gives way, and at last core against core.
    yield(*winner, *loser, true);
    yield(*loser, *winner, false);
    return true;
  }

 private:
  Swept swept(const PartField& a, const PartField& b) const {
    return sweep(a, b.distance, PairConfigurations(motion_, a, b), lattice_.cover, reach_of(lattice_));
  }
  bool collide(const PartField& part, const Swept& s) const {
    return nearest(part, s, lattice_).gap < lattice_.gap - kNoise * lattice_.step();
  }
  void take(PartField& part, Trial&& trial, const Swept& s, bool shielded) {
    dropped_[part.bone] += trial.dropped;
    apply(part, std::move(trial), s, lattice_, shielded);
  }
  void yield(PartField& part, const PartField& other, bool shielded) {
    const Swept s = swept(part, other);
    if (collide(part, s)) take(part, try_carving(part, s, lattice_, shielded), s, shielded);
  }

  const Lattice& lattice_;
  const MoveMotion& motion_;
  std::vector<PartField>& parts_;
  std::vector<std::size_t>& dropped_;
  const bool exact_;
};

/// Pairs that can come near each other in a move, in order.
std::vector<std::pair<int, int>> near_pairs(const MoveMotion& motion, const std::vector<PartField>& parts, double reach) {
  const int count = int(parts.size());
  std::vector<char> near(std::size_t(count) * count, 0);
  tbb::parallel_for(0, count * count, [&](int n) {
    const int i = n / count, j = n % count;
    // The smaller one's ball is the tighter one.
    if (i < j)
      near[n] = parts[i].shape().count() < parts[j].shape().count()
                    ? PairConfigurations::can_meet(motion, parts[i], parts[j], reach)
                    : PairConfigurations::can_meet(motion, parts[j], parts[i], reach);
  });
  std::vector<std::pair<int, int>> pairs;
  for (int n = 0; n < count * count; ++n)
    if (near[n]) pairs.emplace_back(n / count, n % count);
  return pairs;
}

/// Calls f(move index, its motion, pairs that can meet) along the path.
template <class F>
void for_each_move(const Scene& scene, const std::vector<PartField>& parts, const Progress& progress, const char* note, F&& f) {
  const auto states = states_of(scene.path, scene.embedding.pose.angles);
  for (std::size_t m = 0; m < scene.path.moves.size(); ++m) {
    progress(double(m) / scene.path.moves.size(), note);
    const MoveMotion motion(scene.character, scene.embedding, scene.segmentation, scene.path.moves[m], states[m], parts,
                            scene.options, scene.lattice.cover);
    f(m, motion, near_pairs(motion, parts, reach_of(scene.lattice)));
  }
}

double overlap_at(const PartField& a, const PartField& b, const PairConfigurations& configurations, int where, const Lattice& lattice) {
  std::size_t count = 0;
  const GridShape& s = a.shape();
  for (std::size_t n = 0; n < s.count(); ++n)
    if (a.distance[n] < 0 && value_at(b.distance, configurations(where, s.cell(n).cast<float>())) < 0) ++count;
  return double(count) * lattice.sample_volume();
}

}  // namespace

bool carve(const Scene& scene, std::vector<PartField>& parts, std::vector<std::size_t>& dropped, bool exact, const Progress& progress) {
  bool changed = false;
  for_each_move(scene, parts, progress, "carving along the path", [&](std::size_t, const MoveMotion& motion, const auto& pairs) {
    PairCarver carver(scene, motion, parts, dropped, exact);
    for (const auto& [a, b] : pairs) changed |= carver.resolve(a, b);
  });
  // The walls of a shell are thin on purpose.
  if (scene.options.style == Style::kSolid)
    tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t n) { take_thin(parts[n], kThinnest); });
  return changed;
}

Measured measure(const Scene& scene, const std::vector<PartField>& parts, const Progress& progress) {
  const double reach = reach_of(scene.lattice);
  Measured measured{{}, scene.path.moves.empty() ? scene.lattice.gap : reach};
  for_each_move(scene, parts, progress, "measuring the finished parts", [&](std::size_t m, const MoveMotion& motion, const auto& pairs) {
    for (const auto& [i, j] : pairs) {
      const bool swap = parts[j].shape().count() < parts[i].shape().count();
      const PartField &a = parts[swap ? j : i], &b = parts[swap ? i : j];
      const PairConfigurations configurations(motion, a, b);
      const Nearest found = nearest(a, sweep(a, b.distance, configurations, scene.lattice.cover, reach), scene.lattice);
      measured.least_gap = std::min(measured.least_gap, double(found.gap));
      if (found.gap >= 0) continue;
      measured.collisions.push_back({std::min(a.bone, b.bone), std::max(a.bone, b.bone), m,
                                     double(found.where) / motion.last(),
                                     overlap_at(a, b, configurations, found.where, scene.lattice)});
    }
  });
  measured.least_gap -= scene.lattice.cover;
  std::stable_sort(measured.collisions.begin(), measured.collisions.end(),
                   [](const Collision& a, const Collision& b) { return a.volume > b.volume; });
  return measured;
}

}  // namespace transformables::finishing
