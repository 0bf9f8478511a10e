// The order of unfolding: the paper's greedy one (production and to the letter, at the same cost and configurations; production at our
// cost), and plan and transfer in turns. One thread.
#include "bench.h"
#include "folding/folding.h"
#include "reference/folding.h"

namespace transformables {
namespace {

enum class Work { kGreedyPaper, kGreedyPaperCost, kGreedy, kFold };

void folding(benchmark::State& state, const Eigen::Vector3i& grid, Work work) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  const Embedding embedding = reference::folded(character, target);
  const Segmentation segmentation = grow(character, target, embedding, {}, {});
  bench::describe(state, target, character);
  FoldingOptions options;
  options.threads = 1;
  if (work == Work::kGreedyPaperCost) options.cost = MoveCost::kNetOverlap;
  FoldPath path;
  for (auto _ : state) {
    if (work == Work::kGreedyPaper) path = reference::FoldingOrder(segmentation, character, target, embedding, options).greedy();
    else if (work == Work::kFold) path = fold(segmentation, character, target, embedding, options, {}).path;
    else path = plan_greedy(segmentation, character, target, embedding, options, {});
    benchmark::DoNotOptimize(path);
  }
  // Fold's own parts are not those of the segmentation it was given.
  if (work != Work::kFold) path = measured(path, segmentation, character, target, embedding, options);
  state.counters["overlap_pct"] = 100 * path.overlap_volume / target.volume;
}

void add(const Eigen::Vector3i& grid) {
  const std::pair<const char*, Work> works[] = {
      {"greedy_letter", Work::kGreedyPaper}, {"greedy_paper_cost", Work::kGreedyPaperCost}, {"greedy", Work::kGreedy}, {"fold", Work::kFold}};
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
