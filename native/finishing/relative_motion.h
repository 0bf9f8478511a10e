// How one bone moves against another in a move: turns about fixed axes, one after the other along the tree.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "character/character.h"
#include "folding/folding.h"

namespace transformables::finishing {

/// Where A's frame is in B's, and how points fixed to A move there: velocity of p (in B's frame) is spin x p + drift.
struct Instant {
  Eigen::Matrix3d turn;
  Eigen::Vector3d shift, spin, drift;
};

class RelativeMotion {
 public:
  /// @param start  all angles at the move's beginning
  RelativeMotion(const Character& character, const Morphology& morphology, const Move& move, const Eigen::VectorXd& start, int a, int b);

  bool moves() const { return !joints_.empty(); }
  Instant at(double t) const;

  /// What bounds the motion of points fixed to one of the two, as seen from the other, over the whole move.
  struct Reach {
    double speed = 0, acceleration = 0;
  };
  /// @param centre, radius  of a ball in A's own frame (B's, for `of_b`), which holds the points
  Reach of_a(const Eigen::Vector3d& centre, double radius) const { return reach(near_a_, centre, radius); }
  Reach of_b(const Eigen::Vector3d& centre, double radius) const { return reach(near_b_, centre, radius); }

 private:
  struct Joint {
    int axis = 0;                 // of the frame before it
    double from = 0, rate = 0;    // rate: radians in the whole move
  };
  /// The chain as it is met from one end.
  struct End {
    Eigen::Vector3d head = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitX();  // of the nearest joint, in that end's frame
    double first_rate = 0, other_rates = 0;
    double chain_speed = 0, chain_acceleration = 0;                                   // of the links beyond
  };
  void go_up(const Character&, const Morphology&, const Move&, const Eigen::VectorXd&, int bone);
  void go_down(const Character&, const Morphology&, const Move&, const Eigen::VectorXd&, int bone);
  void turn_by(const Move& move, const Bone& bone, const Eigen::VectorXd& start, int hinge, int sign);
  void fix(const Eigen::Isometry3d& step) { fixed_.back() = step * fixed_.back(); }
  End end_of(bool at_b) const;
  static Reach reach(const End& end, const Eigen::Vector3d& centre, double radius);

  // A point of A is taken to B by fixed_[0], joints_[0], fixed_[1], and so on.
  std::vector<Eigen::Isometry3d> fixed_;
  std::vector<Joint> joints_;
  End near_a_, near_b_;
};

}  // namespace transformables::finishing
