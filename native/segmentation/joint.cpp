#include "segmentation/joint.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "segmentation/surfaces.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kWellInside = 0.9;   // share of a cell's corners, by trilinear weight

Eigen::Isometry3d motion_at(const Character& character, const Embedding& embedding, const Eigen::Isometry3d& folded, int bone, int hinge, double angle) {
  Pose pose = embedding.pose;
  pose.angles[character.bones[bone].first_angle + hinge] = angle;
  return forward_kinematics(character, pose, embedding.morphology)[bone] * folded.inverse();
}

void add_range(const Character& character, const Embedding& embedding, const Eigen::Isometry3d& folded, const JointRange& range, int samples, Joint& joint) {
  const double now = embedding.pose.angles[character.bones[range.bone].first_angle + range.hinge];
  for (int k = 0; k < samples; ++k) {
    const double angle = samples == 1 ? range.to_rad : range.from_rad + (range.to_rad - range.from_rad) * k / (samples - 1);
    if (std::abs(angle - now) > 1e-9) joint.motions.push_back(motion_at(character, embedding, folded, range.bone, range.hinge, angle));
  }
  auto turn = std::find_if(joint.turns.begin(), joint.turns.end(), [&](const JointTurn& t) { return t.hinge == range.hinge; });
  if (turn == joint.turns.end()) {
    const Eigen::Isometry3d nudge = motion_at(character, embedding, folded, range.bone, range.hinge, now + 0.5);
    turn = joint.turns.insert(turn, {range.hinge, Eigen::AngleAxisd(Eigen::Matrix3d(nudge.linear())).axis()});
  }
  turn->from_rad = std::min({turn->from_rad, range.from_rad - now, range.to_rad - now});
  turn->to_rad = std::max({turn->to_rad, range.from_rad - now, range.to_rad - now});
}

int depth_of(const Character& character, int bone) {
  int depth = 0;
  for (int b = bone; character.bones[b].parent >= 0; b = character.bones[b].parent) ++depth;
  return depth;
}

// A sample on its circle about the hinge.
struct OnRing {
  long ring;
  double angle;
  std::size_t sample;
  bool giver, fixed;
};

std::vector<OnRing> rings(const std::vector<std::int16_t>& owner, const Target& target, const Skeleton& skeleton, const Joint& joint, int giver, int taker) {
  const GridShape& shape = target.distance.shape;
  const Eigen::Vector3d axis = joint.turns.front().axis, e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
  std::vector<OnRing> all;
  for (std::size_t i : target.inside) {
    if (owner[i] != giver && owner[i] != taker) continue;
    const Eigen::Vector3d r = shape.position(i) - joint.centre;
    const long along = std::lround(r.dot(axis) / shape.step), out = std::lround(joint.radius_of(shape.position(i)) / shape.step);
    if (out == 0) continue;
    const bool gives = owner[i] == giver;
    all.push_back({along * 4096 + out, std::atan2(r.dot(e2), r.dot(e1)), i, gives, gives && is_protected(skeleton, shape, giver, i)});
  }
  std::sort(all.begin(), all.end(), [](const OnRing& a, const OnRing& b) { return a.ring != b.ring ? a.ring < b.ring : a.sample < b.sample; });
  return all;
}

// True when turning by some angle of [from, to] brings `a` to `b`; half a sample's width either way is no motion.
bool reaches(double a, double b, double from, double to, double width) {
  constexpr double kTurn = 2 * 3.14159265358979323846;
  for (double turn = b - a - kTurn; turn <= b - a + 1.5 * kTurn; turn += kTurn)
    if (std::abs(turn) > 0.5 * width && turn > from - 0.25 * width && turn < to + 0.25 * width) return true;
  return false;
}

}  // namespace

std::vector<Joint> joints_of(const Character& character, const Embedding& embedding, const std::vector<JointRange>& ranges, int samples) {
  const std::vector<Eigen::Isometry3d> frames = forward_kinematics(character, embedding.pose, embedding.morphology);
  std::map<int, Joint> by_bone;
  for (const JointRange& range : ranges) {
    if (range.bone < 1 || range.bone >= int(character.bones.size()) || range.hinge < 0 ||
        range.hinge >= int(character.bones[range.bone].hinges.size()))
      throw InvalidInput("transfer: a joint range names a bone or hinge that does not exist; the root has none");
    if (!std::isfinite(range.from_rad) || !std::isfinite(range.to_rad))
      throw InvalidInput("transfer: the range of bone '" + character.bones[range.bone].name + "' is not finite");
    Joint& joint = by_bone[range.bone];
    joint.child = range.bone;
    joint.parent = character.bones[range.bone].parent;
    joint.centre = frames[range.bone].translation();
    joint.single = character.bones[range.bone].hinges.size() == 1;
    add_range(character, embedding, frames[range.bone], range, samples, joint);
  }
  std::vector<Joint> joints;
  for (auto& [bone, joint] : by_bone)
    if (!joint.motions.empty()) joints.push_back(std::move(joint));
  std::stable_sort(joints.begin(), joints.end(), [&](const Joint& a, const Joint& b) {
    return depth_of(character, a.child) > depth_of(character, b.child);
  });
  return joints;
}

