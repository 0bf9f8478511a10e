#include "embedding/search.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "embedding/flood.h"

namespace transformables {
namespace {

// The search ranks by the total plus this times all depths of collision and protrusion. The squares of Eqs. 4
// and 5 are flat near zero and lose against L_skin, whose sum is in the hundreds: they would leave a design infeasible.
constexpr double kFeasibility = 1e4;
constexpr double kPinned = 1e5;          // so that a bone is rather out of the target than off its pin
constexpr double kPainted = 6e3;         // soft: a voxel that a painted region is missed by costs less than a voxel of a collision
constexpr double kPinnedTurn = 0.1;      // a pinned bone's turn by a radian counts as much as this move
constexpr double kCarefulSigma = 0.08;
constexpr std::chrono::milliseconds kShown{40};

// There are half as many finalists again as solutions are wanted, but no fewer than these; for each so many candidates, and a short run tells which are
// good. A larger population has longer runs.
constexpr std::size_t kFewest = 4, kCandidates = 2;
constexpr long kShortRun = 300;
// What the search tries is seen on coarse grids that take turns; what it found is judged on the fine one, at every boundary voxel. On any one grid the terms are off
// by a tenth or two, as its voxels happen to lie, and a search that sees one grid finds poses that are good on that grid alone.
constexpr int kGrids = 8;
constexpr double kVoxelsABone = 350, kLeastVoxels = 6000;  // of a coarse grid
constexpr double kSameVolume = 0.1;      // a coarse grid that loses or wins more of the target is left out
constexpr std::size_t kFewVoxels = 6000; // of a coarse grid: with more, one boundary voxel in three is looked at, with twice as many one in five
constexpr double kShifts[] = {0.8191725134, 0.6710436067, 0.5497004779};  // spread evenly (Roberts 2018)
constexpr double kTouching = 0.1;        // steps: what is less deep in one another does not count as a collision

/// How far a pinned bone is from its place, and how much it is turned away (as a vector, in moves that count as much).
std::pair<Eigen::Vector3d, Eigen::Vector3d> misplacement(const PinnedBone& pin, const Skeleton& skeleton) {
  const auto bone = std::size_t(pin.bone);
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(skeleton.rotations[bone] * pin.frame.linear().transpose()));
  return {skeleton.heads[bone] - pin.frame.translation(), kPinnedTurn * turn.angle() * turn.axis()};
}

/// Box centre when that is inside, else the deepest place inside.
Eigen::Vector3d start_head(const Target& target) {
  const GridShape& shape = target.distance.shape;
  const Eigen::Vector3i centre = shape.nearest(Eigen::Vector3d::Zero());
  if (shape.contains(centre) && std::binary_search(target.inside.begin(), target.inside.end(), shape.index(centre)))
    return Eigen::Vector3d::Zero();
  const std::size_t deepest = *std::min_element(target.inside.begin(), target.inside.end(), [&](std::size_t a, std::size_t b) {
    return target.distance[a] < target.distance[b];
  });
  Eigen::Vector3d head = shape.position(deepest);
  if (target.mirror_axis) head[*target.mirror_axis] = 0;
  return head;
}

/// Whether the flood of a grid would come to as much as the target holds: slender targets fall apart on coarse grids.
bool holds(const Voxels& voxels, const Target& target) {
  std::vector<std::int32_t> field = voxels.wall, rows;
  for (std::int32_t& cell : field) cell = cell == 0 ? kUnreached : cell;
  field[std::size_t(voxels.runs[voxels.runs.size() / 2].begin)] = 0;
  rows.reserve(std::size_t(voxels.size.y() + 2) * std::size_t(voxels.size.z() + 2));
  flood(voxels, field.data(), rows);
  const auto reached = std::count_if(field.begin(), field.end(), [](std::int32_t cell) { return (cell & kNoLabel) != kNoLabel; });
  return std::abs(double(reached) * std::pow(voxels.step, 3) / target.volume - 1) <= kSameVolume;
}

std::vector<std::shared_ptr<const Voxels>> coarse_grids(const Target& target, std::size_t bones, const std::shared_ptr<const Voxels>& fine) {
  std::vector<std::shared_ptr<const Voxels>> grids;
  const double step = std::max(fine->step, std::cbrt(target.volume / std::max(kLeastVoxels, kVoxelsABone * double(bones))));
  for (int k = 1; k <= kGrids; ++k) {
    Eigen::Vector3d shift;
    for (int d = 0; d < 3; ++d) shift[d] = k * kShifts[d] - std::floor(k * kShifts[d]);
    auto grid = std::make_shared<const Voxels>(target, step, shift, kFewVoxels);
    if (holds(*grid, target)) grids.push_back(std::move(grid));
  }
  if (grids.empty()) grids.push_back(fine);
  return grids;
}

}  // namespace

