// What a path collides with on a given segmentation.
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "folding/cores.h"
#include "folding/folding.h"

namespace transformables {
namespace folding {
namespace {

struct PairFacts {
  Collision worst;
  std::size_t swept = 0;
};

/// Of A's samples inside B the one nearest to their middle, lattice units, A's object mode.
Eigen::Vector3f middle_of_overlap(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance) {
  std::vector<Eigen::Vector3f> inside;
  for (const Eigen::Vector3f& p : a.points)
    if (b.at(a_to_b(p)) < -tolerance) inside.push_back(p);
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& p : inside) middle += p / float(inside.size());
  return *std::min_element(inside.begin(), inside.end(),
                           [&](const auto& p, const auto& q) { return (p - middle).squaredNorm() < (q - middle).squaredNorm(); });
}

PairFacts facts_of(const Parts& parts, const Design& design, const SampledMove& move, int a, int b, float tolerance) {
  PairFacts facts;
  const PairMotion there = move.pair(a, b), back = there.reversed();
  facts.swept = giving_way(parts, a, b, there, tolerance, false).samples;
  if (facts.swept == 0) return facts;
  std::size_t most = 0;
  Eigen::Vector3f place = Eigen::Vector3f::Zero();
  for (std::size_t t = 0; t < there.a_to_b.size(); ++t) {
    const std::size_t a_in_b = overlapping_samples(parts.samples[a], parts.fields[b], there.a_to_b[t], tolerance);
    const std::size_t b_in_a = overlapping_samples(parts.samples[b], parts.fields[a], back.a_to_b[t], tolerance);
    if (std::max(a_in_b, b_in_a) <= most) continue;
    most = std::max(a_in_b, b_in_a);
    place = a_in_b >= b_in_a ? middle_of_overlap(parts.samples[a], parts.fields[b], there.a_to_b[t], tolerance)
                             : back.a_to_b[t](middle_of_overlap(parts.samples[b], parts.fields[a], back.a_to_b[t], tolerance));
    facts.worst.fraction = double(t) / double(there.a_to_b.size() - 1);
  }
  facts.worst.bone_a = a, facts.worst.bone_b = b;
  facts.worst.volume = double(most) * design.sample_volume();
  facts.worst.swept = double(facts.swept) * design.sample_volume();
  const GridShape& shape = design.segmentation.shape;
  if (most > 0) facts.worst.place = design.segmentation.frames[a].inverse() * Eigen::Vector3d(shape.origin + shape.step * place.cast<double>());
  return facts;
}

FoldPath measured_path(const FoldPath& path, const Design& design, const FoldingOptions& options) {
  const Parts parts = parts_of(design.segmentation, design.target, 1, skeletons_of(design));
  FoldPath result;
  result.moves = path.moves;
  result.cut_short = path.cut_short;
  Eigen::VectorXd angles = design.embedding.pose.angles;
  std::size_t swept = 0;
  for (std::size_t m = 0; m < path.moves.size(); ++m) {
    const SampledMove move(design, angles, path.moves[m], options.largest_step_rad);
    std::vector<std::pair<int, int>> pairs;
    for (int a = 0; a < design.bones(); ++a)
      for (int b = a + 1; b < design.bones(); ++b)
        if (move.group(a) != move.group(b)) pairs.push_back({a, b});
    std::vector<PairFacts> facts(pairs.size());
    tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t p) {
      facts[p] = facts_of(parts, design, move, pairs[p].first, pairs[p].second, float(options.tolerance_steps));
    });
    for (PairFacts& f : facts) {
      swept += f.swept;
      f.worst.move = m;
      if (f.swept > 0) result.collisions.push_back(f.worst);
    }
    angles = angles_at(angles, path.moves[m], 1);
  }
  std::stable_sort(result.collisions.begin(), result.collisions.end(), [](const Collision& x, const Collision& y) { return x.volume > y.volume; });
  result.overlap_volume = double(swept) * design.sample_volume();
  return result;
}

}  // namespace
}  // namespace folding

FoldPath measured(const FoldPath& path, const Segmentation& segmentation, const Character& character, const Target& target,
                  const Embedding& embedding, const FoldingOptions& options) {
  const folding::Design design{character, segmentation, target, embedding};
  folding::check(design, options);
  folding::check(path, embedding.pose.angles);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  return arena.execute([&] { return folding::measured_path(path, design, options); });
}

}  // namespace transformables
