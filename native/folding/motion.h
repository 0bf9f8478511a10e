// A move as configurations: which bones move together, and where each pair of them is against the other.
#pragma once

#include <vector>

#include "character/character.h"
#include "embedding/embedding.h"
#include "folding/folding.h"
#include "folding/overlap.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::folding {

/// All that a room function needs about a design that stands still; refers to what it was made from.
struct Design {
  const Character& character;
  const Segmentation& segmentation;
  const Target& target;
  const Embedding& embedding;

  int bones() const { return int(character.bones.size()); }
  /// Which bone a hinge turns.
  std::vector<int> bone_of_angle() const;
  double sample_volume() const { return segmentation.shape.step * segmentation.shape.step * segmentation.shape.step; }
};

/// @throws InvalidInput when the parts of a design do not fit each other, or an option is out of range.
void check(const Design& design, const FoldingOptions& options);
/// @throws InvalidInput when a path turns hinges that do not exist, or starts a turn elsewhere than the last one ended.
void check(const FoldPath& path, const Eigen::VectorXd& folded_angles);

/// The number of steps that a move is sampled with, each hinge turning at most `largest_step_rad` in one.
int steps_of(const Move& move, double largest_step_rad);
/// The angles of a move after a share of it.
Eigen::VectorXd angles_at(const Eigen::VectorXd& start, const Move& move, double fraction);

/// One move from one state, sampled.
class SampledMove {
 public:
  SampledMove(const Design& design, const Eigen::VectorXd& start, const Move& move, double largest_step_rad);

  int configurations() const { return int(to_world_.size()); }
  /// Two bones of one group stand still against each other. Group 0 does not move at all.
  int group(int bone) const { return group_[bone]; }
  PairMotion pair(int a, int b) const;

 private:
  std::vector<int> group_;
  bool plain_ = true;  // one turn a group, and none carried by another: each group turns about an axis that stands still
  std::vector<std::vector<Rigid>> to_world_, from_world_;  // [configuration][bone]: object mode to now, and back
};

}  // namespace transformables::folding
