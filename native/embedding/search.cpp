#include "embedding/search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace transformables {
namespace {

// The search ranks by the total plus this times all depths of collision and protrusion. The squares of Eqs. 4
// and 5 are flat near zero and lose against L_skin, whose sum is in the hundreds: they would leave a design infeasible.
constexpr double kFeasibility = 1e4;
constexpr double kPinned = 1e5;          // so that a bone is rather out of the target than off its pin
constexpr double kPainted = 6e3;         // soft: a voxel that a painted region is missed by costs less than a voxel of a collision
constexpr double kPinnedTurn = 0.1;      // a pinned bone's turn by a radian counts as much as this move
// With many minima about, a larger population ends in better ones, but converges later: it is as large as the bound for a run
// allows, up to twice the usual. The usual one has about converged after so many evaluations an unknown.
constexpr double kEvaluationsAnUnknown = 250, kLargestPopulation = 2;
// Searches with a long step find other minima than those with a short one, which sooner are good; a coin decides for each start.
constexpr double kWideSigma = 0.2, kNarrowSigma = 0.07, kCarefulSigma = 0.08, kRestartSigma = 0.15;
constexpr std::chrono::milliseconds kShown{50};
constexpr std::ptrdiff_t kTogether = 8;  // runs: few, so that there is soon something to show
constexpr int kRestarts = 2;             // of a run that converged before its bound, with twice the population each

// Successive halving: of the starts a third goes on after the short run, an eighth after the middle one. A larger population has
// longer runs, and fewer of them.
constexpr std::size_t kPromising = 3, kGood = 8;
constexpr std::size_t kPatience = 2;     // times the finalists: so many candidates are run to their end for solutions that differ
constexpr int kPosesTried = 16;          // random poses for each start, before any search
constexpr long kShortRun = 300, kMiddleRun = 900, kLongRun = 2000;
constexpr int kRoughVoxels = 32;         // along the target's longest side, for the first rounds
// In the first rounds a pose that sticks out or collides by more than this is not flooded, and so is looked at in a sixth of the time. Most of
// what those rounds try is so far out; what its other terms would be hardly changes its rank. Instead of them it has kUnseen.
constexpr double kFarOut = 500, kUnseen = 250;
constexpr double kTouching = 0.1;        // steps: what is less deep in one another does not count as a collision
constexpr std::size_t kRoughFew = 3000;  // voxels: with more, one in five is a boundary sample

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

/// A coarser grid for the first look, or the fine one where a coarser would lose too much of the target.
std::shared_ptr<const Voxels> coarser(const Target& target, const std::shared_ptr<const Voxels>& fine) {
  const int stride = Voxels::stride_of(target, kRoughVoxels);
  const auto kept = std::count_if(target.inside.begin(), target.inside.end(), [&](std::size_t i) {
    const Eigen::Vector3i c = target.distance.shape.cell(i);
    return c.x() % stride == 0 && c.y() % stride == 0 && c.z() % stride == 0;
  });
  const double share = double(kept) * stride * stride * stride / double(target.inside.size());
  if (stride == fine->stride || kept < 1000 || std::abs(share - 1) > 0.1) return fine;
  return std::make_shared<const Voxels>(target, kRoughVoxels, kRoughFew);
}

}  // namespace

bool is_sound(const Embedding& embedding, double step) {
  return embedding.deepest_protrusion < step && embedding.deepest_collision < kTouching * step;
}

Search::Search(const Character& character, const Target& target, const EmbeddingOptions& options, bool symmetric,
               const Progress& progress, const Hear& best_so_far)
    : options_(options), symmetric_(symmetric), progress_(progress), best_so_far_(best_so_far),
      unknowns_(character, target, options, symmetric), painted_(options.painted), start_head_(start_head(target)),
      fine_(std::make_shared<const Voxels>(target)), coarse_(coarser(target, fine_)), difference_(character, target, *fine_), target_step_(target.distance.shape.step),
      workers_([&character, &target, &options, this] {
        return Worker{Evaluator(character, target, fine_, options.weights), Evaluator(character, target, coarse_, options.weights),
                      {Eigen::Isometry3d::Identity(), Eigen::VectorXd::Zero(character.angle_count)},
                      Morphology::Ones(Eigen::Index(character.bones.size()))};
      }),
      arena_(options.threads == 0 ? tbb::task_arena::automatic : options.threads) {}