Collisions collisions(const Segmentation& segmentation, const Target& target, const Joint& joint) {
  std::vector<std::size_t> part;
  for (std::size_t i : target.inside)
    if (segmentation.owner[i] == joint.child) part.push_back(i);
  std::vector<int> times(part.size(), 0);
  const Grid<float>& parent = segmentation.phi[joint.parent];
  tbb::parallel_for(std::size_t(0), part.size(), [&](std::size_t k) {
    const Eigen::Vector3d p = segmentation.shape.position(part[k]);
    for (const Eigen::Isometry3d& motion : joint.motions) {
      const Eigen::Vector3d q = motion * p;
      times[k] += value_at(parent, q) < 0 && value_at(target.distance, q) < 0;
    }
  });
  Collisions found;
  for (std::size_t k = 0; k < part.size(); ++k)
    if (times[k] > 0) found.samples.push_back(part[k]), found.times.push_back(times[k]), found.total += times[k];
  return found;
}

long collisions_by_owner(const std::vector<std::int16_t>& owner, const Target& target, const Joint& joint) {
  const GridShape& shape = target.distance.shape;
  std::vector<std::size_t> part;
  for (std::size_t i : target.inside)
    if (owner[i] == joint.child) part.push_back(i);
  std::vector<int> times(part.size(), 0);
  const auto share = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d q = (p - shape.origin) / shape.step;
    if ((q.array() < 0).any() || (q.array() >= shape.size.cast<double>().array() - 1).any()) return 0.0;
    const Eigen::Vector3i c = q.cast<int>();
    const Eigen::Vector3d t = q - c.cast<double>();
    double sum = 0;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3i o(k & 1, k >> 1 & 1, k >> 2);
      if (owner[shape.index(c + o)] != joint.parent) continue;
      double weight = 1;
      for (int a = 0; a < 3; ++a) weight *= o[a] ? t[a] : 1 - t[a];
      sum += weight;
    }
    return sum;
  };
  tbb::parallel_for(std::size_t(0), part.size(), [&](std::size_t k) {
    const Eigen::Vector3d p = shape.position(part[k]);
    for (const Eigen::Isometry3d& motion : joint.motions) times[k] += share(motion * p) > kWellInside;
  });
  long total = 0;
  for (int t : times) total += t;
  return total;
}

// Turning keeps a sample on its circle, so each circle is settled by itself and rounding can't leak from one to the next.
std::vector<std::int16_t> exact_transfer(const std::vector<std::int16_t>& owner, const Target& target, const Skeleton& skeleton,
                                         const Joint& joint, bool child_to_parent) {
  const int giver = child_to_parent ? joint.child : joint.parent, taker = child_to_parent ? joint.parent : joint.child;
  const JointTurn& turn = joint.turns.front();
  std::vector<OnRing> all = rings(owner, target, skeleton, joint, giver, taker);
  std::vector<std::int16_t> result = owner;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].ring == all[begin].ring) ++end;
    const double width = 1.0 / double(std::max(1L, all[begin].ring & 4095));
    std::vector<std::size_t> open;
    for (std::size_t k = begin; k < end; ++k)
      if (!all[k].giver) open.push_back(k);
    while (!open.empty()) {
      const OnRing taken = all[open.back()];
      open.pop_back();
      for (std::size_t k = begin; k < end; ++k) {
        if (!all[k].giver || all[k].fixed) continue;
        const bool meets = child_to_parent ? reaches(all[k].angle, taken.angle, turn.from_rad, turn.to_rad, width)
                                           : reaches(taken.angle, all[k].angle, turn.from_rad, turn.to_rad, width);
        if (meets) all[k].giver = false, result[all[k].sample] = std::int16_t(taker), open.push_back(k);
      }
    }
  }
  return result;
}

}  // namespace transformables::segmentation_inner
