// How near parts come along the path.
#include <algorithm>
#include <limits>

#include "finishing/along_path.h"

namespace transformables::finishing {
namespace {

/// How near the two parts come: at a place between them, the sum of its distances to both. Places further from one
/// of them than half a step beyond the middle of the gap tell nothing that a nearer one does not tell better.
struct Nearest {
  float gap = std::numeric_limits<float>::max();
  std::int32_t where = 0;
};

Nearest nearest(const PartField& part, const Bricks& bricks, const Swept& swept, double window_width) {
  Nearest best;
  const float window = float(window_width);
  for (std::size_t n = 0; n < swept.least.size(); ++n)
    if (const float own = part.bound(bricks.samples[n]); swept.least[n] < window && own < window && own + swept.least[n] < best.gap)
      best = {own + swept.least[n], swept.where[n]};
  return best;
}

double overlap_at(const PartField& a, const PartField& b, const PairConfigurations& configurations, int where, const Lattice& lattice) {
  std::size_t count = 0;
  const DistanceReader distance(b);
  const GridShape& s = a.shape();
  for (std::size_t n = 0; n < s.count(); ++n)
    if (a.psi[n] < 0 && distance(configurations(where, s.cell(n).cast<float>())) < 0) ++count;
  return double(count) * lattice.sample_volume();
}

}  // namespace

Measured measure(const Scene& scene, const std::vector<PartField>& parts, const Progress& progress) {
  const double gap = scene.lattice.gap, reach = reach_of(scene.lattice, gap);
  const std::vector<Bricks> bricks = all_bricks(parts, reach);
  Measured measured{{}, reach};
  for_each_move(scene, parts, reach, progress, "measuring the finished parts", [&](std::size_t m, const MoveMotion& motion, const auto& pairs) {
    for (const auto& [i, j] : pairs) {
      const bool swap = parts[j].shape().count() < parts[i].shape().count();
      const PartField &a = parts[swap ? j : i], &b = parts[swap ? i : j];
      const Bricks& of_a = bricks[swap ? j : i];
      const PairConfigurations configurations(motion, a, b);
      const Nearest found = nearest(a, of_a, sweep(a, of_a, b, configurations, scene.lattice.cover, reach), window_of(scene.lattice, gap));
      measured.least_gap = std::min(measured.least_gap, double(found.gap));
      if (found.gap >= 0) continue;
      measured.collisions.push_back({std::min(a.bone, b.bone), std::max(a.bone, b.bone), m, double(found.where) / motion.last(),
                                     overlap_at(a, b, configurations, found.where, scene.lattice)});
    }
  });
  measured.least_gap -= scene.lattice.cover;
  std::stable_sort(measured.collisions.begin(), measured.collisions.end(),
                   [](const Collision& a, const Collision& b) { return a.volume > b.volume; });
  return measured;
}

}  // namespace transformables::finishing
