// What a path collides with on a given segmentation.
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "folding/costs.h"
#include "folding/folding.h"

namespace transformables {
namespace folding {
namespace {

struct PairFacts {
  Collision worst;
  std::size_t swept = 0;
};

PairFacts facts_of(const Parts& parts, const SampledMove& move, int a, int b, float tolerance, double sample_volume) {
  PairFacts facts;
  facts.swept = swept_both_ways(parts, move, a, b, tolerance);
  if (facts.swept == 0) return facts;
  const PairMotion there = move.pair(a, b), back = there.reversed();
  std::size_t most = 0;
  for (std::size_t t = 0; t < there.a_to_b.size(); ++t) {
    const std::size_t overlap = std::max(overlapping_samples(parts.samples[a], parts.fields[b], there.a_to_b[t], tolerance),
                                         overlapping_samples(parts.samples[b], parts.fields[a], back.a_to_b[t], tolerance));
    if (overlap <= most) continue;
    most = overlap;
    facts.worst.fraction = double(t) / double(there.a_to_b.size() - 1);
  }
  facts.worst.bone_a = a, facts.worst.bone_b = b;
  facts.worst.volume = double(most) * sample_volume;
  return facts;
}

FoldPath measured_path(const FoldPath& path, const Design& design, const FoldingOptions& options) {
  const Parts parts = parts_of(design.segmentation, design.target);
  FoldPath result;
  result.moves = path.moves;
  Eigen::VectorXd angles = design.embedding.pose.angles;
  std::size_t swept = 0;
  for (std::size_t m = 0; m < path.moves.size(); ++m) {
    const SampledMove move(design, angles, path.moves[m], options.largest_step_rad);
    std::vector<std::pair<int, int>> pairs;
    for (int a = 0; a < design.bones(); ++a)
      for (int b = a + 1; b < design.bones(); ++b)
        if (move.group(a) != move.group(b)) pairs.push_back({a, b});
    std::vector<PairFacts> facts(pairs.size());
    tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t p) {
      facts[p] = facts_of(parts, move, pairs[p].first, pairs[p].second, float(options.tolerance_steps), design.sample_volume());
    });
    for (PairFacts& f : facts) {
      swept += f.swept;
      f.worst.move = m;
      if (f.swept > 0) result.collisions.push_back(f.worst);
    }
    angles = angles_at(angles, path.moves[m], 1);
  }
  std::stable_sort(result.collisions.begin(), result.collisions.end(), [](const Collision& x, const Collision& y) { return x.volume > y.volume; });
  result.overlap_volume = double(swept) * design.sample_volume();
  return result;
}

}  // namespace
}  // namespace folding

FoldPath measured(const FoldPath& path, const Segmentation& segmentation, const Character& character, const Target& target,
                  const Embedding& embedding, const FoldingOptions& options) {
  const folding::Design design{character, segmentation, target, embedding};
  folding::check(design, options);
  folding::check(path, embedding.pose.angles);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  return arena.execute([&] { return folding::measured_path(path, design, options); });
}

}  // namespace transformables
