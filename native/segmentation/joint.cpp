#include "segmentation/joint.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "segmentation/surfaces.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kLeastTurn = 1e-3;   // radians: less is no turn
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

// True when turning by some angle of [from, to] brings `a` to `b`; half a sample's width either way is no motion, and a shorter motion as long as that to the next sample.
bool reaches(double a, double b, double from, double to, double width) {
  constexpr double kTurn = 2 * 3.14159265358979323846;
  if (from < -kLeastTurn) from = std::min(from, -width);
  if (to > kLeastTurn) to = std::max(to, width);
  for (double turn = b - a - kTurn; turn <= b - a + 1.5 * kTurn; turn += kTurn)
    if (std::abs(turn) > 0.5 * width && turn > from - 0.25 * width && turn < to + 0.25 * width) return true;
  return false;
}

/// The cells of the lattice that a part is in or near: most points are told by these that they are not in it, nor are those within half a step of them.
class Cells {
 public:
  Cells(const Segmentation& segmentation, int bone) : phi_(segmentation.phi[bone]), near_(phi_.values.size(), 0) {
    const std::size_t row = std::size_t(phi_.shape.size.x()), slice = row * std::size_t(phi_.shape.size.y());
    const float near = float(2 * phi_.shape.step);
    for (std::size_t i = 0; i + slice + row + 1 < phi_.values.size(); ++i)
      for (const std::size_t k : {i, i + 1, i + row, i + row + 1, i + slice, i + slice + 1, i + slice + row, i + slice + row + 1}) near_[i] |= phi_[k] <= near;
  }
  bool may_be_near(const Eigen::Vector3d& p) const { return may_be_near_steps((p - phi_.shape.origin) / phi_.shape.step); }
  /// The same of a point in steps from the level set's first sample.
  bool may_be_near_steps(const Eigen::Vector3d& q) const {
    const Eigen::Vector3i& size = phi_.shape.size;
    if (!(q.x() >= 0 && q.y() >= 0 && q.z() >= 0 && q.x() < size.x() - 1 && q.y() < size.y() - 1 && q.z() < size.z() - 1)) return false;
    return near_[phi_.shape.index(int(q.x()), int(q.y()), int(q.z()))];
  }
  /// A motion that takes points to where they are then, in such steps.
  Eigen::Affine3d in_steps(const Eigen::Isometry3d& motion) const {
    return Eigen::Scaling(1 / phi_.shape.step) * Eigen::Translation3d(-phi_.shape.origin) * Eigen::Affine3d(motion);
  }

 private:
  const Grid<float>& phi_;
  std::vector<char> near_;
};

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

std::vector<char> bones_of(const std::vector<Joint>& joints, std::size_t bones) {
  std::vector<char> flags(bones, 0);
  for (const Joint& joint : joints) flags[std::size_t(joint.child)] = flags[std::size_t(joint.parent)] = 1;
  return flags;
}

Membership::Membership(const Segmentation& segmentation, const Target& target) : segmentation_(segmentation), target_(target) {
  for (const Grid<float>& phi : segmentation.phi) {
    const Eigen::Vector3i low = phi.values.empty() ? segmentation.shape.size : segmentation.shape.nearest(phi.shape.origin);
    boxes_.push_back({low, low + phi.shape.size});
  }
}

// Trilinear in the cell that begins at a sample; far outside of the box.
float Membership::read(const Grid<float>& grid, const Box& box, const Eigen::Vector3i& cell, const Eigen::Vector3f& t) const {
  const Eigen::Vector3i c = cell - box.low;
  if ((c.array() < 0).any() || (cell.array() + 1 >= box.end.array()).any()) return 1e9f;
  const std::size_t dy = std::size_t(grid.shape.size.x()), dz = dy * std::size_t(grid.shape.size.y());
  const float* v = grid.values.data() + grid.shape.index(c);
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  return mix(mix(mix(v[0], v[1], t.x()), mix(v[dy], v[dy + 1], t.x()), t.y()), mix(mix(v[dz], v[dz + 1], t.x()), mix(v[dz + dy], v[dz + dy + 1], t.x()), t.y()), t.z());
}

