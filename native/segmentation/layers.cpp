#include "segmentation/layers.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "segmentation/lattice.h"
#include "segmentation/rounding.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kAllowed = 5e-5;     // of the target's volume, mean over a joint's motions: less is left as it is
constexpr double kMuch = 2e-3;        // the same: more is no matter of layers
constexpr int kRounds = 6;            // what gives way in one place may meet in another
constexpr int kSweeps = 3;            // over what was found to meet
constexpr double kThick = 0.5;        // steps: what is deeper in both parts is no layer
constexpr int kMargin = 3;            // samples about a part in its box (segmentation.h)

/// The samples of the cell about a point, and their trilinear weights.
struct Corners {
  std::array<Eigen::Vector3i, 8> cell;
  std::array<double, 8> weight;
};

Corners corners_of(const GridShape& shape, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = (p - shape.origin) / shape.step;
  const Eigen::Vector3i c = q.array().floor().cast<int>();
  const Eigen::Vector3d t = q - c.cast<double>();
  Corners corners;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3i o(k & 1, k >> 1 & 1, k >> 2);
    corners.cell[k] = c + o;
    corners.weight[k] = (o.x() ? t.x() : 1 - t.x()) * (o.y() ? t.y() : 1 - t.y()) * (o.z() ? t.z() : 1 - t.z());
  }
  return corners;
}

class Layers {
 public:
  /// @param held  flags of the samples that stay (beside_pinned)
  Layers(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Joint& joint, const std::vector<char>& held)
      : s_(segmentation), target_(target), skeleton_(skeleton), joint_(joint), held_(held), parts_(segmentation, target), step_(segmentation.shape.step) {}

  bool are_there() const { return !s_.phi[joint_.child].values.empty() && !s_.phi[joint_.parent].values.empty(); }

  bool part(bool whole, Collisions* known = nullptr);

 private:
  struct State {
    double left;
    std::vector<std::int16_t> owner;
    Grid<float> child, parent;
  };

  double side(const Eigen::Vector3d& p) const {
    const double far = 4 * step_;
    return 0.5 * (std::min(double(value_at(s_.phi[joint_.child], p)), far) - std::min(double(value_at(s_.phi[joint_.parent], p)), far));
  }
  void give_way(const Eigen::Vector3d& p, const Eigen::Vector3d& q, bool whole);
  void move(const Eigen::Vector3d& p, double change, bool whole);
  void move(const Eigen::Vector3i& cell, double change, bool whole);
  bool has_margin(const GridShape& box, const Eigen::Vector3i& in_box, const Eigen::Vector3i& cell) const {
    const Eigen::Array3i after_in_box = box.size - in_box, after = s_.shape.size - cell;
    return (in_box.array() >= cell.array().min(kMargin)).all() && (after_in_box >= after.min(kMargin + 1)).all();
  }

  Segmentation& s_;
  const Target& target_;
  const Skeleton& skeleton_;
  const Joint& joint_;
  const std::vector<char>& held_;
  const Membership parts_;
  double step_;
};

// The best of all rounds: what gives way in one place may meet in another. Tells whether anything was changed, and what is `known` of the joint when nothing was.
// `whole`: samples may change their owners.
bool Layers::part(bool whole, Collisions* known) {
  State best{1e9, {}, {}, {}};
  for (int round = 0;; ++round) {
    Collisions found = collisions(s_, target_, joint_, true);
    if (round == 0 && (found.mean <= kAllowed * target_.volume || found.mean > kMuch * target_.volume)) {
      if (known) *known = std::move(found);
      return false;
    }
    if (found.mean < best.left) best = {found.mean, s_.owner, s_.phi[joint_.child], s_.phi[joint_.parent]};
    if (round == kRounds || found.mean <= kAllowed * target_.volume) break;
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const Eigen::Vector3d& p : found.points)
        for (const Eigen::Isometry3d& motion : joint_.motions)
          if (const Eigen::Vector3d q = motion * p; parts_.is_in(joint_.parent, q)) give_way(p, q, whole);
  }
  s_.owner = std::move(best.owner);
  s_.phi[joint_.child] = std::move(best.child);
  s_.phi[joint_.parent] = std::move(best.parent);
  return true;
}

