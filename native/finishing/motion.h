// A move of the path as configurations, so close that no point of a part moves further than twice the cover between two.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "character/character.h"
#include "embedding/embedding.h"
#include "finishing/part_field.h"
#include "folding/folding.h"

namespace transformables::finishing {

/// How two parts move against each other in a move, seen from A.
struct PairMotion {
  bool moves = false;
  bool about_axis = false;                            ///< one hinge of a one-hinge bone: lever arms are those of its axis
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();    ///< of the turning joint nearest to A; A's place in object mode
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double angle = 0;                                   ///< radians turned in the move, all hinges between them
  double beyond = 0;                                  ///< path length of the pivots further on

  /// How far, at most, a point of A (in object mode) moves against B in the whole move.
  double travel(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d lever = p - pivot;
    return angle * (about_axis ? lever.cross(axis).norm() : lever.norm()) + beyond;
  }
};

class MoveMotion {
 public:
  /// @param start  angles at the move's beginning
  MoveMotion(const Character& character, const Embedding& embedding, const Segmentation& segmentation, const Move& move,
             const Eigen::VectorXd& start, const std::vector<PartField>& parts, const FinishingOptions& options, double cover);

  int last() const { return int(poses_.size()) - 1; }  ///< configurations are 0 to last
  PairMotion pair(int a, int b) const;
  /// Takes points of A in object mode to where they are against B in object mode.
  Eigen::Isometry3d into(int a, int b, int configuration) const {
    return poses_[configuration][b].inverse(Eigen::Isometry) * poses_[configuration][a];
  }

 private:
  struct Turning {
    double angle = 0;
    bool about_axis = false;
    Eigen::Vector3d head, axis;  ///< target frame, at the start of the move
  };
  std::vector<int> turning_chain(int bone) const;

  const Character& character_;
  std::vector<Turning> turning_;                        ///< a bone each; angle 0: it does not turn
  std::vector<std::vector<Eigen::Isometry3d>> poses_;   ///< [configuration][bone]: object mode to now
};

/// The angles before each move of a path, and after the last.
std::vector<Eigen::VectorXd> states_of(const FoldPath& path, const Eigen::VectorXd& folded_angles);

}  // namespace transformables::finishing
