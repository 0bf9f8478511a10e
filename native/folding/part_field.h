// One part as a signed distance, read at single places and at eight at once: the innermost loops of planning and of transfer_along.
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

#include "common/eight.h"
#include "common/grid.h"

namespace transformables::folding {

/// A rigid motion in lattice units.
struct Rigid {
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
  Eigen::Vector3f shift = Eigen::Vector3f::Zero();
  Eigen::Vector3f operator()(const Eigen::Vector3f& p) const { return turn.lazyProduct(p) + shift; }
};

/// The same motion, given in the target frame, in the units of a lattice.
Rigid in_lattice_units(const Eigen::Isometry3d& motion, const GridShape& shape);

/// Places, each number in an array of its own, so that one instruction takes all eight.
struct EightPlaces {
  float x[8], y[8], z[8];
};

/// Signed distance to one part in object mode, over a box that holds it; negative inside, to a depth of about six steps.
class PartField {
 public:
  /// From the labels alone: exact Euclidean distance between samples, less half a step. An unused bone gives an empty field.
  PartField(const std::vector<std::int16_t>& owner, const GridShape& shape, int bone);
  PartField() = default;

  bool empty() const { return values_.empty(); }
  /// A lower bound of the distance outside the box, the trilinear value within it.
  float at(const Eigen::Vector3f& p) const;
  /// Bits of eight balls.
  struct Depths {
    std::uint32_t deep = 0;    ///< those that are deeper as a whole
    std::uint32_t partly = 0;  ///< others of which something may be
  };
  /// Which of eight balls are deeper inside than `tolerance`, which is not negative, when a motion takes them to the field. Not for an empty field.
  /// @param radius  null: places, each of which is deeper or not
  Depths depths(const EightPlaces& centres, const float* radius, const Rigid& motion, float tolerance) const;
  /// Of eight balls, or places.
  struct Nearness {
    std::uint32_t near = 0;    ///< bits of those of which something may be deeper
    float least = 0;           ///< no centre is nearer to the part than this
  };
  /// @param aside  is added to each one's distance: what must not count is a long way aside
  /// The rest as depths() has it.
  Nearness nearness(const EightPlaces& centres, const float* radius, const float* aside, const Rigid& motion, float tolerance) const;
  /// Replaces values near the surface by better ones where these agree on what is inside.
  /// `value(index of a sample of the grid)` is in steps.
  template <class Function>
  void refine(const GridShape& shape, const Function& value);
  /// Takes in what lies at samples of the grid with these distances.
  void unite(const std::vector<std::pair<Eigen::Vector3i, float>>& near);

  static constexpr int kMargin = 2;  ///< samples around a part's box in its field

 private:
  struct Place {
    int index;             ///< of its cell's first corner
    float u, v, w;         ///< within the cell
    float out2, aside2;    ///< squared distances from the box, and from that of the part's samples
  };
  Place place_of(float x, float y, float z) const;
  struct Placed {          ///< eight of them
    int index[8];
    float u[8], v[8], w[8], out2[8], aside2[8];
  };
  void place_eight(const EightPlaces& centres, const Rigid& motion, Placed& placed) const;
  void read(const Placed& placed, Floats& value) const;
  static float inner(const Place& place, float c0, float c1, float c2, float c3, float c4, float c5, float c6, float c7);
  static float outside(const Place& place, float inner);