// A point of the child that comes to lie in the parent: both places get the mean of their sides. Were it the shallower alone that gave way, it would soon meet
// the other behind it.
void Layers::give_way(const Eigen::Vector3d& p, const Eigen::Vector3d& q, bool whole) {
  const double child = -side(p), parent = side(q);
  if (child <= 0 || parent <= 0 || std::min(child, parent) > kThick * step_) return;
  move(p, 0.5 * (child + parent), whole);
  move(q, -0.5 * (child + parent), whole);
}

// The least change of the samples about a point that moves its side by so much.
void Layers::move(const Eigen::Vector3d& p, double change, bool whole) {
  const Corners corners = corners_of(s_.shape, p);
  double squares = 0;
  for (double w : corners.weight) squares += w * w;
  for (int k = 0; k < 8; ++k) move(corners.cell[k], change * corners.weight[k] / squares, whole);
}

void Layers::move(const Eigen::Vector3i& cell, double change, bool whole) {
  Grid<float>&of_child = s_.phi[joint_.child], &of_parent = s_.phi[joint_.parent];
  const Eigen::Vector3i a = cell - s_.shape.nearest(of_child.shape.origin), b = cell - s_.shape.nearest(of_parent.shape.origin);
  if (!of_child.shape.contains(a) || !of_parent.shape.contains(b)) return;
  const std::size_t i = s_.shape.index(cell);
  const int owner = s_.owner[i];
  if (!held_.empty() && held_[i]) return;
  const float band = float(kBand * step_), least = float(kLeast * step_);
  float child = std::clamp(of_child.at(a) + float(change), -band, band), parent = std::clamp(of_parent.at(b) - float(change), -band, band);
  const int taker = owner != joint_.child && owner != joint_.parent ? owner : child < parent ? joint_.child : joint_.parent;
  const bool has_room = has_margin(taker == joint_.child ? of_child.shape : of_parent.shape, taker == joint_.child ? a : b, cell);
  const bool stays = taker == owner || !whole || skeleton_.core[i] == owner || !s_.may_grow(taker) || !has_room;
  if (owner >= 0) {   // its owner's level set is negative at a sample, all others are not
    const int is = stays ? owner : taker;
    child = is == joint_.child ? std::min(child, -least) : std::max(child, least);
    parent = is == joint_.parent ? std::min(parent, -least) : std::max(parent, least);
    s_.owner[i] = std::int16_t(is);
  }
  of_child.at(a) = child, of_parent.at(b) = parent;
}

}  // namespace

// Samples that change their owner may cut a piece off: then level sets are settled, and what that brings is parted between samples alone.
Found part_layers(Segmentation& segmentation, const Target& target, const Skeleton& skeleton, const Surfaces& surfaces, const std::vector<Joint>& joints,
                 int threads) {
  const std::vector<char> held = beside_pinned(segmentation);
  tbb::task_arena arena(arena_size(threads));
  std::vector<Joint> parted;
  Found found;
  arena.execute([&] {
    for (const Joint& joint : joints)
      if (Layers layers(segmentation, target, skeleton, joint, held); layers.are_there() && layers.part(true, &found[joint.child])) parted.push_back(joint);
  });
  if (parted.empty()) return found;
  std::vector<char> bones = bones_of(parted, segmentation.phi.size());
  if (!surfaces.tile(segmentation, skeleton.core, bones)) return {};
  surfaces.settle(segmentation, {}, threads);
  round_outside(segmentation, target, skeleton, surfaces, joints, threads);
  arena.execute([&] {
    for (const Joint& joint : parted) Layers(segmentation, target, skeleton, joint, held).part(false);
  });
  return {};
}

// Along one axis after the other.
std::vector<char> beside_pinned(const Segmentation& segmentation) {
  constexpr int kReach = 2;
  const GridShape& shape = segmentation.shape;
  std::vector<char> flags = segmentation.pinned, before;
  std::size_t stride = 1;
  for (int axis = 0; axis < 3 && !flags.empty(); stride *= std::size_t(shape.size[axis++])) {
    before = flags;
    for_cells(shape, [&](std::size_t i, const Eigen::Vector3i& c) {
      if (!before[i]) return;
      for (int k = std::max(-kReach, -c[axis]); k <= std::min(kReach, shape.size[axis] - 1 - c[axis]); ++k) flags[i + std::size_t(k) * stride] = 1;
    });
  }
  return flags;
}

}  // namespace transformables::segmentation_inner
