// One evaluation of the embedding's objective: production, and the reference in two forms: the paper's flood by fronts, and a flood with
// production's own distances (Dijkstra). One thread.
#include "bench.h"
#include "embedding/evaluator.h"
#include "reference/objective.h"

namespace transformables {
namespace {

enum class Code { kProduction, kProductionEveryVoxel, kPaper, kSameDistances };

void evaluation(benchmark::State& state, const Eigen::Vector3i& grid, Code code) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  Random random(1);
  std::vector<Pose> poses;
  for (int k = 0; k < 16; ++k) poses.push_back(reference::random_pose(character, random, 0.03));
  const Morphology morphology = Morphology::Ones(Eigen::Index(character.bones.size()));
  bench::describe(state, target, character);
  std::size_t k = 0;
  const auto run = [&](auto& objective) {
    for (auto _ : state) benchmark::DoNotOptimize(objective(poses[k++ % poses.size()], morphology));
  };
  if (code == Code::kProduction || code == Code::kProductionEveryVoxel) {
    // The product floods a grid of at most 64 voxels a side, whatever the target's; to see the cost a voxel that bound is lifted.
    const auto voxels = code == Code::kProduction ? std::make_shared<const Voxels>(target) : std::make_shared<const Voxels>(target, 1024);
    state.counters["stride"] = voxels->stride;
    Evaluator evaluator(character, target, voxels, {});
    run(evaluator);
  } else {
    reference::ObjectiveOptions options;
    if (code == Code::kSameDistances) options.flood = reference::FloodKind::kShortestWay;
    const reference::Objective objective(character, target, {}, options);
    run(objective);
  }
}

void add(const Eigen::Vector3i& grid) {
  const std::pair<const char*, Code> codes[] = {{"production", Code::kProduction},
                                                {"production_every_voxel", Code::kProductionEveryVoxel},
                                                {"paper", Code::kPaper},
                                                {"paper_shortest_way", Code::kSameDistances}};
  for (const auto& [name, code] : codes)
    benchmark::RegisterBenchmark(("evaluation/" + bench::name_of(grid) + "/" + name).c_str(),
                                 [grid, code = code](benchmark::State& state) { evaluation(state, grid, code); })
        ->Unit(benchmark::kMillisecond)->MinTime(0.3);
}

}  // namespace
}  // namespace transformables

int main(int argc, char** argv) {
  for (const Eigen::Vector3i& grid : {Eigen::Vector3i(23, 18, 50), {30, 37, 37}, {44, 54, 44}, {45, 54, 54}, {64, 64, 64}, {96, 96, 96}, {128, 128, 128}})
    transformables::add(grid);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