bool is_sound(const Embedding& embedding, double step) {
  return embedding.deepest_protrusion < step && embedding.deepest_collision < kTouching * step;
}

Search::Search(const Character& character, const Target& target, const EmbeddingOptions& options, bool symmetric,
               const Progress& progress, const Hear& best_so_far)
    : character_(character), options_(options), symmetric_(symmetric), progress_(progress), best_so_far_(best_so_far),
      unknowns_(character, target, options, symmetric), painted_(options.painted), start_head_(start_head(target)),
      fine_(std::make_shared<const Voxels>(target)), grids_(coarse_grids(target, character.bones.size(), fine_)), difference_(character, target, *fine_), target_step_(target.distance.shape.step),
      workers_([&character, &target, &options, this] {
        std::vector<Evaluator> coarse;
        for (const auto& grid : grids_) coarse.emplace_back(character, target, grid, options.weights);
        return Worker{Evaluator(character, target, fine_, options.weights), std::move(coarse),
                      Descent(character, target, unknowns_, options.weights, kFeasibility, wishes()),
                      {Eigen::Isometry3d::Identity(), Eigen::VectorXd::Zero(character.angle_count)},
                      Morphology::Ones(Eigen::Index(character.bones.size()))};
      }),
      arena_(options.threads == 0 ? tbb::task_arena::automatic : options.threads) {
  if (unknowns_.count() == 0) throw InvalidInput("there is nothing to search: a bone is pinned, every joint is locked and every proportion kept; free one of them");
}

double Search::pin_error(const Skeleton& skeleton) const {
  double error = 0;
  for (std::size_t k = 1; k < options_.pinned.size(); ++k) {  // the first is held exactly, by the unknowns
    const auto [move, turn] = misplacement(options_.pinned[k], skeleton);
    error += move.norm() + turn.norm();
  }
  return error;
}

/// What a search asks of poses that the objective does not know of.
std::vector<Descent::Wish> Search::wishes() const {
  std::vector<Descent::Wish> wishes;
  for (std::size_t k = 1; k < options_.pinned.size(); ++k)
    for (int d = 0; d < 3; ++d) {
      wishes.push_back({[this, k, d](const Skeleton& skeleton) { return misplacement(options_.pinned[k], skeleton).first[d]; }, kPinned});
      wishes.push_back({[this, k, d](const Skeleton& skeleton) { return misplacement(options_.pinned[k], skeleton).second[d]; }, kPinned});
    }
  if (!options_.painted.empty()) wishes.push_back({[this](const Skeleton& skeleton) { return painted_(skeleton); }, kPainted});
  return wishes;
}

double Search::value_of(Worker& worker, const Candidate& candidate, int grid) const {
  unknowns_.read(candidate.y, candidate.start, worker.pose, worker.morphology);
  Evaluator& evaluator = evaluator_of(worker, grid);
  return value_of(evaluator(worker.pose, worker.morphology), evaluator.skeleton());
}

double Search::value_of(const Evaluation& evaluation, const Skeleton& skeleton) const {
  return evaluation.terms.total + kFeasibility * evaluation.violation + kPinned * pin_error(skeleton) + kPainted * painted_(skeleton);
}

void Search::evaluate(std::vector<Candidate>& candidates, int grid) {
  for_each_in_pieces(candidates, 1, false, [&](std::size_t k) { candidates[k].value = value_of(workers_.local(), candidates[k], grid); });
}

Embedding Search::embedding_of(const Eigen::VectorXd& y, const StartPlace& start) {
  Worker& worker = workers_.local();
  unknowns_.read(y, start, worker.pose, worker.morphology);
  const Evaluation result = worker.fine(worker.pose, worker.morphology);
  const double value = value_of(result, worker.fine.skeleton());
  return {worker.pose, worker.morphology, result.terms, value, symmetric_, result.deepest_protrusion, result.deepest_collision, evaluations_,
          painted_(worker.fine.skeleton())};
}

void Search::take(const Eigen::VectorXd& y, const StartPlace& start, double value) {
  if (!(value < best_value_)) return;
  best_value_ = value;
  if (best_so_far_) best_so_far_(embedding_of(y, start));
}

