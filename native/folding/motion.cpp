#include "folding/motion.h"

#include <cmath>
#include <string>

namespace transformables::folding {

std::vector<int> Design::bone_of_angle() const {
  std::vector<int> bone_of(character.angle_count, 0);
  for (int b = 0; b < bones(); ++b)
    for (std::size_t h = 0; h < character.bones[b].hinges.size(); ++h) bone_of[character.bones[b].first_angle + int(h)] = b;
  return bone_of;
}

void check(const Design& design, const FoldingOptions& options) {
  const auto& [character, segmentation, target, embedding] = design;
  const auto demand = [](bool holds, const std::string& text) {
    if (!holds) throw InvalidInput("folding: " + text);
  };
  demand(!character.bones.empty(), "the character has no bones; give one with at least one hinge");
  demand(segmentation.frames.size() == character.bones.size() && segmentation.phi.size() == character.bones.size(),
         "the segmentation has " + std::to_string(segmentation.frames.size()) + " bones, the character " +
             std::to_string(character.bones.size()) + "; segment this character again");
  demand(segmentation.shape == target.distance.shape && segmentation.owner.size() == segmentation.shape.count() &&
             target.distance.values.size() == segmentation.shape.count(),
         "the segmentation is not on the target's grid; segment this target again");
  demand(embedding.pose.angles.size() == character.angle_count && embedding.morphology.size() == design.bones(),
         "the embedding has " + std::to_string(embedding.pose.angles.size()) + " angles, the character " +
             std::to_string(character.angle_count) + "; embed this character again");
  demand(embedding.pose.angles.allFinite() && embedding.morphology.allFinite(), "the embedding holds a number that is not finite");
  for (const std::size_t s : target.inside)
    demand(s < segmentation.owner.size() && segmentation.owner[s] >= 0 && segmentation.owner[s] < design.bones(),
           "an inside sample belongs to no bone of the character; make the segmentation a tiling first");
  demand((segmentation.pinned.empty() || segmentation.pinned.size() == segmentation.owner.size()) &&
             (segmentation.inhibited.empty() || segmentation.inhibited.size() == character.bones.size()),
         "the segmentation's pinned samples or inhibited bones are of another design; segment again");
  demand(std::isfinite(options.largest_step_rad) && options.largest_step_rad > 0 && options.largest_step_rad <= 1,
         "largest_step_rad must be over 0 and at most 1 radian");
  demand(std::isfinite(options.seconds) && options.seconds >= 0, "seconds must not be negative");
  demand(std::isfinite(options.tolerance_steps) && options.tolerance_steps >= 0 && options.tolerance_steps <= 2,
         "tolerance_steps must be 0 to 2");
  demand(options.beam_width >= 1 && options.expansions >= 0, "beam_width must be at least 1, expansions at least 0");
  demand(options.threads >= 0, "threads must be 0 (all cores) or more");
}

void check(const FoldPath& path, const Eigen::VectorXd& folded_angles) {
  constexpr double kSame = 1e-6;
  Eigen::VectorXd now = folded_angles;
  if (!now.allFinite()) throw InvalidInput("folding: the folded angles hold a number that is not finite");
  for (std::size_t m = 0; m < path.moves.size(); ++m)
    for (const auto& turn : path.moves[m].turns) {
      const std::string where = "folding: move " + std::to_string(m) + " of the path ";
      if (turn.angle < 0 || turn.angle >= now.size()) throw InvalidInput(where + "turns a hinge that the character does not have");
      if (!std::isfinite(turn.from_rad) || !std::isfinite(turn.to_rad)) throw InvalidInput(where + "holds an angle that is not finite");
      if (std::abs(now[turn.angle] - turn.from_rad) > kSame)
        throw InvalidInput(where + "does not start where the hinge stands; plan the path again for this embedding");
      now[turn.angle] = turn.to_rad;
    }
}

int steps_of(const Move& move, double largest_step_rad) {
  double largest = 0;
  for (const auto& turn : move.turns) largest = std::max(largest, std::abs(turn.to_rad - turn.from_rad));
  return std::max(1, int(std::ceil(largest / largest_step_rad - 1e-9)));
}

Eigen::VectorXd angles_at(const Eigen::VectorXd& start, const Move& move, double fraction) {
  Eigen::VectorXd angles = start;
  for (const auto& turn : move.turns)
    angles[turn.angle] = fraction >= 1 ? turn.to_rad : turn.from_rad + fraction * (turn.to_rad - turn.from_rad);
  return angles;
}

SampledMove::SampledMove(const Design& design, const Eigen::VectorXd& start, const Move& move, double largest_step_rad)
    : group_(design.bones(), 0) {
  const std::vector<int> bone_of = design.bone_of_angle();
  std::vector<int> turned(design.bones(), 0);
  for (std::size_t t = 0; t < move.turns.size(); ++t) {
    int& group = turned[bone_of[move.turns[t].angle]];
    plain_ = plain_ && group == 0;
    group = int(t) + 1;
  }
  // Parents come before children, so a bone's group is that of the nearest turning bone above it.
  for (int b = 0; b < design.bones(); ++b) {
    const int parent = design.character.bones[b].parent;
    const int above = parent >= 0 ? group_[parent] : 0;
    plain_ = plain_ && !(turned[b] && above);
    group_[b] = turned[b] ? turned[b] : above;
  }
  const int steps = steps_of(move, largest_step_rad);
  Pose pose = design.embedding.pose;
  for (int i = 0; i <= steps; ++i) {
    pose.angles = angles_at(start, move, double(i) / steps);
    const auto frames = forward_kinematics(design.character, pose, design.embedding.morphology);
    std::vector<Rigid> to_world, from_world;
    for (int b = 0; b < design.bones(); ++b) {
      const Eigen::Isometry3d moved = frames[b] * design.segmentation.frames[b].inverse();
      to_world.push_back(in_lattice_units(moved, design.segmentation.shape));
      from_world.push_back(in_lattice_units(moved.inverse(), design.segmentation.shape));
    }
    to_world_.push_back(std::move(to_world));
    from_world_.push_back(std::move(from_world));
  }
}

PairMotion SampledMove::pair(int a, int b) const {
  PairMotion motion;
  motion.steady = plain_ && (group_[a] == 0 || group_[b] == 0);
  motion.a_to_b.reserve(to_world_.size());
  for (std::size_t t = 0; t < to_world_.size(); ++t) {
    const Rigid &out = to_world_[t][a], &back = from_world_[t][b];
    motion.a_to_b.push_back({back.turn * out.turn, back.turn * out.shift + back.shift});
  }
  return motion;
}

}  // namespace transformables::folding
