// How much two parts overlap while one moves against the other: the inner loops of planning and of transfer_along.
//
// Everything here is in lattice units: a point p of the target frame is (p - origin) / step of the target's grid, so the
// samples of a part sit at whole numbers in object mode, and all distances count steps.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/grid.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::folding {

/// A rigid motion in lattice units.
struct Rigid {
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
  Eigen::Vector3f shift = Eigen::Vector3f::Zero();
  Eigen::Vector3f operator()(const Eigen::Vector3f& p) const { return turn.lazyProduct(p) + shift; }
};

/// The same motion, given in the target frame, in the units of a lattice.
Rigid in_lattice_units(const Eigen::Isometry3d& motion, const GridShape& shape);

/// Signed distance to one part in object mode, over a box that holds it; negative inside, to a depth of about six steps.
class PartField {
 public:
  /// From the labels alone: exact Euclidean distance between samples, less half a step. An unused bone gives an empty field.
  PartField(const std::vector<std::int16_t>& owner, const GridShape& shape, int bone);
  PartField() = default;

  bool empty() const { return values_.empty(); }
  /// A lower bound of the distance outside the box, the trilinear value within it.
  float at(const Eigen::Vector3f& p) const;
  /// Replaces values near the surface by better ones where these agree on what is inside.
  /// `value(index of a sample of the grid)` is in steps.
  template <class Function>
  void refine(const GridShape& shape, const Function& value);
  /// Takes in what lies at samples of the grid with these distances.
  void unite(const std::vector<std::pair<Eigen::Vector3i, float>>& near);

  static constexpr int kMargin = 2;  ///< samples around a part's box in its field

 private:
  Eigen::Vector3i low_ = Eigen::Vector3i::Zero(), size_ = Eigen::Vector3i::Zero();
  Eigen::Vector3f first_ = Eigen::Vector3f::Zero(), last_ = Eigen::Vector3f::Zero();  // the box's corners
  std::vector<float> values_;
};

inline float PartField::at(const Eigen::Vector3f& p) const {
  if (values_.empty()) return std::numeric_limits<float>::max();
  const float px = std::min(std::max(p.x(), first_.x()), last_.x()), py = std::min(std::max(p.y(), first_.y()), last_.y()),
              pz = std::min(std::max(p.z(), first_.z()), last_.z());
  const float cx = px - first_.x(), cy = py - first_.y(), cz = pz - first_.z();
  const int i = std::min(int(cx), size_.x() - 2), j = std::min(int(cy), size_.y() - 2), k = std::min(int(cz), size_.z() - 2);
  const float x = cx - float(i), y = cy - float(j), z = cz - float(k);
  const std::size_t dy = size_.x(), dz = dy * size_.y();
  const float* v = values_.data() + (std::size_t(k) * dz + std::size_t(j) * dy + i);
  const auto mix = [](float a, float b, float w) { return a + (b - a) * w; };
  const float inner = mix(mix(mix(v[0], v[1], x), mix(v[dy], v[dy + 1], x), y),
                          mix(mix(v[dz], v[dz + 1], x), mix(v[dz + dy], v[dz + dy + 1], x), y), z);
  const float ox = p.x() - px, oy = p.y() - py, oz = p.z() - pz, out2 = ox * ox + oy * oy + oz * oz;
  if (out2 <= 0) return inner;
  // The box is convex and holds the part, so the squared distances to the box and from there to the part add up; the box of the
  // part's samples alone gives another bound.
  const Eigen::Vector3f margin = Eigen::Vector3f::Constant(kMargin);
  const Eigen::Vector3f tight = p.cwiseMax(first_ + margin).cwiseMin(last_ - margin);
  return std::max(std::sqrt(out2 + inner * inner), (p - tight).norm() - 0.5f);
}

template <class Function>
void PartField::refine(const GridShape& shape, const Function& value) {
  constexpr float kNear = 1.5f;
  std::size_t at_index = 0;
  for (int k = 0; k < size_.z(); ++k)
    for (int j = 0; j < size_.y(); ++j)
      for (int i = 0; i < size_.x(); ++i, ++at_index) {
        const Eigen::Vector3i c = low_ + Eigen::Vector3i(i, j, k);
        if (!shape.contains(c) || std::abs(values_[at_index]) > kNear) continue;
        const float better = value(shape.index(c));
        if ((better < 0) == (values_[at_index] < 0) && std::abs(better) < kNear) values_[at_index] = better;
      }
}

