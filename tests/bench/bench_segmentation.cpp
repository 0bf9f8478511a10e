// The division of the target. Growth of the skins: production (with all that `grow` does besides: tiling, smooth interfaces) on one thread, and the dense
// reference. BENCH_LARGE=1 adds production at 256 voxels. Preview: the flood that the search divides with, at every voxel.
#include <cstdlib>

#include "bench.h"
#include "embedding/evaluator.h"
#include "embedding/flood.h"
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

// Whose every sample is in a pose that was not seen before, as the search finds it: with the terms of the objective.
void preview(benchmark::State& state, const Eigen::Vector3i& grid) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  bench::describe(state, target, character);
  Random random(1);
  std::vector<Pose> poses;
  for (int k = 0; k < 16; ++k) poses.push_back(reference::random_pose(character, random, 0.03));
  const Morphology morphology = Morphology::Ones(Eigen::Index(character.bones.size()));
  const bench::PeakMemory peak;
  Evaluator evaluator(character, target, std::make_shared<const Voxels>(target, 1024), {});
  std::vector<std::int16_t> labels;
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(evaluator(poses[k++ % poses.size()], morphology));
    evaluator.read_labels(labels);
    benchmark::ClobberMemory();
  }
  state.counters["peak_MB"] = peak.megabytes();
}

// The flood alone, from one voxel on each bone.
void flood_alone(benchmark::State& state, const Eigen::Vector3i& grid) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  const Embedding embedding = reference::folded(character, target);
  bench::describe(state, target, character);
  const bench::PeakMemory peak;
  const Voxels voxels(target, 1024);
  std::vector<std::int32_t> seeds(std::size_t(voxels.cells), kUnreached), field, rows;
  const auto frames = forward_kinematics(character, embedding.pose, embedding.morphology);
  for (std::size_t b = 0; b < frames.size(); ++b) {
    const Eigen::Vector3i v = ((frames[b].translation() - voxels.origin) / voxels.step).array().round().matrix().cast<int>().cwiseMax(0).cwiseMin(voxels.size - Eigen::Vector3i::Ones());
    seeds[std::size_t(voxels.cell(v.x(), v.y(), v.z()))] = std::int32_t(b);
  }
  for (auto _ : state) {
    field = seeds;
    benchmark::DoNotOptimize(flood(voxels, field.data(), rows));
  }
  state.counters["peak_MB"] = peak.megabytes();
}

void add_preview(const Eigen::Vector3i& grid) {
  const std::string name = "preview/" + bench::name_of(grid);
  benchmark::RegisterBenchmark((name + "/production").c_str(), [grid](benchmark::State& state) { preview(state, grid); })->Unit(benchmark::kMillisecond)->MinTime(0.3);
  benchmark::RegisterBenchmark((name + "/flood").c_str(), [grid](benchmark::State& state) { flood_alone(state, grid); })->Unit(benchmark::kMillisecond)->MinTime(0.3);
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
  transformables::add_preview({64, 64, 64});
  transformables::add_preview({128, 128, 128});
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
