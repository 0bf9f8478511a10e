// What the benches share: grids by name, and the peak of memory.
#pragma once

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <Eigen/Core>
#include <fstream>
#include <string>

#include "reference/cases.h"

namespace transformables::bench {

inline std::string name_of(const Eigen::Vector3i& grid) {
  return std::to_string(grid.x()) + "x" + std::to_string(grid.y()) + "x" + std::to_string(grid.z());
}

/// Linux: the highest resident size since `reset`, in MB; 0 where it can't be known.
class PeakMemory {
 public:
  PeakMemory() {
    malloc_trim(0);  // what benches before this one have left
    std::ofstream("/proc/self/clear_refs") << "5";
  }
  double megabytes() const {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
      if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024;
    return 0;
  }
};

inline void describe(benchmark::State& state, const Target& target, const Character& character) {
  state.counters["inside"] = double(target.inside.size());
  state.counters["bones"] = double(character.bones.size());
}

}  // namespace transformables::bench
