// How much of the target is in the way when the joints unfold, guessed from the flood's labels: cheap enough for every evaluation.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "embedding/skeleton.h"
#include "embedding/voxels.h"

namespace transformables {

/// A few hundred voxels, spread evenly, are moved along with the bones that the flood gave them to, from the folded pose to character mode: all
/// joints at once, and once more with those nearer the root ahead. A voxel that comes to lie within another bone's is in the way. The true unfolding
/// is searched for much longer, loses less, and ranks poses alike. One object a thread; nothing is allocated in an evaluation.
class Unfolding {
 public:
  Unfolding(const Character& character, std::shared_ptr<const Voxels> voxels);

  /// Share of the samples that are in the way, 0 to 1: of the two ways of unfolding the lesser. Of two parts that run into each
  /// other it is the one with fewer samples that is in the way; of equal ones that of the later bone.
  /// @param folded  the character in the pose, @param field  the flood in that pose, cells of the voxels
  double operator()(const Skeleton& folded, const Pose& pose, const std::vector<std::int32_t>& field);

  static constexpr int kSamples = 256;
  static constexpr int kTogether = 5, kStaggered = 6;  ///< configurations looked at on either way, the last one in character mode
  static constexpr double kSpread[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};  ///< of samples in the box: powers of 1 / 1.2207, which spread best

  /// How far the joint of a bone has opened, 0 to 1. @param depth  joints from the root to this one, @param deepest  of the character,
  /// @param done  of the way, 0 to 1
  static double opened(bool staggered, int depth, int deepest, double done);

 private:
  struct Motion {  // of voxels, in voxels
    Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
    Eigen::Vector3f move = Eigen::Vector3f::Zero();
  };
  void sort_samples(const std::vector<std::int32_t>& field);
  void place(const Skeleton& folded, const Pose& pose, bool staggered, double done);
  int in_the_way(const Skeleton& folded, const Pose& pose, const std::vector<std::int32_t>& field, bool staggered, int most);
  int hit(int a, int b, const std::vector<std::int32_t>& field);

  const Character& character_;
  std::shared_ptr<const Voxels> voxels_;
  std::vector<Eigen::Vector3i> samples_;                 // voxels, any order
  std::vector<int> depth_;                               // of each bone: joints from the root to it
  int deepest_ = 1;
  float spacing_ = 0;                                    // about how far a voxel may be from the next sample, voxels
  std::vector<Eigen::Vector3f> sorted_;                  // samples bone by bone; those that are in the way come last
  std::vector<int> first_, end_, left_;                  // of each bone, among them: left_, those not in the way so far
  std::vector<Eigen::Vector3f> centre_, centre_now_;     // of a ball about each bone's voxels
  std::vector<float> radius_;
  std::vector<Motion> motion_;                           // of each bone, from the folded pose
};

}  // namespace transformables
