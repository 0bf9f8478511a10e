#include "folding/folding.h"

#include <cmath>

#include "folding/motion.h"

namespace transformables {
namespace {

/// The bone that a hinge turns and its place among that bone's hinges.
std::pair<int, int> hinge_of(const Character& character, int angle) {
  for (std::size_t b = 0; b < character.bones.size(); ++b) {
    const Bone& bone = character.bones[b];
    if (angle >= bone.first_angle && angle < bone.first_angle + int(bone.hinges.size())) return {int(b), angle - bone.first_angle};
  }
  throw InvalidInput("folding: the path turns hinge " + std::to_string(angle) + ", which the character does not have; plan it again");
}

}  // namespace

PathSamples sampled(const FoldPath& path, const Eigen::VectorXd& folded_angles, double largest_step_rad) {
  if (!std::isfinite(largest_step_rad) || largest_step_rad <= 0)
    throw InvalidInput("folding: largest_step_rad must be a positive number of radians");
  folding::check(path, folded_angles);
  PathSamples samples;
  samples.angles.push_back(folded_angles);
  samples.move.push_back(0);
  for (std::size_t m = 0; m < path.moves.size(); ++m) {
    const Eigen::VectorXd start = samples.angles.back();
    const int steps = folding::steps_of(path.moves[m], largest_step_rad);
    for (int i = 1; i <= steps; ++i) {
      samples.angles.push_back(folding::angles_at(start, path.moves[m], double(i) / steps));
      samples.move.push_back(m);
    }
  }
  return samples;
}

std::vector<JointRange> ranges_of(const FoldPath& path, const Character& character) {
  std::vector<JointRange> ranges;
  std::vector<int> place(character.angle_count, -1);
  for (const Move& move : path.moves)
    for (const auto& turn : move.turns) {
      const auto [bone, hinge] = hinge_of(character, turn.angle);
      if (place[turn.angle] < 0) {
        place[turn.angle] = int(ranges.size());
        ranges.push_back({bone, hinge, turn.from_rad, turn.from_rad});
      }
      // From the folded angle to the farthest one that is asked for, whichever side it is on.
      JointRange& r = ranges[place[turn.angle]];
      const bool rising = r.to_rad >= r.from_rad;
      const double low = std::min({r.from_rad, r.to_rad, turn.from_rad, turn.to_rad});
      const double high = std::max({r.from_rad, r.to_rad, turn.from_rad, turn.to_rad});
      const bool starts_low = r.from_rad == r.to_rad ? turn.to_rad >= turn.from_rad : rising;
      r.from_rad = starts_low ? low : high;
      r.to_rad = starts_low ? high : low;
    }
  return ranges;
}

std::vector<JointRange> straight_ranges(const Character& character, const Embedding& embedding) {
  if (embedding.pose.angles.size() != character.angle_count)
    throw InvalidInput("folding: the embedding has " + std::to_string(embedding.pose.angles.size()) + " angles, the character " +
                       std::to_string(character.angle_count) + "; embed this character again");
  std::vector<JointRange> ranges;
  for (std::size_t b = 0; b < character.bones.size(); ++b)
    for (std::size_t h = 0; h < character.bones[b].hinges.size(); ++h)
      ranges.push_back({int(b), int(h), embedding.pose.angles[character.bones[b].first_angle + int(h)], 0.0});
  return ranges;
}

}  // namespace transformables
