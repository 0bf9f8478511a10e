// Runs of CMA-ES in a search: how they start, go on together, and restart.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "embedding/search.h"

namespace transformables {
namespace {

// With many minima about, a larger population ends in better ones, but converges later: it is as large as the bound for a run
// allows, up to twice the usual. The usual one has found most of what it will find after so many evaluations an unknown.
constexpr double kEvaluationsAnUnknown = 90, kLargestPopulation = 2;
constexpr double kWideSigma = 0.07, kRestartSigma = 0.15;
constexpr double kLeastCurvature = 0.1;  // of the mean: a run's first steps are longest along directions that the geometry hardly depends on
constexpr std::ptrdiff_t kTogether = 16; // evaluations a core, at least, that runs do together: few, so that there is soon something to show
constexpr long kLeastGenerations = 4;    // that a restart must have left
constexpr long kJudgedEvery = 4;         // generations
constexpr long kJudged = 2;              // poses of a run, each time

}  // namespace

CmaEs Search::optimiser(double sigma, int population, std::uint64_t stream) const {
  CmaEs::Options options;
  options.population = population;
  options.seed = options_.seed * 1000003 + stream;
  options.tol_fun = 1e-3;
  options.tol_x = 1e-3;
  return CmaEs(Eigen::VectorXd::Zero(unknowns_.count()), sigma, options);
}

/// Times the usual population.
double Search::breadth() const {
  return std::clamp(double(options_.evaluations) / (kEvaluationsAnUnknown * unknowns_.count()), 1.0, kLargestPopulation);
}

/// The candidates are evaluated once more, finely. A run's own unknowns are such that the pose's geometry (Descent) changes in all of them alike.
std::vector<Search::Run> Search::started(const std::vector<Candidate>& candidates) {
  const int population = int(breadth() * CmaEs::default_population(unknowns_.count()));
  std::vector<Run> runs;
  for (const Candidate& candidate : candidates) {
    Worker& worker = workers_.local();
    Candidate now = candidate;
    now.value = value_of(worker, now, kFine);
    worker.descent.look(worker.fine, now.y, now.start);
    runs.push_back(run_from(now, kWideSigma, population, runs.size() + 1));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(worker.descent.curvature());
    const Eigen::VectorXd curvatures = axes.eigenvalues().cwiseMax(0).array() + kLeastCurvature * axes.eigenvalues().mean() + std::numeric_limits<double>::min();
    Eigen::VectorXd lengths = curvatures.cwiseSqrt().cwiseInverse();
    lengths /= std::exp(lengths.array().log().mean());
    runs.back().basis = axes.eigenvectors() * lengths.asDiagonal();
    tick();
  }
  return runs;
}

Search::Run Search::run_from(const Candidate& candidate, double sigma, int population, std::uint64_t stream) const {
  const Eigen::Index n = unknowns_.count();
  Run run{optimiser(sigma, population, stream), candidate.start, candidate.y, Eigen::MatrixXd::Identity(n, n), stream, BipopRestarts(population, stream), 0, 0,
          candidate.y, candidate.value, {}};
  run.restarts.next();  // is this one
  return run;
}

/// A run that has converged goes on from its best, by BIPOP's rule.
void Search::restart_when_over(Run& run) const {
  if (run.cma.stop() == CmaEs::Stop::kNone && (run.limit == 0 || run.cma.evaluations() < run.limit)) return;
  run.restarts.finished(run.cma.evaluations());
  const BipopRestarts::Run next = run.restarts.next();
  run.origin = run.best;
  run.limit = next.evaluations;
  run.cma = optimiser(kRestartSigma * next.sigma_factor, next.population, 7919 * std::uint64_t(run.used) + run.stream);
}

/// A generation is seen on one coarse grid, the next on another: what ranks high must be good on all of them.
void Search::advance_once(std::vector<Run*>& active) {
  std::vector<Candidate> candidates, best_tried;
  for (Run* run : active) {
    const Eigen::MatrixXd& samples = run->cma.ask();
    for (Eigen::Index k = 0; k < samples.cols(); ++k) candidates.push_back({run->origin + run->basis * samples.col(k), run->start});
  }
  evaluate(candidates, active.front()->cma.generation() % int(grids_.size()));
  auto candidate = candidates.begin();
  for (Run* run : active) {
    const auto first = candidate;
    Eigen::VectorXd values(run->cma.population());
    for (double& value : values) value = (candidate++)->value;
    run->cma.tell(values);
    run->used += run->cma.population();
    best_tried.push_back(*std::min_element(first, candidate, [](const Candidate& a, const Candidate& b) { return a.value < b.value; }));
  }
  if (active.front()->cma.generation() % kJudgedEvery == 0) judge(active, best_tried);
}

/// On the fine grid: where each run stands, and the best that it has just tried.
void Search::judge(const std::vector<Run*>& active, const std::vector<Candidate>& best_tried) {
  std::vector<Candidate> judged = best_tried;
  for (const Run* run : active) judged.push_back({run->origin + run->basis * run->cma.mean(), run->start});
  evaluate(judged, kFine);
  for (std::size_t k = 0; k < judged.size(); ++k) {
    Run& run = *active[k % active.size()];
    ++run.used;
    if (judged[k].value >= run.best_value) continue;
    run.best_value = judged[k].value;
    run.best = judged[k].y;
    take(run.best, run.start, run.best_value);
  }
}

/// All runs together, generation by generation, until each has used `bound` evaluations, or has too few left for another restart.
void Search::advance(std::vector<Run>& runs, long bound) {
  for (;;) {
    std::vector<Run*> active;
    for (Run& run : runs) {
      restart_when_over(run);
      const long wanted = (run.cma.generation() == 0 ? kLeastGenerations : 1) * run.cma.population() + kJudged;
      if (run.used == 0 || run.used + wanted <= bound) active.push_back(&run);
    }
    if (active.empty()) return;
    for (auto begin = active.begin(); begin != active.end();) {
      const std::ptrdiff_t together = std::max(std::ptrdiff_t(1), kTogether * arena_.max_concurrency() / (*begin)->cma.population());
      const auto end = begin + std::min(together, active.end() - begin);
      std::vector<Run*> some(begin, end);
      advance_once(some);
      const Run& leader = **std::min_element(some.begin(), some.end(), [](const Run* a, const Run* b) { return a->best_value < b->best_value; });
      show(leader.origin + leader.basis * leader.cma.mean(), leader.start);
      begin = end;
    }
  }
}

}  // namespace transformables
