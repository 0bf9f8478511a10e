#include "embedding/embedding.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "embedding/cma_es.h"
#include "embedding/evaluator.h"
#include "embedding/unknowns.h"

namespace transformables {
namespace {

// The search ranks by the total plus this times all depths of collision and protrusion. The squares of Eqs. 4 and 5
// are flat near zero and lose against L_skin, whose sum is in the hundreds: they would leave a design infeasible.
constexpr double kFeasibility = 1e4;
constexpr double kWideSigma = 0.35, kCarefulSigma = 0.08, kRestartSigma = 0.15;
constexpr int kPosesTried = 6;           // for each start rotation, before any search
constexpr int kShortRun = 600;           // evaluations of a run before the best few go on
constexpr int kRestarts = 2;             // of a run that converged before its bound, with twice the population each

void check(const Character& character, const Target& target, const EmbeddingOptions& options) {
  if (character.bones.empty() || character.bones.size() > std::size_t(kMostBones))
    throw InvalidInput("the character has " + std::to_string(character.bones.size()) + " rigid bones: 1 to " +
                       std::to_string(kMostBones) + " can be embedded; simplify it");
  if (target.inside.empty()) throw InvalidInput("the target has no voxels inside: raise the resolution");
  if (options.runs < 1 || options.runs > 1000) throw InvalidInput("runs must lie between 1 and 1000");
  if (options.evaluations < 1) throw InvalidInput("evaluations must be at least 1");
  if (options.threads < 0 || options.threads > 1024) throw InvalidInput("threads must lie between 0 (all cores) and 1024");
  if (!(options.least_scale > 0) || !(options.least_scale <= 1) || !(options.largest_scale >= 1) || !(options.largest_scale <= 100))
    throw InvalidInput("bounds of the bones' scales must be: 0 < least <= 1 <= largest <= 100");
  const ObjectiveWeights& w = options.weights;
  for (const double weight : {w.compact, w.skin, w.skeleton, w.protrude, w.limits, w.morphology})
    if (!(weight >= 0) || !std::isfinite(weight)) throw InvalidInput("weights of the objective must be finite and not negative");
  if (options.symmetry != Symmetry::kOn) return;
  if (!character.mirrored) throw InvalidInput("symmetry is on, but the character is not its own mirror image: turn symmetry off");
  if (!target.mirror_axis) throw InvalidInput("symmetry is on, but the target is not its own mirror image: turn symmetry off");
}

void check_start(const Character& character, const Embedding& start) {
  if (start.pose.angles.size() != character.angle_count || start.morphology.size() != Eigen::Index(character.bones.size()))
    throw InvalidInput("the start pose is of another character: its numbers of angles or bones differ");
  if (!start.pose.angles.allFinite() || !start.pose.root.matrix().allFinite() || !start.morphology.allFinite() ||
      !(start.morphology.minCoeff() > 0))
    throw InvalidInput("the start pose must hold finite numbers, and scales above 0");
}

bool is_symmetric(const Character& character, const Target& target, const EmbeddingOptions& options,
                  const std::optional<Embedding>& start) {
  if (options.symmetry == Symmetry::kOff || !character.mirrored || !target.mirror_axis) return false;
  return options.symmetry == Symmetry::kOn || !start || start->symmetric;
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

struct Run {
  CmaEs cma;
  StartPlace start;
  long used = 0;             ///< evaluations of this run and those before its restarts
  int restarts = 0;
  Eigen::VectorXd best = {};
  double best_value = std::numeric_limits<double>::infinity();
};

/// A place to evaluate; the value is put there.
struct Job {
  Eigen::VectorXd y;
  StartPlace start;
  double value = 0;
};

class Search {
 public:
  Search(const Character& character, const Target& target, const EmbeddingOptions& options, bool symmetric,
         const Progress& progress, const std::function<void(const Embedding&)>& best_so_far)
      : options_(options), symmetric_(symmetric), progress_(progress), best_so_far_(best_so_far),
        unknowns_(character, target, {symmetric, options.proportions, options.least_scale, options.largest_scale}),
        start_head_(start_head(target)),
        workers_([&character, &target, &options, voxels = std::make_shared<const Voxels>(target)] {
          return Worker{Evaluator(character, target, voxels, options.weights),
                        {Eigen::Isometry3d::Identity(), Eigen::VectorXd::Zero(character.angle_count)},
                        Morphology::Ones(Eigen::Index(character.bones.size()))};
        }),
        arena_(options.threads == 0 ? tbb::task_arena::automatic : options.threads) {}

  Embedding wide();
  Embedding careful(const Embedding& from);

 private:
  struct Worker {
    Evaluator evaluator;
    Pose pose;
    Morphology morphology;
  };
  std::vector<Job> screened();
  void advance(std::vector<Run>& runs, long bound);
  void advance_once(std::vector<Run*>& active);
  void restart(Run& run);
  void evaluate(std::vector<Job>& jobs);
  void take(const Run& run);
  Embedding embedding_of(const Eigen::VectorXd& y, const StartPlace& start);
  CmaEs optimiser(const Eigen::VectorXd& mean, double sigma, int population, std::uint64_t stream) const;
  void tick() { progress_(std::min(1.0, double(evaluations_) / double(planned_)), "embedding"); }

  const EmbeddingOptions& options_;
  bool symmetric_;
  const Progress& progress_;
  const std::function<void(const Embedding&)>& best_so_far_;
  Unknowns unknowns_;
  Eigen::Vector3d start_head_;
  tbb::enumerable_thread_specific<Worker> workers_;
  tbb::task_arena arena_;
  long evaluations_ = 0, planned_ = 1;
  double best_value_ = std::numeric_limits<double>::infinity();
  Eigen::VectorXd best_;
  StartPlace best_start_;
};

void Search::evaluate(std::vector<Job>& jobs) {
  // In pieces, so that a stop is heard soon; each value goes to its own place, whichever thread has it.
  const std::size_t piece = 8 * std::size_t(arena_.max_concurrency());
  for (std::size_t begin = 0; begin < jobs.size(); begin += piece) {
    arena_.execute([&] {
      tbb::parallel_for(begin, std::min(jobs.size(), begin + piece), [&](std::size_t k) {
        Worker& worker = workers_.local();
        unknowns_.read(jobs[k].y, jobs[k].start, worker.pose, worker.morphology);
        const Evaluation result = worker.evaluator(worker.pose, worker.morphology);
        jobs[k].value = result.terms.total + kFeasibility * result.violation;
      });
    });
    evaluations_ += long(std::min(jobs.size(), begin + piece) - begin);
    tick();
  }
}

Embedding Search::embedding_of(const Eigen::VectorXd& y, const StartPlace& start) {
  Worker& worker = workers_.local();
  unknowns_.read(y, start, worker.pose, worker.morphology);
  const Evaluation result = worker.evaluator(worker.pose, worker.morphology);
  return {worker.pose, worker.morphology, result.terms, symmetric_, result.deepest_protrusion, result.deepest_collision, evaluations_};
}

CmaEs Search::optimiser(const Eigen::VectorXd& mean, double sigma, int population, std::uint64_t stream) const {
  CmaEs::Options options;
  options.population = population;
  options.seed = options_.seed * 1000003 + stream;
  options.tol_fun = 1e-3;
  options.tol_x = 1e-3;
  return CmaEs(mean, sigma, options);
}

/// The most promising start of each rotation: random poses, no search yet; best first.
std::vector<Job> Search::screened() {
  const std::vector<Eigen::Matrix3d> rotations = unknowns_.start_rotations();
  Random random(options_.seed);
  std::vector<Job> jobs;
  for (const Eigen::Matrix3d& rotation : rotations)
    for (int k = 0; k < kPosesTried; ++k) {
      Job job{Eigen::VectorXd::Zero(unknowns_.count()), {rotation, start_head_}};
      for (Eigen::Index i = unknowns_.root_count(); i < job.y.size(); ++i) job.y[i] = random.uniform(-0.6, 0.6);
      jobs.push_back(std::move(job));
    }
  evaluate(jobs);
  std::vector<Job> best;
  for (std::size_t r = 0; r < rotations.size(); ++r) {
    const auto begin = jobs.begin() + std::ptrdiff_t(r * kPosesTried);
    best.push_back(*std::min_element(begin, begin + kPosesTried, [](const Job& a, const Job& b) { return a.value < b.value; }));
  }
  std::stable_sort(best.begin(), best.end(), [](const Job& a, const Job& b) { return a.value < b.value; });
  return best;
}

void Search::take(const Run& run) {
  if (!(run.best_value < best_value_)) return;
  best_value_ = run.best_value;
  best_ = run.best;
  best_start_ = run.start;
  if (best_so_far_) best_so_far_(embedding_of(best_, best_start_));
}

void Search::restart(Run& run) {
  ++run.restarts;
  run.cma = optimiser(run.best, kRestartSigma, 2 * run.cma.population(), 7919 * std::uint64_t(run.restarts) + std::uint64_t(run.used));
}

void Search::advance_once(std::vector<Run*>& active) {
  std::vector<Job> jobs;
  for (Run* run : active) {
    const Eigen::MatrixXd& samples = run->cma.ask();
    for (Eigen::Index k = 0; k < samples.cols(); ++k) jobs.push_back({samples.col(k), run->start});
  }
  evaluate(jobs);
  std::size_t at = 0;
  for (Run* run : active) {
    Eigen::VectorXd values(run->cma.population());
    for (double& value : values) value = jobs[at++].value;
    run->cma.tell(values);
    run->used += run->cma.population();
    if (run->cma.best_value() < run->best_value) {
      run->best_value = run->cma.best_value();
      run->best = run->cma.best();
    }
    take(*run);
  }
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
    advance_once(active);
  }
}

/// From nothing: many short runs, of which the best go on.
Embedding Search::wide() {
  const auto starts = std::size_t(2 * options_.runs), finalists = std::size_t((options_.runs + 1) / 2);
  const long bound = options_.evaluations, brief = std::min<long>(kShortRun, bound);
  planned_ = long(24 * kPosesTried + starts * std::size_t(brief) + finalists * std::size_t(bound - brief));
  const std::vector<Job> begin = screened();
  std::vector<Run> runs;
  for (std::size_t k = 0; k < starts; ++k) {
    const Job& job = begin[k % begin.size()];
    runs.push_back({optimiser(job.y, kWideSigma, 0, k + 1), job.start});
  }
  advance(runs, brief);
  std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.best_value < b.best_value; });
  runs.erase(runs.begin() + std::ptrdiff_t(finalists), runs.end());
  advance(runs, bound);
  return embedding_of(best_, best_start_);
}

/// From a given pose: one run with a small step.
Embedding Search::careful(const Embedding& from) {
  planned_ = options_.evaluations;
  StartPlace start;
  const Eigen::VectorXd y = unknowns_.write(from.pose, from.morphology, start);
  std::vector<Job> given{{y, start}};
  evaluate(given);
  std::vector<Run> runs;
  runs.push_back({optimiser(y, kCarefulSigma, 0, 1), start, 1, 0, y, given[0].value});
  take(runs[0]);
  advance(runs, options_.evaluations);
  return embedding_of(best_, best_start_);
}

}  // namespace

Embedding embed(const Character& character, const Target& target, const EmbeddingOptions& options, const Progress& progress,
                const std::optional<Embedding>& start, const std::function<void(const Embedding&)>& best_so_far) {
  check(character, target, options);
  if (start) check_start(character, *start);
  Search search(character, target, options, is_symmetric(character, target, options, start), progress, best_so_far);
  return start ? search.careful(*start) : search.wide();
}

}  // namespace transformables
