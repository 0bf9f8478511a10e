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
  Eigen::Vector3f operator()(int configuration, const Eigen::Vector3f& p) const {
    const auto& m = maps_[configuration];
    return m.leftCols<3>() * p + m.col(3);
  }

 private:
  PairMotion motion_;
  std::vector<Eigen::Matrix<float, 3, 4>> maps_;
};

/// For each sample of A near or inside it, the least value of B's field over the move. Values from `reach` on are not
/// told apart; those under `-depth` neither. Between two configurations the value is less by `cover` at most.
struct Swept {
  std::vector<float> least;
  std::vector<std::int32_t> where;  ///< the configuration
  float reach = 0;
};
/// @param mask  a flag for each of A's samples that is looked at; empty: all
Swept sweep(const PartField& a, const Grid<float>& field_b, const PairConfigurations& configurations, double cover, double reach,
            const std::vector<char>& mask = {});

/// A field's value at a place given in its samples; outside the box, a lower bound that grows with the distance.
float value_at(const Grid<float>& field, const Eigen::Vector3f& p);

}  // namespace transformables::finishing
