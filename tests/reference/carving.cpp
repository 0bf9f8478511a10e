#include "reference/carving.h"

#include <algorithm>
#include <cmath>

#include "reference/folding.h"

namespace transformables::reference {
namespace {

constexpr float kFar = 1e3f;

/// How far the farthest sample of the bones that a hinge carries is from its joint, where `moved` puts them.
double lever(const Character& character, const Solids& solids, const std::vector<Eigen::Isometry3d>& moved,
             const std::vector<Eigen::Isometry3d>& folded, int angle) {
  double farthest = 0;
  for (int joint = 0; joint < int(character.bones.size()); ++joint) {
    const Bone& bone = character.bones[joint];
    if (angle < bone.first_angle || angle >= bone.first_angle + int(bone.hinges.size())) continue;
    const std::vector<char> carried = subtree(character, joint);
    const Eigen::Vector3d pivot = moved[joint] * folded[joint].translation();
    for (std::size_t b = 0; b < carried.size(); ++b)
      for (std::size_t v = 0; carried[b] && v < solids.parts[b].values.size(); ++v)
        if (solids.parts[b][v] < 0) farthest = std::max(farthest, (moved[b] * solids.parts[b].shape.position(v) - pivot).norm());
  }
  return farthest;
}

double lost(const Grid<float>& part, const Grid<float>& core, const Grid<float>& least, const Grid<float>& worth, double gap) {
  double sum = 0;
  for (std::size_t v = 0; v < part.values.size(); ++v) sum += part[v] < 0 && least[v] < gap && core[v] >= 0 ? worth[v] : 0;
  return sum;
}

void give_way(Grid<float>& part, const Grid<float>& core, const Grid<float>& least, double gap) {
  for (std::size_t v = 0; v < part.values.size(); ++v)
    part[v] = std::max(part[v], std::min(float(gap - least[v]), core[v]));
}

void carve_pair(Solids& solids, int a, int b, const std::vector<std::vector<Eigen::Isometry3d>>& moved, double gap) {
  std::vector<Eigen::Isometry3d> a_to_b, b_to_a;
  for (const auto& bones : moved) {
    a_to_b.push_back(bones[b].inverse() * bones[a]);
    b_to_a.push_back(a_to_b.back().inverse());
  }
  const Grid<float> in_a = swept(solids.parts[a], solids.parts[b], a_to_b), in_b = swept(solids.parts[b], solids.parts[a], b_to_a);
  const bool a_yields = lost(solids.parts[a], solids.cores[a], in_a, solids.worth, gap) <= lost(solids.parts[b], solids.cores[b], in_b, solids.worth, gap);
  const int loser = a_yields ? a : b, winner = a_yields ? b : a;
  give_way(solids.parts[loser], solids.cores[loser], a_yields ? in_a : in_b, gap);
  const Grid<float> to_core = swept(solids.parts[winner], solids.cores[loser], a_yields ? b_to_a : a_to_b);
  give_way(solids.parts[winner], solids.cores[winner], to_core, gap);
}

}  // namespace

Grid<float> swept(const Grid<float>& a, const Grid<float>& b, const std::vector<Eigen::Isometry3d>& a_to_b) {
  Grid<float> least(a.shape, kFar);
  for (std::size_t v = 0; v < a.values.size(); ++v) {
    if (!(a[v] < 0)) continue;
    const Eigen::Vector3d p = a.shape.position(v);
    for (const auto& map : a_to_b) least[v] = std::min(least[v], sample(b, map * p));
  }
  return least;
}

std::vector<std::vector<Eigen::Isometry3d>> configurations(const Character& character, const Embedding& embedding, const Move& move,
                                                           const Eigen::VectorXd& start, const Solids& solids, double largest_motion) {
  const auto moved = displacements(character, embedding, start);
  const auto folded = forward_kinematics(character, embedding.pose, embedding.morphology);
  double travel = 0;
  for (const auto& turn : move.turns) travel += std::abs(turn.to_rad - turn.from_rad) * lever(character, solids, moved, folded, turn.angle);
  const int steps = std::max(1, int(std::ceil(travel / largest_motion)));
  std::vector<std::vector<Eigen::Isometry3d>> result;
  for (int i = 0; i <= steps; ++i) result.push_back(displacements(character, embedding, angles_within(move, start, double(i) / steps)));
  return result;
}

void carve(const Character& character, const Embedding& embedding, const FoldPath& path, const CarvingOptions& options, Solids& solids) {
  Eigen::VectorXd angles = embedding.pose.angles;
  for (const Move& move : path.moves) {
    const auto moved = configurations(character, embedding, move, angles, solids, options.largest_motion);
    for (const auto& [a, b] : pairs_turned(character, move)) carve_pair(solids, a, b, moved, options.gap);
    angles = angles_within(move, angles, 1);
  }
}

}  // namespace transformables::reference
