// The folding order to the letter of the paper (section 6): dense level sets, one joint unfolded at a time, every sampled
// configuration in full, nothing kept from one choice to the next. Slow on purpose: the oracle for the production code and the
// baseline for its speed. It shares with that code only kinematics, the types of the doors, and how grids are read.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "character/character.h"
#include "common/grid.h"
#include "embedding/embedding.h"
#include "folding/folding.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::reference {

/// The skin of each bone in object mode: a signed distance over the target's whole grid (target units, negative inside), by fast marching.
/// Inside are the samples that the segmentation gives to the bone.
std::vector<Grid<float>> skins_of(const Segmentation& segmentation, const Target& target);

/// LevelSetCollision of Eq. 11: the net overlap of two level sets, cubic target units.
/// @param a_to_b  takes points of a, as its grid has them, to where they are in b's grid
/// @param tolerance  only what is deeper than that in b counts, target units
double level_set_collision(const Grid<float>& a, const Grid<float>& b, const Eigen::Isometry3d& a_to_b, double tolerance);

/// Takes points of each bone's part from object mode to where they are with these angles, the root standing still.
std::vector<Eigen::Isometry3d> displacements(const Character& character, const Embedding& embedding, const Eigen::VectorXd& angles);

/// The angles after a share of a move.
Eigen::VectorXd angles_within(const Move& move, Eigen::VectorXd angles, double fraction);

/// Two bones that a move turns against each other.
std::vector<std::pair<int, int>> pairs_turned(const Character& character, const Move& move);

class FoldingOrder {
 public:
  /// Refers to character and embedding while it lives. Of the options only the step and the tolerance count.
  FoldingOrder(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
               const FoldingOptions& options);

  /// Eq. 11 for one move: the mean over its configurations, all pairs that it turns against each other, cubic target units. (Pairs
  /// that stand still against each other overlap whatever is chosen.)
  double cost(const Eigen::VectorXd& start, const Move& move) const;
  /// Eq. 11 for each move of a path.
  std::vector<double> costs(const FoldPath& path) const;
  /// Starting in object mode, each time the joint is unfolded all the way that causes the least amount of collisions. Only moves are set.
  FoldPath greedy() const;

 private:
  const Character& character_;
  const Embedding& embedding_;
  FoldingOptions options_;
  std::vector<Grid<float>> skins_;
};

}  // namespace transformables::reference