bool Membership::is_in(int bone, const Eigen::Vector3d& p) const {
  const GridShape& shape = segmentation_.shape;
  const Eigen::Vector3d q = (p - shape.origin) / shape.step;
  if ((q.array() < 0).any() || (q.array() >= shape.size.cast<double>().array() - 1).any()) return false;
  const Eigen::Vector3i cell = q.cast<int>();
  const std::size_t first = shape.index(cell), dy = std::size_t(shape.size.x()), dz = dy * std::size_t(shape.size.y());
  const std::int16_t* owner = segmentation_.owner.data() + first;
  bool same = true;
  for (const std::size_t k : {std::size_t(1), dy, dy + 1, dz, dz + 1, dz + dy, dz + dy + 1}) same = same && owner[k] == owner[0];
  if (same) return owner[0] == bone;
  const Eigen::Vector3f t = (q - cell.cast<double>()).cast<float>();
  const float own = read(segmentation_.phi[std::size_t(bone)], boxes_[std::size_t(bone)], cell, t), step = float(shape.step);
  if (own > step) return false;
  // Others that have a sample here are the likeliest to be lower.
  const bool near = own >= -2 * step;   // farther from its interface than the samples about it there are none
  const auto other = [&](std::size_t b) { return b != std::size_t(bone) && read(segmentation_.phi[b], boxes_[b], cell, t) <= own; };
  for (const std::size_t k : {std::size_t(0), std::size_t(1), dy, dy + 1, dz, dz + 1, dz + dy, dz + dy + 1})
    if (near && owner[k] >= 0 && owner[k] != bone && (k == 0 || owner[k] != owner[0]) && other(std::size_t(owner[k]))) return false;
  if (read(target_.distance, {Eigen::Vector3i::Zero(), shape.size}, cell, t) >= 0) return false;
  for (std::size_t b = 0; near && b < boxes_.size(); ++b)
    if (other(b)) return false;
  return true;
}

Collisions collisions(const Segmentation& segmentation, const Target& target, const Joint& joint, bool finer) {
  const GridShape& shape = segmentation.shape;
  const Cells child(segmentation, joint.child), parent(segmentation, joint.parent);
  const Membership parts(segmentation, target);
  std::vector<std::size_t> part;
  for (std::size_t i : target.inside)
    if (finer ? child.may_be_near(shape.position(i)) : segmentation.owner[i] == joint.child) part.push_back(i);
  std::vector<Eigen::Affine3d> in_steps;
  for (const Eigen::Isometry3d& motion : joint.motions) in_steps.push_back(parent.in_steps(motion));
  std::vector<Collisions> found(part.size());
  tbb::parallel_for(std::size_t(0), part.size(), [&](std::size_t k) {
    std::vector<const Eigen::Isometry3d*> near;
    const Eigen::Vector3d at = shape.position(part[k]);
    for (std::size_t m = 0; m < in_steps.size(); ++m)
      if (parent.may_be_near_steps(in_steps[m] * at)) near.push_back(&joint.motions[m]);
    for (int n = 0; !near.empty() && n < (finer ? 8 : 1); ++n) {
      const Eigen::Vector3d p = finer ? at + 0.25 * shape.step * Eigen::Vector3d(n & 1 ? 1 : -1, n & 2 ? 1 : -1, n & 4 ? 1 : -1) : at;
      if (finer && !parts.is_in(joint.child, p)) continue;
      const auto times = std::count_if(near.begin(), near.end(), [&](const auto* motion) { return parts.is_in(joint.parent, *motion * p); });
      if (times > 0) found[k].points.push_back(p), found[k].times.push_back(int(times));
    }
  });
  Collisions all;
  double total = 0;
  for (const Collisions& one : found) {
    all.points.insert(all.points.end(), one.points.begin(), one.points.end());
    all.times.insert(all.times.end(), one.times.begin(), one.times.end());
    for (int times : one.times) total += times;
  }
  all.mean = total * std::pow(shape.step, 3) / (finer ? 8 : 1) / double(joint.motions.size());
  return all;
}

double collisions_by_owner(const std::vector<std::int16_t>& owner, const Target& target, const Joint& joint) {
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
  double total = 0;
  for (int t : times) total += t;
  return total * std::pow(shape.step, 3) / double(joint.motions.size());
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
