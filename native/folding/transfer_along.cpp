// Mesh transfer for every pair of parts along a whole path.
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "folding/carve_estimate.h"
#include "folding/cores.h"
#include "folding/folding.h"
#include "folding/plan.h"
#include "folding/regrowth.h"
#include "folding/smoothing.h"
#include "folding/stopwatch.h"

namespace transformables {
namespace folding {
namespace {

std::size_t count(const std::vector<char>& flags) { return std::size_t(std::count(flags.begin(), flags.end(), char(1))); }

Segmentation transferred(const Design& design, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                         TransferAlongResult& result) {
  const float tolerance = float(options.tolerance_steps);
  const auto moves = sampled_moves(design, path, options.largest_step_rad);
  const std::size_t before = count(carving_of(design, design.segmentation.owner, moves, tolerance));
  result.colliding_before = result.colliding_after = double(before) * design.sample_volume();
  if (before == 0) return design.segmentation;
  const std::vector<std::int16_t> core = cores_of(design);
  // The first way keeps parts most like they were; the others take more freely, and are tried only where it does not help.
  for (const RegrowthOptions& growth : {RegrowthOptions{tolerance, 3}, RegrowthOptions{2 * tolerance, 3}, RegrowthOptions{tolerance, 0}}) {
    Regrown grown = regrown(design, core, moves, growth, progress);
    Segmentation changed = design.segmentation;
    changed.owner = std::move(grown.owner);
    changed = retiled(changed, design.character, design.target, design.embedding);
    const std::size_t after = count(carving_of(design, changed.owner, moves, tolerance));
    if (after >= before) continue;
    std::size_t moved = 0;
    for (const std::size_t s : design.target.inside) moved += changed.owner[s] != design.segmentation.owner[s];
    result.colliding_after = double(after) * design.sample_volume();
    result.moved_volume = double(moved) * design.sample_volume();
    result.yielding = std::move(grown.yielding);
    return changed;
  }
  return design.segmentation;
}

/// All joints at once, in one move.
FoldPath straight_path(const Eigen::VectorXd& folded_angles) {
  constexpr double kOpenAlready = 1e-6;  // radians
  Move move;
  for (int angle = 0; angle < int(folded_angles.size()); ++angle)
    if (std::abs(folded_angles[angle]) > kOpenAlready) move.turns.push_back({angle, folded_angles[angle], 0});
  FoldPath path;
  if (!move.turns.empty()) path.moves.push_back(std::move(move));
  return path;
}

/// Smooths a segmentation's interfaces along a path. Level sets round off corners, which can cost a little carving: more than a
/// small share of the target, or than `most`, is not worth the looks.
Segmentation smoothed(const Design& design, const FoldPath& path, const FoldingOptions& options, double most, double& carving) {
  constexpr double kWorth = 0.003;
  const float tolerance = float(options.tolerance_steps);
  const auto moves = sampled_moves(design, path, options.largest_step_rad);
  Segmentation changed = design.segmentation;
  changed.owner = smoothed_owners(design, changed.owner, cores_of(design), moves, tolerance);
  changed = retiled(changed, design.character, design.target, design.embedding);
  const double after = double(count(carving_of(design, changed.owner, moves, tolerance))) * design.sample_volume();
  if (after > std::min(most, carving + kWorth * double(design.target.inside.size()) * design.sample_volume())) return design.segmentation;
  carving = after;
  return changed;
}

Segmentation transferred_along(const Design& design, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                               TransferAlongResult& result) {
  check(design, options);
  check(path, design.embedding.pose.angles);
  Segmentation changed;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { changed = transferred(design, path, options, progress, result); });
  return changed;
}

}  // namespace
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

/// The straight unfolding with the parts made to go with it: no order is searched for.
static Folding straight(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                        const FoldingOptions& options, const Progress& progress) {
  TransferAlongResult result;
  FoldPath path = folding::straight_path(embedding.pose.angles);
  Segmentation changed = transfer_along(segmentation, character, target, embedding, path, options, progress, &result);
  return {std::move(path), std::move(changed), result.colliding_before, result.colliding_after, std::move(result.yielding)};
}

Folding fold(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
             const FoldingOptions& options, const Progress& progress) {
  constexpr double kWorthARound = 0.05;  // of what collides, that a round must mend for another to follow
  if (options.rounds < 1) throw InvalidInput("folding: rounds must be at least 1");
  const folding::Stopwatch watch(options.threads);
  Folding best;
  const Progress beginning{[&](double, std::string_view note) { return !progress.tell || progress.tell(0, note); }};
  const folding::Design given{character, segmentation, target, embedding};
  folding::check(given, options);
  Segmentation current = folding::with_skeletons(given);
  Folding together = straight(current, character, target, embedding, options, beginning);
  FoldPath path = folding::unmeasured_plan({character, current, target, embedding}, options, progress, nullptr);
  FoldingOptions again = options;  // later plans start from the last one and need less
  again.expansions = options.expansions / 2;
  bool cut_short = path.cut_short;
  for (int round = 0; round < options.rounds; ++round) {
    const Progress part{[&](double fraction, std::string_view note) {
      return !progress.tell || progress.tell((round + fraction) / options.rounds, note);
    }};
    TransferAlongResult result;
    Segmentation changed = folding::transferred_along({character, current, target, embedding}, path, options, part, result);
    if (round == 0) best = {path, current, result.colliding_before, result.colliding_before, {}};
    const bool helped = result.colliding_after < result.colliding_before;
    if (result.colliding_after < best.carving_after)
      best = {path, changed, best.carving_before, result.colliding_after, helped ? std::move(result.yielding) : std::move(best.yielding)};
    current = std::move(changed);
    const bool slow = result.colliding_after > (1 - kWorthARound) * result.colliding_before;
    if (slow || best.carving_after == 0 || round + 1 == options.rounds) break;
    if (options.seconds > 0) again.seconds = options.seconds - watch.seconds();
    cut_short = cut_short || again.seconds < 0;
    if (cut_short) break;
    path = folding::unmeasured_plan({character, current, target, embedding}, again, part, &path);
    cut_short = path.cut_short;
  }
  if (together.carving_after < best.carving_after) best = std::move(together);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    const folding::Design design{character, best.segmentation, target, embedding};
    best.segmentation = folding::smoothed(design, best.path, options, best.carving_before, best.carving_after);
  });
  // Last, as it moves fractions of a sample, which regrowth and smoothing know nothing of.
  best.segmentation = rounded(best.segmentation, character, target, embedding, ranges_of(best.path, character), options.threads);
  best.segmentation.pinned = segmentation.pinned;
  best.path.cut_short = cut_short;
  best.path = measured(best.path, best.segmentation, character, target, embedding, options);
  return best;
}

}  // namespace transformables
