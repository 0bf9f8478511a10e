#include "finishing/relative_motion.h"

#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

Eigen::Isometry3d about(int axis, double angle) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)));
}

/// From a bone's unturned frame to its parent's.
Eigen::Isometry3d rest_of(const Character& character, const Morphology& morphology, int bone) {
  const Bone& b = character.bones[bone];
  Eigen::Isometry3d rest(b.rest_in_parent.toRotationMatrix());
  rest.translation() = morphology[b.parent] * b.head_in_parent;
  return rest;
}

std::vector<int> line_of(const Character& character, int bone) {
  std::vector<int> line;
  for (int b = bone; b >= 0; b = character.bones[b].parent) line.push_back(b);
  return line;
}

}  // namespace

RelativeMotion::RelativeMotion(const Character& character, const Morphology& morphology, const Move& move, const Eigen::VectorXd& start,
                               int a, int b)
    : fixed_{Eigen::Isometry3d::Identity()} {
  std::vector<int> up = line_of(character, a), down = line_of(character, b);
  while (!up.empty() && !down.empty() && up.back() == down.back()) {
    up.pop_back();
    down.pop_back();
  }
  for (const int bone : up) go_up(character, morphology, move, start, bone);
  for (auto bone = down.rbegin(); bone != down.rend(); ++bone) go_down(character, morphology, move, start, *bone);
  if (!moves()) return;
  near_a_ = end_of(false);
  near_b_ = end_of(true);
}

void RelativeMotion::go_up(const Character& character, const Morphology& morphology, const Move& move, const Eigen::VectorXd& start,
                           int bone) {
  // X acts first (character.h: Z Y X).
  const Bone& b = character.bones[bone];
  for (std::size_t h = 0; h < b.hinges.size(); ++h) turn_by(move, b, start, int(h), 1);
  fix(rest_of(character, morphology, bone));
}

void RelativeMotion::go_down(const Character& character, const Morphology& morphology, const Move& move, const Eigen::VectorXd& start,
                             int bone) {
  const Bone& b = character.bones[bone];
  fix(rest_of(character, morphology, bone).inverse(Eigen::Isometry));
  for (std::size_t h = b.hinges.size(); h-- > 0;) turn_by(move, b, start, int(h), -1);
}

void RelativeMotion::turn_by(const Move& move, const Bone& bone, const Eigen::VectorXd& start, int hinge, int sign) {
  const int angle = bone.first_angle + hinge, axis = bone.hinges[hinge].axis;
  for (const Move::Turn& turn : move.turns)
    if (turn.angle == angle && turn.from_rad != turn.to_rad) {
      joints_.push_back({axis, sign * turn.from_rad, sign * (turn.to_rad - turn.from_rad)});
      fixed_.push_back(Eigen::Isometry3d::Identity());
      return;
    }
  fix(about(axis, sign * start[angle]));
}

Instant RelativeMotion::at(double t) const {
  Instant now;
  now.spin.setZero();
  now.drift.setZero();
  // From B backwards: `after` is what follows the joint.
  Eigen::Isometry3d after = fixed_.back();
  for (std::size_t n = joints_.size(); n-- > 0;) {
    const Joint& joint = joints_[n];
    const Eigen::Vector3d spin = joint.rate * after.linear().col(joint.axis);
    now.spin += spin;
    now.drift -= spin.cross(after.translation());
    after = after * about(joint.axis, joint.from + t * joint.rate) * fixed_[n];
  }
  now.turn = after.linear();
  now.shift = after.translation();
  return now;
}

RelativeMotion::End RelativeMotion::end_of(bool at_b) const {
  End end;
  const std::size_t count = joints_.size();
  const Eigen::Isometry3d out = at_b ? fixed_.back() : fixed_.front().inverse(Eigen::Isometry);
  const auto joint = [&](std::size_t n) -> const Joint& { return at_b ? joints_[count - 1 - n] : joints_[n]; };
  const auto link = [&](std::size_t n) { return (at_b ? fixed_[count - 1 - n] : fixed_[n + 1]).translation().norm(); };
  end.head = out.translation();
  end.axis = out.linear().col(joint(0).axis);
  end.first_rate = std::abs(joint(0).rate);
  double length = 0, rates = 0;
  for (std::size_t n = 1; n < count; ++n) rates += std::abs(joint(n).rate);
  end.other_rates = rates;
  // Two joints that follow each other sit on one rigid body, so the link between keeps its length; it is turned by all joints
  // beyond it, and its second derivative is at most the square of the sum of their rates times its length.
  for (std::size_t n = 1; n < count; ++n) {
    length += link(n - 1);
    end.chain_speed += std::abs(joint(n).rate) * length;
    end.chain_acceleration += rates * rates * link(n - 1);
    rates -= std::abs(joint(n).rate);
  }
  return end;
}

RelativeMotion::Reach RelativeMotion::reach(const End& end, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d arm = centre - end.head;
  const double lever = arm.cross(end.axis).norm() + radius;
  if (end.other_rates == 0) return {end.first_rate * lever, end.first_rate * end.first_rate * lever};
  const double far = arm.norm() + radius, all = end.first_rate + end.other_rates;
  return {end.first_rate * lever + end.other_rates * far + end.chain_speed, all * all * far + end.chain_acceleration};
}

}  // namespace transformables::finishing