/// The samples of one part, in bricks of neighbours with a ball around each, and small ones within those.
struct PartSamples {
  struct Brick {
    Eigen::Vector3f centre = Eigen::Vector3f::Zero();
    float radius = 0;
    std::uint32_t first = 0, count = 0;   ///< its points
  };
  std::vector<Brick> bricks, small;       ///< in the order of their points
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> index;   ///< of each point, into the grid
  Brick whole;                        ///< all of them

  PartSamples() = default;
  /// @param stride  along each axis only every so manieth sample is taken
  PartSamples(const std::vector<std::int16_t>& owner, const GridShape& shape, const std::vector<std::size_t>& inside, int bone, int stride = 1);
};

/// Part A against part B through the configurations of one move.
struct PairMotion {
  std::vector<Rigid> a_to_b;      ///< takes A's object-mode points to B's object-mode frame, one a configuration
  bool steady = true;             ///< only one of the two moves, so a point's speed is the same all along

  /// How far a point within `radius` of p can move from one configuration to the next.
  float speed(const Eigen::Vector3f& p, float radius) const;
  PairMotion reversed() const;
};

/// The number of A's samples that are ever deeper than `tolerance` inside B, counted up to `enough`; with `hit` (one a sample of A), which.
std::size_t swept_samples(const PartSamples& a, const PartField& b, const PairMotion& motion, float tolerance,
                          std::vector<char>* hit = nullptr, std::size_t enough = std::numeric_limits<std::size_t>::max());

/// The number of A's samples deeper than `tolerance` inside B in one configuration.
std::size_t overlapping_samples(const PartSamples& a, const PartField& b, const Rigid& a_to_b, float tolerance);

/// The first configuration, at or after `from`, in which a point of A is deeper than `tolerance` in B; -1 when none.
inline int first_hit(const PartField& b, const PairMotion& motion, const Eigen::Vector3f& p, float speed, int from, float tolerance) {
  const int count = int(motion.a_to_b.size());
  const float pace = 1.02f * speed + 1e-4f;  // a little above the bound: interpolated distances are not exactly 1-Lipschitz
  for (int t = from; t < count;) {
    const float gap = b.at(motion.a_to_b[t](p)) + tolerance;
    if (gap < 0) return t;
    t += 1 + int(std::min(gap / pace, 1e6f));
  }
  return -1;
}

/// The bones' skeletal shapes, which finished parts have whole, on the grid.
struct Skeletons {
  std::vector<std::int16_t> bone;   ///< [sample] that holds it, -1 for none
  /// [bone] samples at its skeleton with their distance from it, steps, less a usual tolerance: a skeleton is thin, and known exactly
  std::vector<std::vector<std::pair<Eigen::Vector3i, float>>> near;
};

/// Fields and samples of all parts of a segmentation.
struct Parts {
  std::vector<PartField> fields;
  std::vector<PartSamples> samples;
  std::vector<PartField> skeletons;   ///< the share of each part that is its bone's skeleton: empty when nobody asked for it
  std::vector<PartSamples> skins;     ///< the rest of each part's samples; without skeletons not used
};
/// With the part fields of the tiling, (phi_i - min_j phi_j) / 2 within the target, near the surfaces.
/// @param stride  of the samples; the fields have all
/// @param skeletons  empty: parts without skeletons
Parts parts_of(const Segmentation& segmentation, const Target& target, int stride = 1, const Skeletons& skeletons = {});
/// A part's skeleton alone.
PartField skeleton_field(const Skeletons& skeletons, const GridShape& shape, int bone);

/// `owner` without the samples that its bone's skeleton holds.
std::vector<std::int16_t> skins_of(std::vector<std::int16_t> owner, const Skeletons& skeletons);

/// What carving takes from a pair of parts in one move: one gives way to the other, but for its skeleton, to which the other gives way.
struct GivingWay {
  std::size_t samples = 0;           ///< that the two lose
  std::vector<std::uint32_t> gone;   ///< those, when they are asked for
};
/// The lesser of what it takes when A and when B gives way.
/// @param there  part A's motion against part B
/// @param tell  whether `gone` is wanted
GivingWay giving_way(const Parts& parts, int a, int b, const PairMotion& there, float tolerance, bool tell);

}  // namespace transformables::folding
