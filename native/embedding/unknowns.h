// What the optimiser varies, as one vector of numbers of like size, and the pose and morphology it stands for.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "character/character.h"
#include "embedding/embedding.h"
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
/// not lead out of it. Locked angles and kept scales are no unknowns; when a bone is pinned, neither is the root: it
/// follows from the pinned bone's frame.
class Unknowns {
 public:
  /// @param target   only its mirror axis is looked at; both need a mirror plane when symmetric
  /// @param options  checked: locks, pins and proportions of bones and angles that exist
  Unknowns(const Character& character, const Target& target, const EmbeddingOptions& options, bool symmetric);

  int count() const { return root_count_ + int(angles_.size()) + int(scales_.size()); }
  int root_count() const { return root_count_; }
  /// Of each unknown: the bone that it turns or scales, or the first of two that are mirror images; the root for the root's own.
  const std::vector<int>& bones() const { return bones_; }

  /// `pose.angles` and `morphology` must have their sizes; nothing is allocated.
  void read(const Eigen::VectorXd& y, const StartPlace& start, Pose& pose, Morphology& morphology) const;

  /// A start and numbers that give this pose (when symmetric: its nearest symmetric one).
  Eigen::VectorXd write(const Pose& pose, const Morphology& morphology, StartPlace& start) const;

  /// The 24 turns of a cube, or when symmetric those that keep the mirror planes together; one when a bone is pinned.
  std::vector<Eigen::Matrix3d> start_rotations() const;

 private:
  struct Angle {
    int index = -1, mirror = -1;  ///< mirror: -1 when it has none of its own
    double sign = 1;              ///< mirror's angle = sign * this one's
    double low = 0, high = 0;
  };
  struct Scale {
    int bone = -1, mirror = -1;
    double low = 0, high = 0;   ///< of the logarithm
  };
  void find_locks(const EmbeddingOptions& options);
  void find_angles();
  void find_scales(const EmbeddingOptions& options);
  void find_bones();
  void find_anchor(const std::vector<PinnedBone>& pinned);
  void add_angle(int index, int mirror, double sign);
  void read_root(const Eigen::VectorXd& y, const StartPlace& start, Pose& pose) const;
  Eigen::Isometry3d in_root(const Pose& pose, const Morphology& morphology) const;

  const Character& character_;
  bool symmetric_ = false;
  int normal_ = 0;                ///< axis of the target's mirror plane
  int root_count_ = 6;
  std::vector<Angle> angles_;
  std::vector<Scale> scales_;
  std::vector<int> bones_;
  std::vector<double> low_, high_;  ///< limits of each angle of the character
  std::vector<double> kept_;        ///< each angle's value when it is no unknown
  std::vector<char> locked_;        ///< of each angle
  Morphology kept_scales_;
  std::vector<int> anchor_path_;    ///< from the root's child to the pinned bone
  bool anchored_ = false;
  Eigen::Isometry3d anchor_ = Eigen::Isometry3d::Identity();
};

}  // namespace transformables
