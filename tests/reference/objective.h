// The embedding's objective to the letter of the paper (section 4, Eqs. 2 to 5): a plain flood, interface normals by moving least
// squares, every sum over every sample, nothing kept from one evaluation to the next. Slow on purpose: the oracle for the production
// code and the baseline for its speed. It shares with that code only kinematics, distances of points and segments, and the target.
//
// Where the paper leaves freedom, or production departs from it with a reason, an option chooses between the two, so that each term
// can be compared alone:
//   flood      the paper's fronts count voxels, whatever the direction; production measures ways (1, sqrt 2, sqrt 3 a step) from
//              the bone's axis, so that of two bones the truly nearer wins
//   collisions the paper leaves out joined pairs; production leaves out what lies within 2.5 radii of a joint, for every pair, since
//              bones that share a neighbour (two thighs) always meet there, and bones that are joined may meet far from it
//   unfold     every voxel is moved, or as many as production moves
//   spacing    production looks at one boundary voxel in three or five of finer grids
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "character/character.h"
#include "common/grid.h"
#include "embedding/embedding.h"
#include "target/target.h"

namespace transformables::reference {

enum class FloodKind { kBreadthFirst, kShortestWay };
enum class CollisionKind { kNotJoined, kBeyondJoints };

struct ObjectiveOptions {
  FloodKind flood = FloodKind::kBreadthFirst;
  CollisionKind collisions = CollisionKind::kNotJoined;
  int stride = 1;    ///< samples of target.distance a voxel, along each axis
  int spacing = 1;   ///< one voxel in so many is looked at in Eqs. 2 and 3: those with (x + 2y + 4z) divisible by it
  int unfolded = 0;  ///< of the voxels so many, spread as production spreads them, are moved to see what is in their way; 0: all
};

/// A voxel of the flood.
struct Flooded {
  std::int16_t bone = -1;    ///< -1: outside, or never reached
  std::int32_t distance = 0; ///< fronts, or 1/32 of a voxel for the shortest way
};

class Objective {
 public:
  /// Reads both while it lives.
  Objective(const Character& character, const Target& target, const ObjectiveWeights& weights, const ObjectiveOptions& options = {});

  /// Eq. 1.
  ObjectiveTerms operator()(const Pose& pose, const Morphology& morphology) const;

  /// The approximate segmentation, one an element of `shape()`.
  std::vector<Flooded> flood(const Pose& pose, const Morphology& morphology) const;
  /// Eq. 1 for a segmentation that is given.
  ObjectiveTerms terms(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded) const;

  const GridShape& shape() const { return shape_; }   ///< of the voxels

 private:
  struct Posed;
  struct Interface;
  struct Plane;
  Posed posed(const Pose& pose, const Morphology& morphology) const;
  std::vector<Flooded> seeds(const Posed& posed) const;
  bool about_joint(const Posed& posed, std::size_t bone, const Segment& s, const Eigen::Vector3d& p) const;
  void by_fronts(std::vector<Flooded>& flooded) const;
  void by_shortest_way(std::vector<Flooded>& flooded) const;
  double compact(const Posed& posed, const std::vector<Flooded>& flooded) const;
  double skin(const Pose& pose, const Posed& posed, const std::vector<Flooded>& flooded) const;
  double skeleton(const Posed& posed) const;
  double protrude(const Posed& posed) const;
  double unfold(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded) const;
  double in_the_way(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded, bool staggered) const;
  std::vector<std::size_t> unfolded() const;
  bool on_boundary(const std::vector<Flooded>& flooded, std::size_t voxel) const;
  bool is_sample(std::size_t voxel) const;
  Interface interface_at(const std::vector<Flooded>& flooded, std::size_t voxel) const;
  Eigen::Vector3d fitted_normal(const std::vector<Interface>& interfaces, std::size_t voxel) const;

  const Character& character_;
  const Target& target_;
  ObjectiveWeights weights_;
  ObjectiveOptions options_;
  GridShape shape_;
  std::vector<char> inside_;
  std::vector<std::size_t> voxels_;              ///< the inside ones
  Eigen::Vector3i low_ = Eigen::Vector3i::Zero(), high_ = Eigen::Vector3i::Zero();  ///< corners of their box
};

}  // namespace transformables::reference
