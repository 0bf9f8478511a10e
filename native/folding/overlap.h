// How much two parts overlap while one moves against the other: the inner loops of planning and of transfer_along.
// In lattice units (part_field.h).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/grid.h"
#include "folding/part_field.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::folding {

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

  /// Up to eight balls, the last one again and again where there are fewer.
  struct EightBalls {
    EightPlaces centres;
    float radius[8];
    std::int32_t count[8];              ///< points of each
    std::uint32_t there = 0;            ///< a bit for each that is not there again
    std::uint32_t below = 0;            ///< where the first one's own eight, or its cube, are, the others' after it
  };
  std::vector<EightBalls> eights[2];       ///< bricks; the small ones of each brick
  /// The points of a small brick, which are corners of a cube.
  struct Cube {
    Eigen::Vector3f first = Eigen::Vector3f::Zero();   ///< its least corner
    std::uint32_t there = 0;                           ///< a bit for each corner that is a point, x running fastest
  };
  std::vector<Cube> cubes;            ///< one a small brick
  float side = 1;                     ///< of the cubes

  PartSamples() = default;
  /// @param stride  along each axis only every so manieth sample is taken
  PartSamples(const std::vector<std::int16_t>& owner, const GridShape& shape, const std::vector<std::size_t>& inside, int bone, int stride = 1);

 private:
  void make_eights();
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

/// Bits of those of eight points of A that are ever deeper than `tolerance` in B, at or after configuration `from`.
/// @param which  bits of those that are asked for
std::uint32_t ever_deeper(const PartField& b, const PairMotion& motion, const EightPlaces& points, std::uint32_t which, float speed, int from, float tolerance);

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
