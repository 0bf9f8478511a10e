// Carving along the greedy path: production, whose configurations lie so close that nothing slips between two, and the paper to the letter,
// with a configuration whenever something has moved by a step. One thread. "x4": at four times the grid's resolution.
#include <tbb/task_arena.h>

#include "bench.h"
#include "finishing/carve.h"
#include "folding/folding.h"
#include "reference/carving.h"
#include "reference/dense.h"

namespace transformables {
namespace {

double inside(const std::vector<Grid<float>>& parts) {
  double count = 0;
  for (const auto& part : parts) count += double(finishing::inside_count(part));
  return count;
}

void carving(benchmark::State& state, const Eigen::Vector3i& grid, int refinement, bool letter) {
  const Target target = reference::ellipsoid(grid);
  const Character character = reference::humanoid(target);
  const Embedding embedding = reference::folded(character, target);
  const Segmentation segmentation = grow(character, target, embedding, {}, {});
  const FoldPath path = plan_greedy(segmentation, character, target, embedding, {}, {});
  FinishingOptions options;
  options.refinement = refinement;
  const finishing::Lattice lattice = finishing::make_lattice(target, options);
  std::vector<finishing::PartField> fields = finishing::make_part_fields(segmentation, character, embedding, options, lattice);
  reference::Solids solids = reference::dense(fields, lattice.outer.shape);
  const double before = inside(solids.parts);
  std::vector<std::size_t> dropped(fields.size(), 0);
  tbb::task_arena alone(1);
  for (auto _ : state) {
    if (letter) reference::carve(character, embedding, path, {lattice.passing, lattice.step()}, solids);
    else alone.execute([&] { finishing::carve({character, embedding, segmentation, path, options, lattice}, fields, dropped, {}); });
  }
  bench::describe(state, target, character);
  state.counters["samples"] = double(lattice.outer.shape.count());
  if (!letter) solids = reference::dense(fields, lattice.outer.shape);
  state.counters["carved_pct"] = 100 * (1 - inside(solids.parts) / before);
}

void add(const Eigen::Vector3i& grid, int refinement, bool letter) {
  const std::string name = "carving/" + bench::name_of(grid) + (refinement > 1 ? " x" + std::to_string(refinement) : "");
  benchmark::RegisterBenchmark((name + (letter ? "/paper" : "/production")).c_str(),
                               [=](benchmark::State& state) { carving(state, grid, refinement, letter); })
      ->Unit(benchmark::kMillisecond)->Iterations(1);  // what is carved is not what was to be carved
}

}  // namespace
}  // namespace transformables

int main(int argc, char** argv) {
  for (const int refinement : {1, 4})
    for (const bool letter : {false, true}) transformables::add({23, 18, 50}, refinement, letter);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
