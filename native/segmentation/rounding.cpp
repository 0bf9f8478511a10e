#include "segmentation/rounding.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "segmentation/lattice.h"
#include "segmentation/layers.h"

namespace transformables::segmentation_inner {
namespace {

constexpr int kPasses = 8;           // what changes on one circle changes what its neighbours read
constexpr float kNear = 2;           // steps: half difference of samples that are looked at
constexpr float kShared = 1;         // steps: no third part is nearer than the farther of the two by more
constexpr float kThird = 0.2f;       // steps: with a third part as near as that, both level sets are shifted, not set
constexpr float kCap = 1.25f;        // steps: half differences beyond count as this
constexpr float kOutside = 1.8f;     // steps from the target's surface: the farthest sample of a cell that it crosses
constexpr float kFar = 1e9f;
constexpr double kArc = 0.5;         // steps between two places of a circle
constexpr double kWidest = 0.15;     // radians, the same
constexpr double kAxis = 0.75;       // steps: circles that are smaller say nothing
constexpr double kLeastTurn = 1e-3;  // radians
constexpr double kPi = 3.14159265358979323846;

/// The interface of one joint's parts: samples near it, and on which side of it each is (negative: the child's).
class Interface {
 public:
  Interface(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Joint& joint)
      : s_(segmentation), target_(target), skeleton_(skeleton), joint_(joint), step_(float(segmentation.shape.step)) {
    for (std::size_t i : target.inside)
      if ((s_.owner[i] == joint.child || s_.owner[i] == joint.parent) && !s_.is_pinned(i) && is_near(i)) samples_.push_back(i);
  }

  /// Goes on outside the target as far as a sample, where level sets are read between those inside and those outside.
  /// @param held  flags of the samples that stay (beside_pinned)
  void go_outside(const std::vector<ShellSample>& shell, const std::vector<char>& held);

  void smooth();
  void round_off(const JointTurn& turn);

 private:
  bool is_near(std::size_t sample) const {
    const auto [child, parent] = both(s_.shape.position(sample));
    return std::abs(child - parent) < 2 * kNear * step_ && std::max(child, parent) < kShared * step_;
  }
  std::array<float, 2> both(const Eigen::Vector3d& p) const {
    const float far = 4 * step_;
    return {std::min(value_at(s_.phi[joint_.child], p), far), std::min(value_at(s_.phi[joint_.parent], p), far)};
  }
  float side(const Eigen::Vector3d& p) const {
    const auto [child, parent] = both(p);
    return 0.5f * (child - parent);
  }
  template <class Value>
  void set_all(const Value& value);
  void set(std::size_t sample, float v);
  float fitted(const JointTurn& turn, std::size_t sample, bool counts, std::vector<float>& sides) const;
  bool shared(const Eigen::Vector3d& p) const;
  void walk(const Eigen::Vector3d& p, const Eigen::Vector3d& axis, double reach, std::vector<float>& sides) const;

