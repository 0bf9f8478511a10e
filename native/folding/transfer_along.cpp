// Mesh transfer for every pair of parts along a whole path.
#include <tbb/task_arena.h>

#include <algorithm>

#include "folding/carve_estimate.h"
#include "folding/cores.h"
#include "folding/folding.h"
#include "folding/regrowth.h"
#include "folding/transfer_along.h"

namespace transformables {
namespace folding {
namespace {

constexpr double kWorthAWay = 0.03;   // share by which a freer way must leave less than one before it

std::size_t count(const std::vector<char>& flags) { return std::size_t(std::count(flags.begin(), flags.end(), char(1))); }

Segmentation transferred(const Design& design, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                         TransferAlongResult& result, const TransferWays& ways) {
  const float tolerance = float(options.tolerance_steps);
  const auto moves = sampled_moves(design, path, options.largest_step_rad);
  const std::size_t before = count(carving_of(design, design.segmentation.owner, moves, tolerance));
  result.colliding_before = result.colliding_after = double(before) * design.sample_volume();
  Segmentation best = design.segmentation;
  if (before == 0) return best;
  const std::vector<std::int16_t> core = cores_of(design);
  double least = double(before);   // that a way must stay under
  for (const int patience : ways.patience) {
    Regrown grown = regrown(design, core, moves, {tolerance, patience}, progress);
    Segmentation changed = design.segmentation;
    changed.owner = std::move(grown.owner);
    changed = retiled(changed, design.character, design.target, design.embedding);
    const double after = double(count(carving_of(design, changed.owner, moves, tolerance)));
    if (after < least) {
      least = (1 - kWorthAWay) * after;
      result.colliding_after = after * design.sample_volume();
      result.yielding = std::move(grown.yielding);
      best = std::move(changed);
    }
    if (after * design.sample_volume() > ways.worth) break;
  }
  std::size_t moved = 0;
  for (const std::size_t s : design.target.inside) moved += best.owner[s] != design.segmentation.owner[s];
  result.moved_volume = double(moved) * design.sample_volume();
  return best;
}

}  // namespace

Segmentation transferred_along(const Design& design, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                               TransferAlongResult& result, const TransferWays& ways) {
  check(design, options);
  check(path, design.embedding.pose.angles);
  Segmentation changed;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { changed = transferred(design, path, options, progress, result, ways); });
  return changed;
}

}  // namespace folding

Segmentation transfer_along(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                            const FoldPath& path, const FoldingOptions& options, const Progress& progress, TransferAlongResult* result) {
  TransferAlongResult facts;
  const folding::Design design{character, segmentation, target, embedding};
  folding::check(design, options);
  const Segmentation claimed = folding::with_skeletons(design);
  const Segmentation changed = folding::transferred_along({character, claimed, target, embedding}, path, options, progress, facts);
  if (result) *result = std::move(facts);
  Segmentation round = rounded(changed, character, target, embedding, ranges_of(path, character), options.threads);
  round.pinned = segmentation.pinned;
  return round;
}

}  // namespace transformables
