// What the optimiser varies, as one vector of numbers of like size, and the pose and morphology it stands for.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "character/character.h"
#include "target/target.h"

namespace transformables {

/// Where a search begins: how the character (not its root bone) is turned, and where the root's head is.
struct StartPlace {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< takes directions of the character frame to the target's
  Eigen::Vector3d head = Eigen::Vector3d::Zero();          ///< target frame
};

/// Root position and rotation, angles (each within its limits, whatever the number), logarithms of scales (within
/// their bounds). When symmetric: the root keeps two moves in the target's mirror plane and a turn about its normal,
/// and of each mirrored pair of bones only one is varied. A bone that lies in the plane keeps those hinges that do
/// not lead out of it.
class Unknowns {
 public:
  struct Options {
    bool symmetric = false;
    bool proportions = true;
    double least_scale = 0.6, largest_scale = 1.6;
  };
  /// @param target  only its mirror axis is looked at; both need a mirror plane when symmetric
  Unknowns(const Character& character, const Target& target, const Options& options);

  int count() const { return root_count_ + int(angles_.size()) + int(scales_.size()); }
  int root_count() const { return root_count_; }

  /// `pose.angles` and `morphology` must have their sizes; nothing is allocated.
  void read(const Eigen::VectorXd& y, const StartPlace& start, Pose& pose, Morphology& morphology) const;

  /// A start and numbers that give this pose (when symmetric: its nearest symmetric one).
  Eigen::VectorXd write(const Pose& pose, const Morphology& morphology, StartPlace& start) const;

  /// The 24 turns of a cube, or when symmetric those that keep the mirror planes together.
  std::vector<Eigen::Matrix3d> start_rotations() const;

 private:
  struct Angle {
    int index = -1, mirror = -1;  ///< mirror: -1 when it has none of its own
    double sign = 1;              ///< mirror's angle = sign * this one's
    double low = 0, high = 0;
  };
  struct Scale {
    int bone = -1, mirror = -1;
  };
  void find_angles();
  void find_scales();
  void add_angle(int index, int mirror, double sign);

  const Character& character_;
  Options options_;
  int normal_ = 0;                ///< axis of the target's mirror plane
  int root_count_ = 6;
  std::vector<Angle> angles_;
  std::vector<Scale> scales_;
  std::vector<double> low_, high_;  ///< limits of each angle of the character
};

}  // namespace transformables