double Search::pin_error(const Skeleton& skeleton) const {
  double error = 0;
  for (std::size_t k = 1; k < options_.pinned.size(); ++k) {  // the first is held exactly, by the unknowns
    const PinnedBone& pin = options_.pinned[k];
    const auto bone = std::size_t(pin.bone);
    const double turn = Eigen::AngleAxisd(Eigen::Matrix3d(skeleton.rotations[bone] * pin.frame.linear().transpose())).angle();
    error += (skeleton.heads[bone] - pin.frame.translation()).norm() + kPinnedTurn * turn;
  }
  return error;
}

double Search::value_of(Worker& worker, const Job& job) const {
  unknowns_.read(job.y, job.start, worker.pose, worker.morphology);
  Evaluator& evaluator = rough_ ? worker.coarse : worker.fine;
  Evaluation evaluation = evaluator.without_flood(worker.pose, worker.morphology);
  if (rough_ && kFeasibility * evaluation.violation > kFarOut)
    evaluation.terms.total = kUnseen;
  else
    evaluator.add_flood(worker.pose, evaluation);
  return value_of(evaluation, evaluator.skeleton());
}

double Search::value_of(const Evaluation& evaluation, const Skeleton& skeleton) const {
  return evaluation.terms.total + kFeasibility * evaluation.violation + kPinned * pin_error(skeleton) + kPainted * painted_(skeleton);
}

void Search::evaluate(std::vector<Job>& jobs) {
  // In pieces, so that a stop is heard soon; each value goes to its own place, whichever thread has it.
  const std::size_t piece = 8 * std::size_t(arena_.max_concurrency());
  for (std::size_t begin = 0; begin < jobs.size(); begin += piece) {
    arena_.execute([&] {
      tbb::parallel_for(begin, std::min(jobs.size(), begin + piece), [&](std::size_t k) { jobs[k].value = value_of(workers_.local(), jobs[k]); });
    });
    evaluations_ += long(std::min(jobs.size(), begin + piece) - begin);
    tick();
  }
}

Embedding Search::embedding_of(const Eigen::VectorXd& y, const StartPlace& start) {
  Worker& worker = workers_.local();
  unknowns_.read(y, start, worker.pose, worker.morphology);
  Evaluator& evaluator = rough_ ? worker.coarse : worker.fine;
  const Evaluation result = evaluator(worker.pose, worker.morphology);
  const double value = value_of(result, evaluator.skeleton());
  return {worker.pose, worker.morphology, result.terms, value, symmetric_, result.deepest_protrusion, result.deepest_collision, evaluations_,
          painted_(evaluator.skeleton())};
}

CmaEs Search::optimiser(const Eigen::VectorXd& mean, double sigma, int population, std::uint64_t stream) const {
  CmaEs::Options options;
  options.population = population;
  options.seed = options_.seed * 1000003 + stream;
  options.diagonal = wide_;  // as long as runs are, they can't learn more
  options.tol_fun = 1e-3;
  options.tol_x = 1e-3;
  return CmaEs(mean, sigma, options);
}

/// The most promising of random poses, no search yet; start rotations take turns.
std::vector<Search::Job> Search::screened(std::size_t count) {
  const std::vector<Eigen::Matrix3d> rotations = unknowns_.start_rotations();
  Random random(options_.seed);
  const auto tries = std::size_t(kPosesTried);
  std::vector<Job> jobs;
  for (std::size_t k = 0; k < count * tries; ++k) {
    Job job{Eigen::VectorXd::Zero(unknowns_.count()), {rotations[k / tries % rotations.size()], start_head_}};
    for (Eigen::Index i = unknowns_.root_count(); i < job.y.size(); ++i) job.y[i] = random.uniform(-0.6, 0.6);
    jobs.push_back(std::move(job));
  }
  evaluate(jobs);
  std::vector<Job> best;
  for (auto begin = jobs.begin(); begin != jobs.end(); begin += kPosesTried)
    best.push_back(*std::min_element(begin, begin + kPosesTried, [](const Job& a, const Job& b) { return a.value < b.value; }));
  return best;
}

/// Times the usual population.
double Search::breadth() const {
  return std::clamp(double(options_.evaluations) / (kEvaluationsAnUnknown * unknowns_.count()), 1.0, kLargestPopulation);
}

std::vector<Search::Run> Search::started(std::size_t count) {
  const int population = int(breadth() * CmaEs::default_population(unknowns_.count()));
  Random random(~options_.seed);
  std::vector<Run> runs;
  for (Job& job : screened(count)) {
    const std::uint64_t stream = runs.size() + 1;
    const double sigma = random.uniform() < 0.5 ? kWideSigma : kNarrowSigma;
    runs.push_back({optimiser(job.y, sigma, population, stream), job.start, stream, 0, 0, job.y, job.value, {}});
  }
  return runs;
}