  Eigen::Vector3i low_ = Eigen::Vector3i::Zero(), size_ = Eigen::Vector3i::Zero();
  Eigen::Vector3f first_ = Eigen::Vector3f::Zero(), last_ = Eigen::Vector3f::Zero();  // the box's corners
  std::vector<float> values_;
};

EIGHT_INLINE PartField::Place PartField::place_of(float x, float y, float z) const {
  const auto within = [](float at, float low, float high) { return std::min(std::max(at, low), high); };
  const auto square = [](float a, float b, float c) { return a * a + b * b + c * c; };
  const float px = within(x, first_.x(), last_.x()), py = within(y, first_.y(), last_.y()), pz = within(z, first_.z(), last_.z());
  const float cx = px - first_.x(), cy = py - first_.y(), cz = pz - first_.z();
  const int i = std::min(int(cx), size_.x() - 2), j = std::min(int(cy), size_.y() - 2), k = std::min(int(cz), size_.z() - 2);
  constexpr float kAside = kMargin;
  return {(k * size_.y() + j) * size_.x() + i, cx - float(i), cy - float(j), cz - float(k), square(x - px, y - py, z - pz),
          square(x - within(x, first_.x() + kAside, last_.x() - kAside), y - within(y, first_.y() + kAside, last_.y() - kAside),
                 z - within(z, first_.z() + kAside, last_.z() - kAside))};
}

/// @param c  the values at the place's eight corners, x running fastest
EIGHT_INLINE float PartField::inner(const Place& place, float c0, float c1, float c2, float c3, float c4, float c5, float c6, float c7) {
  const auto mix = [](float a, float b, float weight) { return a + (b - a) * weight; };
  return mix(mix(mix(c0, c1, place.u), mix(c2, c3, place.u), place.v), mix(mix(c4, c5, place.u), mix(c6, c7, place.u), place.v), place.w);
}

// The box is convex and holds the part, so the squared distances to the box and from there to the part add up; the box of the
// part's samples alone gives another bound.
EIGHT_INLINE float PartField::outside(const Place& place, float inner) {
  return std::max(std::sqrt(place.out2 + inner * inner), std::sqrt(place.aside2) - 0.5f);
}

inline float PartField::at(const Eigen::Vector3f& p) const {
  if (values_.empty()) return std::numeric_limits<float>::max();
  const Place place = place_of(p.x(), p.y(), p.z());
  const float* f = values_.data() + place.index;
  const int dy = size_.x(), dz = dy * size_.y();
  const float value = inner(place, f[0], f[1], f[dy], f[dy + 1], f[dz], f[dz + 1], f[dz + dy], f[dz + dy + 1]);
  return place.out2 > 0 ? outside(place, value) : value;
}

/// A loop without branches, which the compiler makes into few instructions for all eight.
EIGHT_INLINE void PartField::place_eight(const EightPlaces& centres, const Rigid& motion, Placed& placed) const {
  const float* t = motion.turn.data();  // column by column
  const float sx = motion.shift.x(), sy = motion.shift.y(), sz = motion.shift.z();
  for (int n = 0; n < 8; ++n) {
    const float x = centres.x[n], y = centres.y[n], z = centres.z[n];
    const Place place = place_of(t[0] * x + t[3] * y + t[6] * z + sx, t[1] * x + t[4] * y + t[7] * z + sy, t[2] * x + t[5] * y + t[8] * z + sz);
    placed.index[n] = place.index, placed.u[n] = place.u, placed.v[n] = place.v, placed.w[n] = place.w, placed.out2[n] = place.out2, placed.aside2[n] = place.aside2;
  }
}

/// The trilinear values at eight places, as inner() has them.
EIGHT_INLINE void PartField::read(const Placed& placed, Floats& value) const {
  EIGHT_LOAD(Floats, u, placed.u);
  EIGHT_LOAD(Floats, v, placed.v);
  EIGHT_LOAD(Floats, w, placed.w);
  const int dy = size_.x(), dz = dy * size_.y(), row[4] = {0, dy, dz, dz + dy};
  Floats along[4];
  // Neighbours along x are loaded together, and sorted into the lower and the upper ones.
  for (int r = 0; r < 4; ++r) {
    const float* const first = values_.data() + row[r];
    const auto pair = [&](int n) EIGHT_INLINED {
      double both;
      std::memcpy(&both, first + placed.index[n], sizeof both);
      return both;
    };
    const Floats a = Floats(Four{pair(0), pair(1), pair(4), pair(5)}), b = Floats(Four{pair(2), pair(3), pair(6), pair(7)});
    const Floats low = __builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14), high = __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15);
    along[r] = low + (high - low) * u;
  }
  const Floats under = along[0] + (along[1] - along[0]) * v, over = along[2] + (along[3] - along[2]) * v;
  value = under + (over - under) * w;
}

// Bounds are those of outside(), without their roots.
EIGHT_INLINE PartField::Depths PartField::depths(const EightPlaces& centres, const float* radius, const Rigid& motion, float tolerance) const {
  Placed placed;
  place_eight(centres, motion, placed);
  Floats radii = {}, value;
  if (radius) std::memcpy(&radii, radius, sizeof radii);
  EIGHT_LOAD(Floats, out2, placed.out2);
  EIGHT_LOAD(Floats, aside2, placed.aside2);
  const Floats none = {}, apart = radii - tolerance, reach = apart > none ? apart : none;
  const Eight outside = out2 > none, away = outside & (aside2 >= (reach + 0.5f) * (reach + 0.5f));
  EIGHT_BITS_OF_EIGHT(all_away, away);
  if (radius && all_away == 0xff) return {};
  read(placed, value);
  const Eight within = ~outside & (value < -(radii + tolerance));
  const Eight clear = away | (outside & (out2 + value * value >= reach * reach)) | (~outside & (value >= apart));
  const Eight some = ~within & ~clear;
  EIGHT_BITS_OF_EIGHT(deep, within);
  EIGHT_BITS_OF_EIGHT(partly, some);
  return {deep, partly};
}

EIGHT_INLINE PartField::Nearness PartField::nearness(const EightPlaces& centres, const float* radius, const float* aside, const Rigid& motion, float tolerance) const {
  Placed placed;
  place_eight(centres, motion, placed);
  Floats radii = {}, value;
  if (radius) std::memcpy(&radii, radius, sizeof radii);
  EIGHT_LOAD(Floats, add, aside);
  EIGHT_LOAD(Floats, out2, placed.out2);
  read(placed, value);
  const Floats none = {};
  const Eight outside = out2 > none;
  float squares[8], others[8], distances[8];
  const Floats square = out2 + value * value;
  std::memcpy(squares, &square, sizeof square);
  for (int n = 0; n < 8; ++n) distances[n] = std::sqrt(squares[n]), others[n] = std::sqrt(placed.aside2[n]) - 0.5f;
  EIGHT_LOAD(Floats, round, distances);
  EIGHT_LOAD(Floats, other, others);
  const Floats beyond = round > other ? round : other;
  const Floats distance = (outside ? beyond : value) + add;
  const Eight close = distance < radii - tolerance;
  EIGHT_BITS_OF_EIGHT(near, close);
  const Floats four = __builtin_shufflevector(distance, distance, 4, 5, 6, 7, 0, 1, 2, 3), of_four = distance < four ? distance : four;
  const Floats two = __builtin_shufflevector(of_four, of_four, 2, 3, 0, 1, 6, 7, 4, 5), of_two = of_four < two ? of_four : two;
  return {near, std::min(of_two[0], of_two[1])};
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

}  // namespace transformables::folding
