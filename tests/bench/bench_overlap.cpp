// One overlap evaluation of a pair of parts in one configuration: production, the paper to the letter, and FCL on the parts' meshes
// (whether they meet, and all contacts; libfcl-dev). What the first choice of the greedy order asks: each joint unfolds by itself, and all pairs
// that it turns against each other are looked at, what of the lesser part is in the other.
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#ifdef BENCH_FCL
#include <fcl/fcl.h>
#endif

#include "bench.h"
#include "finishing/finishing.h"
#include "folding/motion.h"
#include "folding/overlap.h"
#include "reference/folding.h"

namespace transformables {
namespace {

struct Evaluation {
  int a = 0, b = 0;
  Eigen::Isometry3d a_to_b;   ///< object mode to object mode, target frame
  folding::Rigid lattice;     ///< the same, in steps of the grid
};

struct Scene {
  Target target;
  Character character;
  Embedding embedding;
  Segmentation segmentation;
  folding::Parts parts;
  std::vector<Grid<float>> skins;
  std::vector<Evaluation> evaluations;
};

/// Every fourth configuration of the moves that unfold one joint from object mode.
std::vector<Evaluation> evaluations_of(const Scene& scene) {
  std::vector<Evaluation> result;
  for (int joint = 0; joint < scene.character.angle_count; ++joint) {
    const Eigen::VectorXd& folded = scene.embedding.pose.angles;
    const Move move{{{joint, folded[joint], 0}}};
    const int steps = int(std::ceil(std::abs(folded[joint]) / (4 * FoldingOptions{}.largest_step_rad)));
    for (int i = 1; i <= steps; ++i) {
      const auto moved = reference::displacements(scene.character, scene.embedding, reference::angles_within(move, folded, double(i) / steps));
      for (auto [a, b] : reference::pairs_turned(scene.character, move)) {
        if (scene.parts.samples[b].points.size() < scene.parts.samples[a].points.size()) std::swap(a, b);
        const Eigen::Isometry3d a_to_b = moved[b].inverse() * moved[a];
        result.push_back({a, b, a_to_b, folding::in_lattice_units(a_to_b, scene.segmentation.shape)});
      }
    }
  }
  return result;
}

Scene scene_of(const Eigen::Vector3i& grid) {
  Scene scene;
  scene.target = reference::ellipsoid(grid);
  scene.character = reference::humanoid(scene.target);
  scene.embedding = reference::folded(scene.character, scene.target);
  scene.segmentation = grow(scene.character, scene.target, scene.embedding, {}, {});
  scene.parts = folding::parts_of(scene.segmentation, scene.target);
  scene.skins = reference::skins_of(scene.segmentation, scene.target);
  scene.evaluations = evaluations_of(scene);
  return scene;
}

/// Runs `evaluate(evaluation)`, which tells whether the pair meets, over all of them.
template <class Evaluate>
void evaluate_all(benchmark::State& state, const Scene& scene, const Evaluate& evaluate) {
  std::size_t meet = 0;
  for (auto _ : state) {
    meet = 0;
    for (const Evaluation& e : scene.evaluations) meet += evaluate(e);
  }
  bench::describe(state, scene.target, scene.character);
  state.counters["evaluations"] = double(scene.evaluations.size());
  state.counters["meet"] = double(meet);
}

void production(benchmark::State& state, const Eigen::Vector3i& grid) {
  const Scene scene = scene_of(grid);
  evaluate_all(state, scene, [&](const Evaluation& e) { return folding::overlapping_samples(scene.parts.samples[e.a], scene.parts.fields[e.b], e.lattice, 0) > 0; });
}

void paper(benchmark::State& state, const Eigen::Vector3i& grid) {
  const Scene scene = scene_of(grid);
  evaluate_all(state, scene, [&](const Evaluation& e) { return reference::level_set_collision(scene.skins[e.a], scene.skins[e.b], e.a_to_b, 0) > 0; });
}

#ifdef BENCH_FCL
using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

std::vector<std::unique_ptr<Model>> models_of(const Scene& scene) {
  std::vector<std::unique_ptr<Model>> models;
  for (const Grid<float>& skin : scene.skins) {
    const TriangleMesh mesh = isosurface(skin);
    std::vector<fcl::Triangle> triangles;
    for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    models.push_back(std::make_unique<Model>());
    models.back()->beginModel();
    models.back()->addSubModel(mesh.vertices, triangles);
    models.back()->endModel();
  }
  return models;
}

void with_fcl(benchmark::State& state, const Eigen::Vector3i& grid, bool contacts) {
  const Scene scene = scene_of(grid);
  const auto models = models_of(scene);
  const fcl::CollisionRequest<double> request(contacts ? 1'000'000 : 1, contacts);
  evaluate_all(state, scene, [&](const Evaluation& e) {
    fcl::CollisionResult<double> result;
    return fcl::collide(models[e.a].get(), e.a_to_b, models[e.b].get(), Eigen::Isometry3d::Identity(), request, result) > 0;
  });
}
#endif

void add(const Eigen::Vector3i& grid) {
  const auto one = [&](const char* code, auto work) {
    benchmark::RegisterBenchmark(("overlap/" + bench::name_of(grid) + "/" + code).c_str(), work)->Unit(benchmark::kMillisecond);
  };
  one("production", [grid](benchmark::State& state) { production(state, grid); });
  one("paper", [grid](benchmark::State& state) { paper(state, grid); });
#ifdef BENCH_FCL
  one("fcl_boolean", [grid](benchmark::State& state) { with_fcl(state, grid, false); });
  one("fcl_contacts", [grid](benchmark::State& state) { with_fcl(state, grid, true); });
#endif
}

}  // namespace
}  // namespace transformables

int main(int argc, char** argv) {
  transformables::add({23, 18, 50});
  transformables::add({44, 54, 44});
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
