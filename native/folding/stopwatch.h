// How long a search has worked.
#pragma once

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <ctime>

namespace transformables::folding {

/// The lesser of wall time and of processor time a core: a machine that is busy with other things does not make a search end sooner, and
/// so end otherwise.
class Stopwatch {
 public:
  /// @param threads  0: all cores
  explicit Stopwatch(int threads) : cores_(threads > 0 ? threads : tbb::this_task_arena::max_concurrency()) {}

  double seconds() const {
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
    return std::min(wall, double(std::clock() - processor_) / CLOCKS_PER_SEC / cores_);
  }

 private:
  int cores_;
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t processor_ = std::clock();
};

}  // namespace transformables::folding
