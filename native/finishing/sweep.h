// How near one part comes to each sample of another in a move.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "finishing/motion.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// The configurations of one pair as maps from A's samples to B's, both in samples.
class PairConfigurations {
 public:
  PairConfigurations(const MoveMotion& motion, const PartField& a, const PartField& b);

  /// False when no point of A comes nearer to B than `reach` in the move.
  static bool can_meet(const MoveMotion& motion, const PartField& a, const PartField& b, double reach);

  int last() const { return int(maps_.size()) - 1; }
  const PairMotion& motion() const { return motion_; }
  /// The last of four numbers is 0: they are reckoned with at once.
  Eigen::Array4f operator()(int configuration, const Eigen::Vector3f& p) const {
    const Eigen::Matrix4f& m = maps_[std::size_t(configuration)];
    return m.col(0).array() * p.x() + m.col(1).array() * p.y() + m.col(2).array() * p.z() + m.col(3).array();
  }

 private:
  PairMotion motion_;
  std::vector<Eigen::Matrix4f> maps_;
};

/// How far a sweep has to look for what comes nearer than `gap`.
double reach_of(const Lattice& lattice, double gap);

/// Samples of a part that a sweep looks at, in bricks.
struct Bricks {
  std::vector<std::uint32_t> samples;   ///< those of a brick follow each other
  std::vector<std::uint32_t> first;     ///< of each brick, and the end
};
/// Samples nearer to the part than `reach`, or inside it.
/// @param mask  a flag for each sample that may be among them; empty: all
Bricks bricks_of(const PartField& part, double reach, const std::vector<char>& mask = {});

/// For each sample of A's bricks, the least distance to B over the move. Values from `reach` on are not
/// told apart; those under `-depth` neither. Between two configurations the value is less by `cover` at most.
struct Swept {
  std::vector<float> least;         ///< in the order of the bricks' samples; `reach` for those that are no longer near A
  std::vector<std::int32_t> where;  ///< the configuration
  float reach = 0;
};
/// What matters of a sample's least distance: whether it is under `below`, and if so how much, down to `to`.
struct Matter {
  float below, to;
};
/// @param edge     see DistanceReader
/// @param matters  for each of the bricks' samples; a least distance that does not matter reads `reach`. Empty: all do
Swept sweep(const PartField& a, const Bricks& bricks, const PartField& b, const PairConfigurations& configurations, double cover, double reach,
            float edge = 0, const std::vector<Matter>& matters = {});

/// Whether B comes nearer to any of the samples than the distance given for it.
bool any_nearer(const PartField& a, const Bricks& bricks, const PartField& b, const PairConfigurations& configurations, double cover,
                const std::vector<float>& below);

/// Reads lower bounds of the distance to a part at places given in its samples (x, y, z, 0).
class DistanceReader {
 public:
  /// Refers to the part while it lives.
  /// @param edge  steps by which the edge where the target's surface and an interface cross counts as nearer: what is made by swept values is sampled,
  ///              and between samples the distance to a sharp edge reads too large by up to half a step
  explicit DistanceReader(const PartField& part, float edge = 0);
  float operator()(const Eigen::Array4f& p) const;

 private:
  const Eigen::Array4f last_;   // sample
  const float* const first_;    // number of the part's `away`
  const std::size_t dy_, dz_;   // samples between neighbours
  const float step_, edge_;
};

}  // namespace transformables::finishing
