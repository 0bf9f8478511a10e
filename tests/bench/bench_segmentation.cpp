// Growth of the skins: production (with all that `grow` does besides: tiling, smooth interfaces) on one thread, and the dense
// reference. BENCH_LARGE=1 adds production at 256 voxels.
#include <cstdlib>

#include "bench.h"
#include "reference/growth.h"

namespace transformables {
namespace {

void growth(benchmark::State& state, const Eigen::Vector3i& grid, bool production) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  const Embedding embedding = reference::folded(character, target);
  bench::describe(state, target, character);
  SegmentationOptions options;
  options.threads = 1;
  const bench::PeakMemory peak;
  for (auto _ : state) {
    if (production) benchmark::DoNotOptimize(grow(character, target, embedding, options, {}));
    else benchmark::DoNotOptimize(reference::grow(character, target, embedding, options));
  }
  state.counters["peak_MB"] = peak.megabytes();
}

void add(const Eigen::Vector3i& grid, bool production) {
  const std::string name = "growth/" + bench::name_of(grid) + (production ? "/production" : "/paper");
  benchmark::RegisterBenchmark(name.c_str(), [grid, production](benchmark::State& state) { growth(state, grid, production); })
      ->Unit(benchmark::kMillisecond)->Iterations(production && grid.maxCoeff() <= 64 ? 5 : 1);
}

}  // namespace
}  // namespace transformables

int main(int argc, char** argv) {
  using transformables::add;
  for (const Eigen::Vector3i& grid : {Eigen::Vector3i(23, 18, 50), {44, 54, 44}}) {
    add(grid, true);
    add(grid, false);
  }
  add({64, 64, 64}, true);
  add({128, 128, 128}, true);
  if (std::getenv("BENCH_LARGE")) add({256, 256, 256}, true);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
