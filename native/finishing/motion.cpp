#include "finishing/motion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

Pose pose_at(const Embedding& embedding, const Eigen::VectorXd& start, const Move& move, double fraction) {
  Pose pose{embedding.pose.root, start};
  for (const Move::Turn& turn : move.turns)
    pose.angles[turn.angle] = turn.from_rad + fraction * (turn.to_rad - turn.from_rad);
  return pose;
}

Eigen::Vector3d centre_of(const GridShape& s) { return s.origin + s.step * (s.size.cast<double>().array() - 1).matrix() / 2; }
double radius_of(const GridShape& s) { return s.step * (s.size.cast<double>().array() - 1).matrix().norm() / 2; }

}  // namespace

std::vector<Eigen::VectorXd> states_of(const FoldPath& path, const Eigen::VectorXd& folded_angles) {
  std::vector<Eigen::VectorXd> states{folded_angles};
  for (const Move& move : path.moves) {
    Eigen::VectorXd next = states.back();
    for (const Move::Turn& turn : move.turns) next[turn.angle] = turn.to_rad;
    states.push_back(next);
  }
  return states;
}

MoveMotion::MoveMotion(const Character& character, const Embedding& embedding, const Segmentation& segmentation,
                       const Move& move, const Eigen::VectorXd& start, const std::vector<PartField>& parts,
                       const FinishingOptions& options, double cover)
    : character_(character), turning_(character.bones.size()) {
  const auto frames = forward_kinematics(character, pose_at(embedding, start, move, 0), embedding.morphology);
  double largest_turn = 0;
  for (std::size_t b = 0; b < character.bones.size(); ++b) {
    const Bone& bone = character.bones[b];
    int turns = 0;
    for (const Move::Turn& turn : move.turns) {
      const int hinge = turn.angle - bone.first_angle;
      if (hinge < 0 || hinge >= int(bone.hinges.size()) || turn.from_rad == turn.to_rad) continue;
      turning_[b].angle += std::abs(turn.to_rad - turn.from_rad);
      turning_[b].axis = frames[b].linear().col(bone.hinges[hinge].axis);
      ++turns;
    }
    // The axis of a hinge among several stands askew in the bone's own frame; its distance to the head bounds the lever arm.
    turning_[b].about_axis = turns == 1 && bone.hinges.size() == 1;
    turning_[b].head = frames[b].translation();
    largest_turn = std::max(largest_turn, turning_[b].angle);
  }
  poses_.resize(1);
  const auto fill = [&](std::size_t configuration, double fraction) {
    const auto now = forward_kinematics(character, pose_at(embedding, start, move, fraction), embedding.morphology);
    poses_[configuration].resize(now.size());
    for (std::size_t b = 0; b < now.size(); ++b)
      poses_[configuration][b] = now[b] * segmentation.frames[b].inverse(Eigen::Isometry);
  };
  fill(0, 0);
  double farthest = 0;
  for (const PartField& a : parts)
    for (const PartField& b : parts) {
      const PairMotion motion = pair(a.bone, b.bone);
      if (motion.moves)
        farthest = std::max(farthest, motion.travel(centre_of(a.shape())) + motion.angle * radius_of(a.shape()));
    }
  const int steps = std::max({1, int(std::ceil(farthest / (2 * cover))), int(std::ceil(largest_turn / options.largest_step_rad))});
  poses_.resize(steps + 1);
  tbb::parallel_for(1, steps + 1, [&](int n) { fill(n, double(n) / steps); });
}

std::vector<int> MoveMotion::turning_chain(int bone) const {
  std::vector<int> chain;
  for (int b = bone; b >= 0; b = character_.bones[b].parent)
    if (turning_[b].angle > 0) chain.push_back(b);
  return chain;
}

PairMotion MoveMotion::pair(int a, int b) const {
  std::vector<int> up = turning_chain(a), down = turning_chain(b);
  while (!up.empty() && !down.empty() && up.back() == down.back()) {
    up.pop_back();
    down.pop_back();
  }
  up.insert(up.end(), down.rbegin(), down.rend());
  PairMotion motion;
  if (up.empty()) return motion;
  const Eigen::Isometry3d back = poses_[0][a].inverse(Eigen::Isometry);
  motion.moves = true;
  motion.about_axis = up.size() == 1 && turning_[up[0]].about_axis;
  motion.pivot = back * turning_[up[0]].head;
  if (motion.about_axis) motion.axis = back.linear() * turning_[up[0]].axis;
  // Two joints that follow each other on the way from A to B sit on one rigid group, so their distance does not change.
  double chain = 0;
  for (std::size_t n = 0; n < up.size(); ++n) {
    if (n > 0) chain += (turning_[up[n]].head - turning_[up[n - 1]].head).norm();
    motion.angle += turning_[up[n]].angle;
    motion.beyond += turning_[up[n]].angle * chain;
  }
  return motion;
}

}  // namespace transformables::finishing
