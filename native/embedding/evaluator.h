// The objective's working part (Eqs. 1 to 5): everything flat, nothing allocated in an evaluation.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "embedding/boundary.h"
#include "embedding/embedding.h"
#include "embedding/interfaces.h"
#include "embedding/skeleton.h"
#include "embedding/unfolding.h"
#include "embedding/voxels.h"

namespace transformables {

/// What the search needs to know besides the terms.
struct Evaluation {
  ObjectiveTerms terms;
  double deepest_protrusion = 0;   ///< of the samples on the capsules
  double deepest_collision = 0;    ///< of capsules that are not joined
  double violation = 0;            ///< sum of all collision depths and of each bone's deepest protrusion: 0 when feasible
};

class Evaluator {
 public:
  Evaluator(const Character& character, const Target& target, std::shared_ptr<const Voxels> voxels, const ObjectiveWeights& weights);

  /// @param pose, morphology  of the character's sizes
  Evaluation operator()(const Pose& pose, const Morphology& morphology);

  /// The cheap terms alone (compact, skin, unfold and the total stay 0): no flood.
  Evaluation without_flood(const Pose& pose, const Morphology& morphology);
  /// The rest, when `without_flood` was called last, and with this pose. Where the total comes to `most` without L_skin and the
  /// unfolding, those are left out, and stay 0.
  void add_flood(const Pose& pose, Evaluation& evaluation, double most = std::numeric_limits<double>::infinity());

  /// Bone at each sample of target.distance after a whole evaluation, -1 outside.
  void read_labels(std::vector<std::int16_t>& labels) const;

  /// Bone of each inside voxel after a whole evaluation, in the order of `Voxels::runs`.
  void read_partition(std::vector<std::int16_t>& bones) const;

  const Skeleton& skeleton() const { return skeleton_; }
  /// Of each bone, after an evaluation: how far its surface sticks out of the target.
  const std::vector<double>& protrusions() const { return protrusions_; }
  const std::vector<std::int32_t>& field() const { return field_; }
  /// After a whole evaluation: the voxels on the boundary of parts.
  const Boundary& boundary() const { return boundary_; }
  const Voxels& voxels() const { return *voxels_; }

 private:
  void add_limits(const Pose& pose, ObjectiveTerms& terms) const;
  void add_protrusion(Evaluation& evaluation);
  double protrusion(const Skeleton::PosedSegment& segment, int stations, double radius, double& sum_of_squares) const;
  bool plant_seeds();
  double compact() const;
  double skin(const Pose& pose);
  double compact_without_seeds();
  double compact_sample(const Eigen::Vector3d& p, int bone) const;
  double joint_sample(const Pose& pose, const Eigen::Vector3d& p, const Eigen::Vector3d& normal, int child) const;
  int nearest_bone(const Eigen::Vector3d& p) const;

  const Target& target_;
  std::shared_ptr<const Voxels> voxels_;
  ObjectiveWeights weights_;
  Skeleton skeleton_;
  std::vector<std::int32_t> field_, rows_;                 ///< rows_: the flood's, to work in
  Boundary boundary_;
  Interfaces interfaces_;
  Unfolding unfolding_;
  std::vector<int> stations_;                              ///< of each segment: places along it that carry protrusion samples
  std::vector<double> protrusions_;
  std::size_t sample_count_ = 0;                           ///< M of Eq. 5
};

}  // namespace transformables