void Search::take(const Run& run) {
  if (!(run.best_value < best_value_)) return;
  best_value_ = run.best_value;
  if (best_so_far_) best_so_far_(embedding_of(run.best, run.start));
}

void Search::restart(Run& run) {
  ++run.restarts;
  run.cma = optimiser(run.best, kRestartSigma, 2 * run.cma.population(), 7919 * std::uint64_t(run.restarts) + run.stream);
}

void Search::advance_once(std::vector<Run*>& active) {
  std::vector<Job> jobs;
  for (Run* run : active) {
    const Eigen::MatrixXd& samples = run->cma.ask();
    for (Eigen::Index k = 0; k < samples.cols(); ++k) jobs.push_back({samples.col(k), run->start});
  }
  evaluate(jobs);
  auto job = jobs.begin();
  for (Run* run : active) {
    Eigen::VectorXd values(run->cma.population());
    for (double& value : values) {
      value = job->value;
      if (value < run->best_value) {
        run->best_value = value;
        run->best = job->y;
      }
      ++job;
    }
    run->cma.tell(values);
    run->used += run->cma.population();
    take(*run);
  }
}

/// Where the leading one of these runs is: a pose that is better than all before comes too seldom to be watched.
void Search::show(const std::vector<Run*>& active) {
  const auto now = std::chrono::steady_clock::now();
  if (!options_.trying || now - shown_ < kShown) return;
  shown_ = now;
  const Run& leader = **std::min_element(active.begin(), active.end(), [](const Run* a, const Run* b) { return a->best_value < b->best_value; });
  options_.trying(embedding_of(leader.cma.mean(), leader.start));
}

/// All runs together, generation by generation, until each has converged or used `bound` evaluations.
void Search::advance(std::vector<Run>& runs, long bound) {
  for (;;) {
    std::vector<Run*> active;
    for (Run& run : runs) {
      if (run.used > 0 && run.used + run.cma.population() > bound) continue;
      if (run.cma.stop() != CmaEs::Stop::kNone) {
        if (run.restarts == kRestarts || run.used + 4 * run.cma.population() > bound) continue;
        restart(run);
      }
      active.push_back(&run);
    }
    if (active.empty()) return;
    for (auto begin = active.begin(); begin != active.end();) {
      const auto end = begin + std::min<std::ptrdiff_t>(kTogether, active.end() - begin);
      std::vector<Run*> some(begin, end);
      advance_once(some);
      show(some);
      begin = end;
    }
  }
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

/// From here on evaluations are on the fine grid: values so far do not compare with those.
void Search::go_on_finely(std::vector<Run>& runs) {
  rough_ = false;
  best_value_ = std::numeric_limits<double>::infinity();
  std::vector<Job> jobs;
  for (const Run& run : runs) jobs.push_back({run.best, run.start});
  evaluate(jobs);
  for (std::size_t k = 0; k < runs.size(); ++k) runs[k].best_value = jobs[k].value;
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
  wide_ = true;
  const long bound = options_.evaluations;
  const auto within = [&](long length) { return std::min(long(breadth() * double(length)), bound); };
  const auto together = std::size_t(options_.runs), finalists = std::max(together, std::size_t(count) * 3 / 2);
  const auto starts = finalists * std::size_t(std::ceil(options_.starts / breadth()));
  const auto promising = std::max(finalists, starts / kPromising), good = std::max(finalists, starts / kGood);
  const long brief = within(kShortRun), middle = within(kMiddleRun), late = within(kLongRun);
  planned_ = long(starts) * (kPosesTried + brief) + long(promising) * (middle - brief) + long(good) * (late - middle) +
             long(finalists) * (bound - late);
  rough_ = true;
  std::vector<Run> runs = started(starts);
  advance(runs, brief);
  runs = best_that_differ(runs, promising);
  advance(runs, middle);
  runs = best_that_differ(runs, good);
  advance(runs, late);
  go_on_finely(runs);
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
    // A pose that is not sound is no solution: as long as there are others, they have their turn. Where runs end alike again and again, fewer solutions do,
    // and where symmetry was nobody's wish, the search without it has better chances than what is left here.
    const bool enough = ended.size() >= std::size_t(count), tired = tried >= kPatience * finalists;
    if ((enough || tired) && sound(ended.front())) break;
    if (tired && symmetric_ && options_.symmetry != Symmetry::kOn) break;
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
  std::vector<Job> given{{y, start}};
  evaluate(given);
  std::vector<Run> runs;
  runs.push_back({optimiser(y, kCarefulSigma, 0, 1), start, 1, 1, 0, y, given[0].value, {}});
  take(runs[0]);
  advance(runs, options_.evaluations);
  return embedding_of(runs[0].best, runs[0].start);
}

}  // namespace transformables
