// A path and the parts that go with it: the greedy order, planning and transfer in turns, and all joints at once, of which the best is taken.
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "folding/carve_estimate.h"
#include "folding/cores.h"
#include "folding/folding.h"
#include "folding/plan.h"
#include "folding/smoothing.h"
#include "folding/stopwatch.h"
#include "folding/transfer_along.h"

namespace transformables {
namespace folding {
namespace {

constexpr double kWorthARound = 0.05;  // of what collides, that a round must mend for another to follow
constexpr double kWorthLooks = 0.003;  // of the target: smoothing may cost that much carving
constexpr double kHopeful = 1.5;       // times what the best path leaves: a path whose parts leave more when they grow anew won't be better in another way

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

/// A path with the parts made to go with it, or as they are where that loses less.
Folding along(FoldPath path, const Design& design, const FoldingOptions& options, const Progress& progress, const TransferWays& ways = {}) {
  TransferAlongResult result;
  Segmentation changed = transferred_along(design, path, options, progress, result, ways);
  return {std::move(path), std::move(changed), result.colliding_before, result.colliding_after, std::move(result.yielding)};
}

/// Plans and transfers in turn, as each makes room for the other; the best that was met.
/// @param start  an order to begin with
Folding in_turns(const Design& design, const FoldPath& start, const FoldingOptions& options, const Progress& progress) {
  const Stopwatch watch(options.threads);
  FoldingOptions again = options;  // later plans start from the last one and need less
  again.expansions = options.expansions / 2;
  FoldPath path = unmeasured_plan(design, options, progress, &start);
  bool cut_short = path.cut_short;
  TransferWays later;   // parts that made room already change little
  later.patience.resize(1);
  Segmentation current = design.segmentation;
  Folding best;
  for (int round = 0; round < options.rounds; ++round) {
    const Progress part{[&](double fraction, std::string_view note) {
      return !progress.tell || progress.tell((round + fraction) / options.rounds, note);
    }};
    Folding next = along(path, {design.character, current, design.target, design.embedding}, options, part, round > 0 ? later : TransferWays{});
    const bool slow = next.carving_after > (1 - kWorthARound) * next.carving_before;
    current = next.segmentation;
    if (round > 0) next.carving_before = best.carving_before;
    if (next.yielding.empty()) next.yielding = best.yielding;
    if (round == 0 || next.carving_after < best.carving_after) best = std::move(next);
    if (slow || best.carving_after == 0 || round + 1 == options.rounds) break;
    if (options.seconds > 0) again.seconds = options.seconds - watch.seconds();
    cut_short = cut_short || again.seconds < 0;
    if (cut_short) break;
    path = unmeasured_plan({design.character, current, design.target, design.embedding}, again, part, &path);
    cut_short = path.cut_short;
  }
  best.path.cut_short = cut_short;
  return best;
}

/// What carving would take, cubic target units.
double carving(const Design& design, const std::vector<SampledMove>& moves, const FoldingOptions& options) {
  const std::vector<char> gone = carving_of(design, design.segmentation.owner, moves, float(options.tolerance_steps));
  return double(std::count(gone.begin(), gone.end(), char(1))) * design.sample_volume();
}

/// Interfaces smoothed along the path. Level sets round off corners, which can cost a little carving: more than a small share of the
/// target, or than `most`, is not worth the looks.
void smooth(Folding& folding, const Design& given, const FoldingOptions& options, double most) {
  const Design design{given.character, folding.segmentation, given.target, given.embedding};
  const auto moves = sampled_moves(design, folding.path, options.largest_step_rad);
  Segmentation changed = folding.segmentation;
  changed.owner = smoothed_owners(design, changed.owner, cores_of(design), moves, float(options.tolerance_steps));
  changed = retiled(changed, design.character, design.target, design.embedding);
  const double after = carving({design.character, changed, design.target, design.embedding}, moves, options);
  if (after > std::min(most, folding.carving_after + kWorthLooks * double(design.target.inside.size()) * design.sample_volume())) return;
  folding.segmentation = std::move(changed);
  folding.carving_after = after;
}

/// Interfaces rounded about the hinges: last, as it moves fractions of a sample, which regrowth and smoothing know nothing of. Where samples
/// change hands by it, that must not cost more than `most`.
void round_off(Folding& folding, const Design& given, const FoldingOptions& options, double most) {
  const auto moves = sampled_moves(given, folding.path, options.largest_step_rad);
  Segmentation changed = rounded(folding.segmentation, given.character, given.target, given.embedding, ranges_of(folding.path, given.character), options.threads);
  const double after = carving({given.character, changed, given.target, given.embedding}, moves, options);
  if (after > most) return;
  folding.segmentation = std::move(changed);
  folding.carving_after = after;
}

}  // namespace
}  // namespace folding

Folding fold(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
             const FoldingOptions& options, const Progress& progress) {
  if (options.rounds < 1) throw InvalidInput("folding: rounds must be at least 1");
  const folding::Design given{character, segmentation, target, embedding};
  folding::check(given, options);
  const auto at = [&](double place) { return Progress{[&, place](double, std::string_view note) { return !progress.tell || progress.tell(place, note); }}; };
  const Segmentation claimed = folding::with_skeletons(given);
  const folding::Design design{character, claimed, target, embedding};
  FoldingOptions paper = options;
  paper.cost = MoveCost::kNetOverlap;
  const FoldPath first = folding::unmeasured_greedy(design, paper, at(0));
  Folding best = folding::in_turns(design, first, options, progress);
  const bool cut_short = best.path.cut_short;
  const folding::TransferWays ways{.worth = folding::kHopeful * best.carving_after};
  Folding greedy = folding::along(first, design, options, at(1), ways);
  Folding together = folding::along(folding::straight_path(embedding.pose.angles), design, options, at(1), ways);
  const double most = greedy.carving_before;   // what is done below may cost no more, either
  for (Folding* other : {&greedy, &together})
    if (other->carving_after < best.carving_after) best = std::move(*other);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  if (options.round_off) arena.execute([&] {
    folding::smooth(best, design, options, std::min(most, best.carving_before));
    folding::round_off(best, design, options, most);
  });
  best.segmentation.pinned = segmentation.pinned;
  best.path.cut_short = cut_short;
  best.path = measured(best.path, best.segmentation, character, target, embedding, options);
  return best;
}

}  // namespace transformables