/// A pose that is better than all before comes too seldom to be watched.
void Search::show(const Eigen::VectorXd& y, const StartPlace& start) {
  const auto now = std::chrono::steady_clock::now();
  if (!options_.trying || now - shown_ < kShown) return;
  shown_ = now;
  options_.trying(embedding_of(y, start));
}

void Search::watch(std::span<const Candidate> candidates) {
  const Candidate& best = *std::min_element(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.value < b.value; });
  take(best.y, best.start, best.value);
  show(best.y, best.start);
}

void Search::read_partition(Run& run) {
  Worker& worker = workers_.local();
  unknowns_.read(run.best, run.start, worker.pose, worker.morphology);
  worker.fine(worker.pose, worker.morphology);
  worker.fine.read_partition(run.partition);
}

bool Search::differs(const Run& run, const std::vector<Run>& from) const {
  return std::all_of(from.begin(), from.end(),
                     [&](const Run& other) { return difference_(run.partition, other.partition) >= least_difference_; });
}

/// Takes the best out of `runs`, but of those alike only the best one.
std::vector<Search::Run> Search::best_that_differ(std::vector<Run>& runs, std::size_t count) {
  std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.best_value < b.best_value; });
  std::vector<Run> kept;
  for (Run& run : runs) {
    if (kept.size() == count) break;
    read_partition(run);
    if (differs(run, kept)) kept.push_back(std::move(run));
  }
  return kept;
}

/// Runs a few candidates to their end; each that has become a solution unlike all before is told.
void Search::finish(std::vector<Run>& finalists, std::vector<Run>& ended, const Hear& found) {
  advance(finalists, options_.evaluations);
  for (Run& run : finalists) {
    read_partition(run);
    if (found && differs(run, ended)) found(embedding_of(run.best, run.start));
    ended.push_back(std::move(run));
  }
}

std::vector<Embedding> Search::wide(int count, double least_difference, const Hear& found) {
  least_difference_ = least_difference;
  const long bound = options_.evaluations;
  const long brief = std::min(long(breadth() * double(kShortRun)), bound);
  const auto together = std::size_t(options_.runs), finalists = std::max({together, std::size_t(count) * 3 / 2, kFewest});
  const std::size_t starts = finalists * std::size_t(options_.starts), kept = kCandidates * finalists;
  planned_ = planned_for_beginnings(starts, kept) + long(kept) * brief + long(std::max(together, std::size_t(count))) * (bound - brief);
  const std::vector<Candidate> candidates = beginnings(starts, kept);
  best_value_ = std::numeric_limits<double>::infinity();  // values so far do not compare with those to come
  std::vector<Run> runs = started(candidates);
  advance(runs, brief);
  std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.best_value < b.best_value; });
  std::vector<Run> ended;
  std::vector<Embedding> solutions;
  for (std::size_t tried = 0; tried < runs.size();) {
    std::vector<Run> batch;
    for (; tried < runs.size() && batch.size() < together; ++tried) {
      read_partition(runs[tried]);
      if (differs(runs[tried], ended) && differs(runs[tried], batch)) batch.push_back(std::move(runs[tried]));
    }
    finish(batch, ended, found);
    settle(ended);
    // A pose that is not sound is no solution: as long as there are others, they have their turn; but symmetry that nobody demanded gives way.
    const bool is_solution = sound(ended.front());
    if (is_solution ? ended.size() >= std::size_t(count) : symmetric_ && options_.symmetry == Symmetry::kAuto) break;
  }
  for (std::size_t k = 0; k < std::min(ended.size(), std::size_t(count)); ++k) solutions.push_back(embedding_of(ended[k].best, ended[k].start));
  return solutions;
}

bool Search::sound(const Run& run) { return is_sound(embedding_of(run.best, run.start), target_step_); }

/// Best first, and of those that came to be alike only the best one.
void Search::settle(std::vector<Run>& ended) { ended = best_that_differ(ended, ended.size()); }

Embedding Search::careful(const Embedding& from) {
  planned_ = options_.evaluations;
  StartPlace start;
  const Eigen::VectorXd y = unknowns_.write(from.pose, from.morphology, start);
  std::vector<Candidate> given{{y, start}};
  evaluate(given, kFine);
  watch(given);
  std::vector<Run> runs{run_from(given[0], kCarefulSigma, CmaEs::default_population(unknowns_.count()), 1)};
  runs[0].used = 1;
  advance(runs, options_.evaluations);
  return embedding_of(runs[0].best, runs[0].start);
}

}  // namespace transformables