  Segmentation& s_;
  const Target& target_;
  const Skeleton& skeleton_;
  const Joint& joint_;
  float step_;
  std::vector<std::size_t> samples_;
};

// All new values are found from the old ones.
template <class Value>
void Interface::set_all(const Value& value) {
  constexpr std::size_t kChunk = 64;
  std::vector<float> values(samples_.size());
  tbb::parallel_for(std::size_t(0), (samples_.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    std::vector<float> scratch;
    for (std::size_t k = chunk * kChunk; k < std::min(samples_.size(), (chunk + 1) * kChunk); ++k) values[k] = value(samples_[k], scratch);
  });
  for (std::size_t k = 0; k < samples_.size(); ++k) set(samples_[k], values[k]);
}

void Interface::set(std::size_t sample, float v) {
  const auto [child, parent] = both(s_.shape.position(sample));
  if (std::abs(v) < kLeast * step_) v = std::copysign(kLeast * step_, v);
  const int taker = v > 0 ? joint_.parent : joint_.child;
  const bool inside = s_.owner[sample] >= 0;
  if (inside && taker != s_.owner[sample] && (skeleton_.core[sample] == s_.owner[sample] || !s_.may_grow(taker))) return;
  float middle = 0.5f * (child + parent);
  if (std::abs(middle) < kThird * step_) middle = 0;
  const auto put = [&](Grid<float>& phi, float value) {
    const Eigen::Vector3i c = s_.shape.cell(sample) - s_.shape.nearest(phi.shape.origin);
    if (phi.shape.contains(c)) phi.at(c) = std::clamp(value, -kBand * step_, kBand * step_);
  };
  put(s_.phi[joint_.child], middle + v);
  put(s_.phi[joint_.parent], middle - v);
  if (inside) s_.owner[sample] = std::int16_t(taker);
}

// A step of diffusion: without it, least largest changes leave creases that no lattice can hold.
void Interface::smooth() {
  set_all([&](std::size_t i, std::vector<float>&) {
    float sum = 0;
    int count = 0;
    for_neighbours(s_.shape, i, [&](std::size_t n) {
      if (target_.distance[n] < 0) sum += side(s_.shape.position(n)), ++count;
    });
    const float v = side(s_.shape.position(i));
    return count > 0 ? 0.5f * (v + sum / float(count)) : v;
  });
}

bool Interface::shared(const Eigen::Vector3d& p) const {
  const Eigen::Vector3i c = s_.shape.nearest(p);
  if (!s_.shape.contains(c) || value_at(target_.distance, p) >= 0) return false;
  const int owner = s_.owner[s_.shape.index(c)];
  return owner == joint_.child || owner == joint_.parent;
}

// Sides along a circle from a point on, as far as the two parts go on without a gap that is wider than the joint's range.
void Interface::walk(const Eigen::Vector3d& p, const Eigen::Vector3d& axis, double reach, std::vector<float>& sides) const {
  const Eigen::Vector3d r = p - joint_.centre, along = r.dot(axis) * axis, out = r - along, across = axis.cross(out);
  const double arc = std::min(kArc * step_ / out.norm(), kWidest);
  double last = 0;
  sides.clear();
  for (double angle = arc; angle < kPi && angle - last <= reach; angle += arc) {
    const Eigen::Vector3d q = joint_.centre + along + std::cos(angle) * out + std::sin(angle) * across;
    if (!shared(q)) continue;
    sides.push_back(side(q));
    last = angle;
  }
}

// The value of the best sequence at a sample, in the middle of the sides before and behind it; `counts`: its own is one of them.
float Interface::fitted(const JointTurn& turn, std::size_t sample, bool counts, std::vector<float>& sides) const {
  const double forth = std::max(turn.to_rad, 0.0), back = std::max(-turn.from_rad, 0.0), reach = std::max(forth, back);
  const bool both_ways = std::min(forth, back) > kLeastTurn;
  const Eigen::Vector3d axis = forth > back ? turn.axis : Eigen::Vector3d(-turn.axis);
  const Eigen::Vector3d p = s_.shape.position(sample), r = p - joint_.centre;
  const float v = side(p), cap = kCap * step_;
  if (reach < kLeastTurn || (r - r.dot(axis) * axis).norm() < kAxis * step_) return v;
  float most = counts ? std::clamp(v, -cap, cap) : -kFar, least = counts ? most : kFar;
  for (const bool ahead : {true, false}) {
    walk(p, ahead ? axis : Eigen::Vector3d(-axis), reach, sides);
    for (const float other : sides) {
      if (ahead || both_ways) most = std::max(most, std::min(other, cap));
      if (!ahead || both_ways) least = std::min(least, std::max(other, -cap));
    }
  }
  if (most == -kFar || least == kFar) return most > -kFar ? most : least < kFar ? least : v;
  const float best = 0.5f * (most + least);
  return (best > 0) == (v > 0) && std::abs(v) > cap ? v : best;
}

void Interface::round_off(const JointTurn& turn) {
  set_all([&](std::size_t i, std::vector<float>& sides) { return fitted(turn, i, true, sides); });
}

void Interface::go_outside(const std::vector<ShellSample>& shell, const std::vector<char>& held) {
  samples_.clear();
  for (const ShellSample& o : shell)
    if (target_.distance[o.index] < kOutside * step_ && (held.empty() || !held[o.index]) && is_near(o.index)) samples_.push_back(o.index);
  for (const JointTurn& turn : joint_.turns)
    set_all([&](std::size_t i, std::vector<float>& sides) { return fitted(turn, i, false, sides); });
}

bool both_there(const Segmentation& segmentation, const Joint& joint) {
  return !segmentation.phi[joint.child].values.empty() && !segmentation.phi[joint.parent].values.empty();
}

void go_outside(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                const std::vector<char>& held, int threads) {
  tbb::task_arena arena(arena_size(threads));
  arena.execute([&] {
    for (const Joint& joint : joints)
      if (both_there(segmentation, joint)) Interface(segmentation, target, skeleton, joint).go_outside(surfaces.shell(), held);
  });
}

}  // namespace

void round_outside(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                   int threads) {
  go_outside(segmentation, target, skeleton, surfaces, joints, beside_pinned(segmentation), threads);
}

Found round_joints(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                  int threads) {
  const std::vector<char> held = beside_pinned(segmentation), bones = bones_of(joints, segmentation.phi.size());
  tbb::task_arena arena(arena_size(threads));
  for (int pass = 0; pass < kPasses; ++pass) {
    arena.execute([&] {
      for (const Joint& joint : joints) {
        if (!both_there(segmentation, joint)) continue;
        Interface interface(segmentation, target, skeleton, joint);
        if (pass > 0 && pass + 1 < kPasses) interface.smooth();
        for (const JointTurn& turn : joint.turns) interface.round_off(turn);
      }
    });
    const bool last = pass + 1 == kPasses;   // before, nothing is read farther outside
    surfaces.settle_tiling(segmentation, skeleton.core, bones, threads, last ? kAllOutside : kOutside);
    go_outside(segmentation, target, skeleton, surfaces, joints, held, threads);
  }
  return part_layers(segmentation, target, skeleton, surfaces, joints, threads);
}

}  // namespace transformables::segmentation_inner
