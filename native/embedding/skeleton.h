// The character's capsules in a pose, laid out flat for the objective: kinematics, hinge axes and collisions (Eq. 4).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

#include "character/character.h"

namespace transformables {

/// How deep capsules are in one another.
struct CapsuleCollisions {
  double sum_of_squares = 0;  ///< Eq. 4, with what joined bones overlap beyond their joint
  double sum = 0;             ///< of the same depths
  double deepest = 0;         ///< of bones that are not joined
};

/// One object a thread. `set` fills the arrays in place: forward_kinematics (character.h) gives the same frames, but
/// allocates, and does not tell the axes of hinges.
class Skeleton {
 public:
  struct PosedSegment {
    Eigen::Vector3d a = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::Zero();  ///< direction: unit, or zero when the length is
    double length = 0;
  };

  explicit Skeleton(const Character& character);

  void set(const Pose& pose, const Morphology& morphology);
  CapsuleCollisions collisions() const;
  /// Squared distance from a bone's axis; `at` becomes the nearest of its segments.
  inline double distance2(int bone, const Eigen::Vector3d& p, int& at) const;
  /// Pairs of bones that may collide, joined ones among them, and how deep one is in the other: 0 when they don't touch.
  std::size_t pair_count() const { return pairs_.size(); }
  double depth(std::size_t pair) const { return depth(pairs_[pair]); }
  /// Calls visit(i, j, depth) for each pair of bones i < j, not joined, whose capsules are in one another.
  template <class Visit>
  void for_each_collision(const Visit& visit) const {
    for (const Pair& pair : pairs_)
      if (const double deep = pair.joined ? 0 : depth(pair); deep > 0) visit(pair.i, pair.j, deep);
  }

  const Character& character;
  std::vector<Eigen::Matrix3d> rotations;       ///< of each bone's frame, target frame
  std::vector<Eigen::Vector3d> heads;           ///< of each bone
  std::vector<Eigen::Vector3d> hinge_axes;      ///< unit, target frame, one an angle of the pose
  std::vector<PosedSegment> segments;           ///< of bone i: from first_segment[i] up to first_segment[i + 1]
  std::vector<int> first_segment;
  double largest_radius = 0;

 private:
  struct Link {                                 ///< `length` times the scale of `bone`
    int bone;
    double length;
  };
  struct Pair {
    int i, j;                                   ///< i < j
    bool joined;                                ///< parent and child
    bool trim_first;                            ///< neither is the other's ancestor: both start near their common joint
    int first_link, end_link;                   ///< the way between them, through the bones that join them
  };
  void add_pair(int i, int j);
  double trim(const Pair& pair) const;
  double gap(const Pair& pair) const;
  bool apart(const Pair& pair) const;
  double depth(const Pair& pair) const;

  std::vector<Segment> rest_;                   ///< as `segments`, in bone frames, scale 1
  std::vector<Pair> pairs_;
  std::vector<Link> links_;
  std::vector<double> scales_, reach_;          ///< reach: how far a bone's segments go from its head
};

inline double Skeleton::distance2(int bone, const Eigen::Vector3d& p, int& at) const {
  double least = std::numeric_limits<double>::infinity();
  const int end = first_segment[std::size_t(bone) + 1];
  for (int s = first_segment[std::size_t(bone)]; s < end; ++s) {
    const PosedSegment& segment = segments[std::size_t(s)];
    const Eigen::Vector3d from = p - segment.a;
    const double free = from.dot(segment.direction), along = std::clamp(free, 0.0, segment.length);
    const double square = from.squaredNorm() - along * (2 * free - along);
    if (square >= least) continue;
    least = square;
    at = s;
  }
  return std::max(least, 0.0);
}

}  // namespace transformables
