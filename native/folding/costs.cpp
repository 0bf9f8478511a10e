#include "folding/costs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "folding/cores.h"

namespace transformables::folding {
namespace {

constexpr double kOpenAlready = 1e-6;  // radians
constexpr double kMostSamples = 64;    // along the target's longest side: orders need no finer
constexpr double kSameLevel = 0.12;    // radians: places nearer to one another are not worth telling apart

int stride_of(const Target& target) { return std::max(1, int(kLongestSide / target.distance.shape.step / kMostSamples + 0.01)); }

/// The hinge that mirrors another, with the sign that its angle takes.
std::pair<int, double> mirrored_hinge(const Character& character, int angle) {
  Eigen::VectorXd probe = Eigen::VectorXd::Zero(character.angle_count);
  probe[angle] = 1;
  const Eigen::VectorXd image = mirrored_angles(character, probe);
  Eigen::Index other = 0;
  image.cwiseAbs().maxCoeff(&other);
  return {int(other), image[other]};
}

Unit unit_of(const Design& design, const Hinge& hinge, int angle, int twin, double sign) {
  Unit unit;
  unit.angles = {angle};
  if (twin != angle) unit.angles.push_back(twin);
  const auto add = [&](double at) {
    std::vector<double> level{at};
    if (twin != angle) level.push_back(sign * at);
    unit.levels.push_back(level);
  };
  const double folded = design.embedding.pose.angles[angle];
  add(folded), add(0);
  if (twin != angle) unit.levels[Unit::kFolded][1] = design.embedding.pose.angles[twin];
  for (const int a : unit.angles) unit.must_open = unit.must_open || std::abs(design.embedding.pose.angles[a]) > kOpenAlready;
  for (const double at : {folded / 2, hinge.min_rad, hinge.max_rad, hinge.min_rad / 2, hinge.max_rad / 2, -folded / 2}) {
    const bool known = std::any_of(unit.levels.begin(), unit.levels.end(), [&](const auto& l) { return std::abs(l[0] - at) < kSameLevel; });
    if (!known && at >= hinge.min_rad && at <= hinge.max_rad) add(at);
  }
  return unit;
}

}  // namespace

std::vector<Unit> units_of(const Design& design, const FoldingOptions& options) {
  const bool together = options.mirrored_together && design.embedding.symmetric && design.character.mirrored;
  std::vector<Unit> units;
  std::vector<char> taken(design.character.angle_count, 0);
  for (const Bone& bone : design.character.bones)
    for (std::size_t h = 0; h < bone.hinges.size(); ++h) {
      const int angle = bone.first_angle + int(h);
      if (taken[angle]) continue;
      const auto [twin, sign] = together ? mirrored_hinge(design.character, angle) : std::pair(angle, 1.0);
      taken[angle] = taken[twin] = 1;
      units.push_back(unit_of(design, bone.hinges[h], angle, twin, sign));
    }
  return units;
}

struct Costs::Task {
  const Edge* edge;
  std::size_t move;  // index of its sampled move
  int a, b;
  std::string key;
  double cost = 0;
};

Costs::Costs(const Design& design, const FoldingOptions& options)
    : design_(design), options_(options), units_(units_of(design, options)),
      parts_(parts_of(design.segmentation, design.target, stride_of(design.target),
                      options.cost == MoveCost::kSweptVolume ? skeletons_of(design) : Skeletons{})) {  // the paper's cost knows of no skeletons
  const int bones = design.bones();
  const std::vector<int> bone_of = design.bone_of_angle();
  std::vector<std::vector<char>> below(bones);  // [b]: flags of the bones that turn with b
  for (int b = 0; b < bones; ++b) below[b] = subtree(design.character, b);
  pairs_.resize(units_.size());
  units_between_.assign(bones, std::vector<std::vector<int>>(bones));
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (int a = 0; a < bones; ++a)
      for (int b = a + 1; b < bones; ++b) {
        bool moves = false;
        for (const int angle : units_[u].angles) moves = moves || below[bone_of[angle]][a] != below[bone_of[angle]][b];
        if (!moves) continue;
        units_between_[a][b].push_back(int(u));
        if (!parts_.fields[a].empty() && !parts_.fields[b].empty()) pairs_[u].push_back({a, b});
      }
}

std::string Costs::pair_key(const Edge& edge, int a, int b) const {
  std::string key{char(edge.step.unit), char(edge.step.unit >> 8), char(edge.step.level), char(a), char(a >> 8), char(b), char(b >> 8)};
  for (const int u : units_between_[a][b]) key.push_back(char(edge.from[u]));
  return key;
}

namespace {
std::string edge_key(const Edge& edge) {
  std::string key(edge.from.begin(), edge.from.end());
  key.push_back(char(edge.step.unit)), key.push_back(char(edge.step.unit >> 8)), key.push_back(char(edge.step.level));
  return key;
}
}  // namespace

std::vector<Costs::Task> Costs::unknown_pairs(const std::vector<Edge>& edges, const std::vector<int>& wanted) {
  std::vector<Task> tasks;
  for (std::size_t w = 0; w < wanted.size(); ++w) {
    const Edge& edge = edges[wanted[w]];
    for (const auto& [a, b] : pairs_[edge.step.unit]) {
      std::string key = pair_key(edge, a, b);
      if (pair_costs_.emplace(key, 0.0).second) tasks.push_back({&edge, w, a, b, std::move(key)});
    }
  }
  return tasks;
}

std::vector<double> Costs::of(const std::vector<Edge>& edges) {
  std::vector<int> wanted;
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (edge_costs_.emplace(edge_key(edges[e]), 0.0).second) wanted.push_back(int(e));
  expansions_ += long(wanted.size());
  std::vector<Task> tasks = unknown_pairs(edges, wanted);
  std::vector<std::unique_ptr<SampledMove>> moves(wanted.size());
  std::vector<char> used(wanted.size(), 0);
  for (const Task& task : tasks) used[task.move] = 1;
  tbb::parallel_for(std::size_t(0), wanted.size(), [&](std::size_t w) {
    const Edge& edge = edges[wanted[w]];
    if (used[w]) moves[w] = std::make_unique<SampledMove>(design_, angles(edge.from), move(edge), options_.largest_step_rad);
  });
  tbb::parallel_for(std::size_t(0), tasks.size(), [&](std::size_t t) { tasks[t].cost = pair_cost(*moves[tasks[t].move], tasks[t].a, tasks[t].b); });
  for (const Task& task : tasks) pair_costs_[task.key] = task.cost;
  for (const int e : wanted) edge_costs_[edge_key(edges[e])] = sum(edges[e]);
  std::vector<double> costs;
  for (const Edge& edge : edges) costs.push_back(edge_costs_.at(edge_key(edge)));
  return costs;
}

double Costs::sum(const Edge& edge) const {
  double total = 0;
  for (const auto& [a, b] : pairs_[edge.step.unit]) total += pair_costs_.at(pair_key(edge, a, b));
  return total;
}

double Costs::pair_cost(const SampledMove& move, int a, int b) const {
  const float tolerance = float(options_.tolerance_steps);
  const PairMotion motion = move.pair(a, b);
  if (options_.cost == MoveCost::kSweptVolume) return double(giving_way(parts_, a, b, motion, tolerance, false).samples);
  double total = 0;
  for (const Rigid& a_to_b : motion.a_to_b) total += double(overlapping_samples(parts_.samples[a], parts_.fields[b], a_to_b, tolerance));
  return total / double(motion.a_to_b.size());
}

Eigen::VectorXd Costs::angles(const State& state) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(design_.character.angle_count);
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t i = 0; i < units_[u].angles.size(); ++i) result[units_[u].angles[i]] = units_[u].levels[state[u]][i];
  return result;
}

Move Costs::move(const Edge& edge) const {
  const Unit& unit = units_[edge.step.unit];
  Move result;
  for (std::size_t i = 0; i < unit.angles.size(); ++i)
    result.turns.push_back({unit.angles[i], unit.levels[edge.from[edge.step.unit]][i], unit.levels[edge.step.level][i]});
  return result;
}

std::optional<Step> Costs::step_of(const Move& move) const {
  for (std::size_t u = 0; u < units_.size(); ++u)
    for (std::size_t level = 0; level < units_[u].levels.size(); ++level) {
      bool fits = move.turns.size() == units_[u].angles.size();
      for (std::size_t i = 0; fits && i < move.turns.size(); ++i)
        fits = move.turns[i].angle == units_[u].angles[i] && move.turns[i].to_rad == units_[u].levels[level][i];
      if (fits) return Step{int(u), int(level)};
    }
  return {};
}

}  // namespace transformables::folding
