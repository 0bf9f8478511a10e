#include "reference/folding.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reference/growth.h"

namespace transformables::reference {
namespace {

constexpr double kOpenAlready = 1e-6;  // radians

}  // namespace

std::vector<Grid<float>> skins_of(const Segmentation& segmentation, const Target& target) {
  const GridShape& shape = segmentation.shape;
  const float far = float(4 * shape.step);
  std::vector<Grid<float>> dense(segmentation.phi.size(), Grid<float>(shape, far));
  for (std::size_t b = 0; b < dense.size(); ++b) {
    const Grid<float>& phi = segmentation.phi[b];
    if (phi.values.empty()) continue;
    const Eigen::Vector3i low = shape.nearest(phi.shape.origin);
    for (std::size_t v = 0; v < phi.values.size(); ++v)
      if (shape.contains(low + phi.shape.cell(v))) dense[b].at(low + phi.shape.cell(v)) = phi[v];
  }
  std::vector<Grid<float>> skins = dense;
  for (std::size_t v = 0; v < shape.count(); ++v)
    for (std::size_t b = 0; b < dense.size(); ++b) {
      float other = far;
      for (std::size_t o = 0; o < dense.size(); ++o)
        if (o != b) other = std::min(other, dense[o][v]);
      const float between = std::max((dense[b][v] - other) / 2, target.distance[v]);
      const bool inside = segmentation.owner[v] == int(b);
      // Where level sets tie, the owner decides, and the surface passes half-way.
      skins[b][v] = inside == (between < 0) ? between : float(inside ? -shape.step / 2 : shape.step / 2);
    }
  for (auto& skin : skins) redistance(skin);
  return skins;
}

double level_set_collision(const Grid<float>& a, const Grid<float>& b, const Eigen::Isometry3d& a_to_b, double tolerance) {
  std::size_t both = 0;
  for (std::size_t v = 0; v < a.values.size(); ++v) both += a[v] < 0 && sample(b, a_to_b * a.shape.position(v)) < -tolerance;
  return double(both) * std::pow(a.shape.step, 3);
}

std::vector<Eigen::Isometry3d> displacements(const Character& character, const Embedding& embedding, const Eigen::VectorXd& angles) {
  const auto folded = forward_kinematics(character, embedding.pose, embedding.morphology);
  auto now = forward_kinematics(character, {embedding.pose.root, angles}, embedding.morphology);
  for (std::size_t b = 0; b < now.size(); ++b) now[b] = now[b] * folded[b].inverse();
  return now;
}

Eigen::VectorXd angles_within(const Move& move, Eigen::VectorXd angles, double fraction) {
  for (const auto& turn : move.turns) angles[turn.angle] = turn.from_rad + fraction * (turn.to_rad - turn.from_rad);
  return angles;
}

std::vector<std::pair<int, int>> pairs_turned(const Character& character, const Move& move) {
  const int bones = int(character.bones.size());
  std::vector<std::pair<int, int>> pairs;
  std::vector<std::vector<char>> turned;
  for (const auto& turn : move.turns)
    for (int b = 0; b < bones; ++b) {
      const Bone& bone = character.bones[b];
      if (turn.angle >= bone.first_angle && turn.angle < bone.first_angle + int(bone.hinges.size())) turned.push_back(subtree(character, b));
    }
  for (int a = 0; a < bones; ++a)
    for (int b = a + 1; b < bones; ++b)
      if (std::any_of(turned.begin(), turned.end(), [&](const auto& with) { return with[a] != with[b]; })) pairs.emplace_back(a, b);
  return pairs;
}

FoldingOrder::FoldingOrder(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                           const FoldingOptions& options)
    : character_(character), embedding_(embedding), options_(options), skins_(skins_of(segmentation, target)) {}

double FoldingOrder::cost(const Eigen::VectorXd& start, const Move& move) const {
  double turned = 0;
  for (const auto& turn : move.turns) turned = std::max(turned, std::abs(turn.to_rad - turn.from_rad));
  const int steps = std::max(1, int(std::ceil(turned / options_.largest_step_rad - 1e-9)));
  const double tolerance = options_.tolerance_steps * skins_[0].shape.step;
  const auto pairs = pairs_turned(character_, move);
  double sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const auto moved = displacements(character_, embedding_, angles_within(move, start, double(i) / steps));
    for (const auto& [a, b] : pairs) sum += level_set_collision(skins_[a], skins_[b], moved[b].inverse() * moved[a], tolerance);
  }
  return sum / (steps + 1);
}

std::vector<double> FoldingOrder::costs(const FoldPath& path) const {
  std::vector<double> costs;
  Eigen::VectorXd angles = embedding_.pose.angles;
  for (const Move& move : path.moves) {
    costs.push_back(cost(angles, move));
    angles = angles_within(move, angles, 1);
  }
  return costs;
}

FoldPath FoldingOrder::greedy() const {
  FoldPath path;
  Eigen::VectorXd angles = embedding_.pose.angles;
  for (;;) {
    Move best;
    double least = std::numeric_limits<double>::infinity();
    for (int joint = 0; joint < angles.size(); ++joint) {
      if (std::abs(angles[joint]) <= kOpenAlready) continue;
      const Move move{{{joint, angles[joint], 0}}};
      const double c = cost(angles, move);
      if (c < least) least = c, best = move;
    }
    if (best.turns.empty()) return path;
    path.moves.push_back(best);
    angles = angles_within(best, angles, 1);
  }
}

}  // namespace transformables::reference
