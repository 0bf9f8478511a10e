// One joint's motion, and what its parent's and child's parts do to each other on the way (Eq. 11). Inner to the room.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <vector>

#include "embedding/embedding.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"

namespace transformables::segmentation_inner {

/// One hinge of a joint, the others standing at their folded angles.
struct JointTurn {
  int hinge = 0;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();      ///< target frame
  double from_rad = 0, to_rad = 0;                      ///< range relative to the folded angle; holds 0
};

struct Joint {
  int child = 0, parent = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();     ///< target frame
  bool single = true;                                   ///< one hinge
  std::vector<JointTurn> turns;                         ///< a hinge each, of those that have ranges
  std::vector<Eigen::Isometry3d> motions;               ///< T' configurations: where the folded child goes, target frame

  /// Distance from the hinge's axis, or from the joint when there are several hinges: what R of Eq. 8 is compared with.
  double radius_of(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d r = p - centre;
    return single ? (r - r.dot(turns.front().axis) * turns.front().axis).norm() : r.norm();
  }
};

/// The joints that have ranges, leaves first.
std::vector<Joint> joints_of(const Character& character, const Embedding& embedding, const std::vector<JointRange>& ranges, int samples);

/// Flags of the bones that take part in some joints.
std::vector<char> bones_of(const std::vector<Joint>& joints, std::size_t bones);

/// Points of the child's part that lie in the parent's part in some of the motions.
struct Collisions {
  std::vector<Eigen::Vector3d> points;   ///< folded, target frame
  std::vector<int> times;                ///< for each, in how many motions
  double mean = 0;                       ///< volume, mean over the motions, cubic target units
};

/// Of some joints, by child.
using Found = std::map<int, Collisions>;

/// @param finer  points stand half a step apart, none on a sample: for level sets that differ by fractions of a step. Else every sample is one
Collisions collisions(const Segmentation& segmentation, const Target& target, const Joint& joint, bool finer);

/// Tells whether points are in parts, as long as the boxes of the level sets stay what they are; refers to both.
class Membership {
 public:
  Membership(const Segmentation& segmentation, const Target& target);

  /// In the target, with no other level set as low. Among samples of one part alone, whose level set is negative there and no other's is,
  /// only owners are looked at.
  bool is_in(int bone, const Eigen::Vector3d& p) const;

 private:
  struct Box {
    Eigen::Vector3i low, end;   // of the samples, in the target's grid
  };
  float read(const Grid<float>& grid, const Box& box, const Eigen::Vector3i& cell, const Eigen::Vector3f& t) const;

  const Segmentation& segmentation_;
  const Target& target_;
  std::vector<Box> boxes_;
};

/// The same mean when only owners are known (a candidate): a sample counts when it is well inside the other part.
double collisions_by_owner(const std::vector<std::int16_t>& owner, const Target& target, const Joint& joint);

/// Owners after the exact alternative: every sample of the giving bone whose arc over the joint's range meets the taking bone's part goes
/// there, to a fixed point; an arc shorter than a sample meets the next sample. Only for a single hinge.
std::vector<std::int16_t> exact_transfer(const std::vector<std::int16_t>& owner, const Target& target, const Skeleton& skeleton,
                                         const Joint& joint, bool child_to_parent);

}  // namespace transformables::segmentation_inner
