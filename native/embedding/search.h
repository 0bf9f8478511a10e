// The search for embeddings: many starts go downhill, the best are changed limb by limb, and CMA-ES takes those that are good and different to
// their end.
#pragma once

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "common/progress.h"
#include "embedding/cma_es.h"
#include "embedding/descent.h"
#include "embedding/difference.h"
#include "embedding/embedding.h"
#include "embedding/evaluator.h"
#include "embedding/painted.h"
#include "embedding/restarts.h"
#include "embedding/unknowns.h"

namespace transformables {

/// Inside and free of collisions, as far as a voxel of the target can tell.
bool is_sound(const Embedding& embedding, double step);

/// One object a search. Its input is checked by the door (embedding.cpp).
class Search {
 public:
  using Hear = std::function<void(const Embedding&)>;

  Search(const Character& character, const Target& target, const EmbeddingOptions& options, bool symmetric, const Progress& progress,
         const Hear& best_so_far);

  /// From nothing: `count` solutions that differ by `least_difference` at least, best first; at least one.
  std::vector<Embedding> wide(int count, double least_difference, const Hear& found);
  /// From a given pose: one run with a small step.
  Embedding careful(const Embedding& from);

 private:
  static constexpr int kFine = -1;   ///< the grid that poses are judged on; others are places in `grids_`
  struct Worker {
    Evaluator fine;
    std::vector<Evaluator> coarse;  ///< on each of `grids_`
    Descent descent;
    Pose pose;
    Morphology morphology;
  };
  /// A place to evaluate; the value is put there.
  struct Candidate {
    Eigen::VectorXd y;
    StartPlace start;
    double value = 0;
  };
  /// CMA-ES in unknowns of its own, z: y = origin + basis * z.
  struct Run {
    CmaEs cma;
    StartPlace start;
    Eigen::VectorXd origin;
    Eigen::MatrixXd basis;
    std::uint64_t stream = 0;  ///< of its random numbers
    BipopRestarts restarts;
    long limit = 0;            ///< evaluations until the next restart; 0: none
    long used = 0;             ///< evaluations of this run and those before its restarts
    Eigen::VectorXd best = {};
    double best_value = std::numeric_limits<double>::infinity();
    Partition partition = {};  ///< of its best, when it was last asked for
  };

  // Where runs begin (beginnings.cpp).
  std::vector<Candidate> beginnings(std::size_t starts, std::size_t kept);
  static long planned_for_beginnings(std::size_t starts, std::size_t kept);
  std::vector<Candidate> screened(std::size_t count);
  double glance(Worker& worker, const Candidate& candidate) const;
  void descend(std::vector<Candidate>& candidates, int steps);
  void descend(Candidate& candidate, int steps);
  void hop(std::vector<Candidate>& candidates);
  void change(Candidate& candidate, const std::vector<Candidate>& all, Random& random) const;
  bool is_below(int bone, int ancestor) const;

  // The runs (runs.cpp).
  double breadth() const;
  std::vector<Run> started(const std::vector<Candidate>& candidates);
  Run run_from(const Candidate& candidate, double sigma, int population, std::uint64_t stream) const;
  CmaEs optimiser(double sigma, int population, std::uint64_t stream) const;
  void advance(std::vector<Run>& runs, long bound);
  void advance_once(std::vector<Run*>& active);
  void judge(const std::vector<Run*>& active, const std::vector<Candidate>& best_tried);
  void restart_when_over(Run& run) const;

  void watch(std::span<const Candidate> candidates);
  void show(const Eigen::VectorXd& y, const StartPlace& start);
  void evaluate(std::vector<Candidate>& candidates, int grid);
  /// Calls f(k) for each candidate k on all cores, in pieces, so that a stop is heard soon. When watched, the best of each piece is shown.
  template <class F>
  void for_each_in_pieces(std::vector<Candidate>& candidates, long evaluations_each, bool watched, const F& f);
  double value_of(Worker& worker, const Candidate& candidate, int grid) const;
  static Evaluator& evaluator_of(Worker& worker, int grid) { return grid == kFine ? worker.fine : worker.coarse[std::size_t(grid)]; }
  double pin_error(const Skeleton& skeleton) const;
  std::vector<Descent::Wish> wishes() const;
  double value_of(const Evaluation& evaluation, const Skeleton& skeleton) const;
  void take(const Eigen::VectorXd& y, const StartPlace& start, double value);
  void read_partition(Run& run);
  bool differs(const Run& run, const std::vector<Run>& from) const;
  std::vector<Run> best_that_differ(std::vector<Run>& runs, std::size_t count);
  void finish(std::vector<Run>& finalists, std::vector<Run>& ended, const Hear& found);
  void settle(std::vector<Run>& ended);
  bool sound(const Run& run);
  Embedding embedding_of(const Eigen::VectorXd& y, const StartPlace& start);
  void tick() { progress_(std::min(1.0, double(evaluations_) / double(planned_)), "embedding"); }

  const Character& character_;
  const EmbeddingOptions& options_;
  bool symmetric_;
  const Progress& progress_;
  const Hear& best_so_far_;
  Unknowns unknowns_;
  PaintedTerm painted_;
  Eigen::Vector3d start_head_;
  std::shared_ptr<const Voxels> fine_;
  std::vector<std::shared_ptr<const Voxels>> grids_;  ///< coarse ones, each shifted otherwise; at least one
  PartitionDifference difference_;
  double target_step_;
  double least_difference_ = 0;
  tbb::enumerable_thread_specific<Worker> workers_;
  tbb::task_arena arena_;
  long evaluations_ = 0, planned_ = 1;
  std::chrono::steady_clock::time_point shown_{};
  double best_value_ = std::numeric_limits<double>::infinity();
};

template <class F>
void Search::for_each_in_pieces(std::vector<Candidate>& candidates, long evaluations_each, bool watched, const F& f) {
  const auto a_core = std::size_t(std::clamp(16 / evaluations_each, 1L, 8L));  // an evaluation takes a millisecond or two
  const std::size_t piece = a_core * std::size_t(arena_.max_concurrency());
  for (std::size_t begin = 0; begin < candidates.size(); begin += piece) {
    const std::size_t end = std::min(candidates.size(), begin + piece);
    arena_.execute([&] { tbb::parallel_for(begin, end, f); });
    evaluations_ += long(end - begin) * evaluations_each;
    if (watched) watch(std::span(candidates).subspan(begin, end - begin));
    tick();
  }
}

}  // namespace transformables
