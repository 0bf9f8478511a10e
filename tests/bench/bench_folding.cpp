// The order of unfolding: the paper's greedy one (production code, the paper's cost and ours), and plan and transfer in turns. One
// thread. A folding stage to the letter does not exist yet, so there is no ratio.
#include "bench.h"
#include "folding/folding.h"

namespace transformables {
namespace {

enum class Work { kGreedyPaperCost, kGreedy, kFold };

void folding(benchmark::State& state, const Eigen::Vector3i& grid, Work work) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  const Embedding embedding = reference::folded(character, target);
  const Segmentation segmentation = grow(character, target, embedding, {}, {});
  bench::describe(state, target, character);
  FoldingOptions options;
  options.threads = 1;
  if (work == Work::kGreedyPaperCost) options.cost = MoveCost::kNetOverlap;
  double overlap = 0;
  for (auto _ : state) {
    overlap = work == Work::kFold ? fold(segmentation, character, target, embedding, options, {}).path.overlap_volume
                                  : plan_greedy(segmentation, character, target, embedding, options, {}).overlap_volume;
    benchmark::DoNotOptimize(overlap);
  }
  state.counters["overlap_pct"] = 100 * overlap / target.volume;
}

void add(const Eigen::Vector3i& grid) {
  const std::pair<const char*, Work> works[] = {{"greedy_paper_cost", Work::kGreedyPaperCost}, {"greedy", Work::kGreedy}, {"fold", Work::kFold}};
  for (const auto& [name, work] : works)
    benchmark::RegisterBenchmark(("folding/" + bench::name_of(grid) + "/" + name).c_str(),
                                 [grid, work = work](benchmark::State& state) { folding(state, grid, work); })
        ->Unit(benchmark::kMillisecond)->Iterations(1);
}

}  // namespace
}  // namespace transformables

int main(int argc, char** argv) {
  transformables::add({23, 18, 50});
  transformables::add({44, 54, 44});
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
