// Embedding: fold the skeleton tightly into the target (paper, section 4).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "character/character.h"
#include "common/progress.h"
#include "target/target.h"

namespace transformables {

/// The values of the objective's terms (Eqs. 1 to 5), each before its weight.
struct ObjectiveTerms {
  double compact = 0;     ///< Eq. 2
  double skin = 0;        ///< Eq. 3
  double skeleton = 0;    ///< Eq. 4
  double protrude = 0;    ///< Eq. 5
  double limits = 0;      ///< penalty for angles outside [alpha_min, alpha_max]
  double morphology = 0;  ///< regulariser: sum of log(beta)^2
  double unfold = 0;      ///< share of the target that gets in the way of the joints as they unfold, roughly; not looked at when its weight is 0
  double total = 0;       ///< weighted sum of all
};

struct ObjectiveWeights {
  double compact = 1, skin = 1, skeleton = 1e3, protrude = 1e3, limits = 1, morphology = 0.01, unfold = 300;
};

enum class Symmetry { kAuto, kOn, kOff };

/// An angle that the search leaves alone.
struct LockedAngle {
  int angle = 0;          ///< index into Pose::angles
  double radians = 0;     ///< what it is kept at, even outside the hinge's range
};

/// A bone that the search leaves where it is. The first pin holds exactly (the whole character is hung from it); others
/// are held by a stiff term of the search.
struct PinnedBone {
  int bone = 0;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  ///< takes the bone's frame to the target's; a rotation and a move
};

/// Bounds of one bone's scale factor, instead of those for all. Equal ones: the scale is kept at that.
struct BoneProportion {
  int bone = 0;
  double least = 1, largest = 1;
};

/// A painted region of the target's surface that is to end in one part. The search prefers poses in which that bone is the nearest to it.
struct PaintedRegion {
  int bone = -1;                                            ///< -1: any, as long as it is one
  std::vector<std::array<Eigen::Vector3d, 3>> triangles;    ///< target frame
};

struct Embedding;

struct EmbeddingOptions {
  std::uint64_t seed = 0;
  Symmetry symmetry = Symmetry::kAuto;  ///< kAuto: on when character and target both have a mirror plane and the most promising symmetric pose comes to be inside and free of collisions
  bool proportions = true;              ///< let the optimiser scale bones
  double least_scale = 0.6;             ///< bounds of each bone's scale factor
  double largest_scale = 1.6;
  ObjectiveWeights weights;
  std::vector<LockedAngle> locked;      ///< when symmetric: a lock holds the angle of the other side too
  std::vector<PinnedBone> pinned;       ///< any: symmetry is off
  std::vector<BoneProportion> proportion_of;  ///< these bones have bounds of their own, whatever `proportions` says
  std::vector<PaintedRegion> painted;
  int runs = 1;                         ///< searches that go on to the end; the best is kept; more do while none is sound
  int starts = 20;                      ///< random poses that go downhill for each of those; the best are searched around
  int evaluations = 8000;               ///< bound for each run; a run ends earlier when it has converged
  int threads = 0;                      ///< 0: all cores. The result does not depend on it.
  std::function<void(const Embedding&)> trying;  ///< called, when set, up to 20 times a second: where the leading search is just now, to be watched
};

/// E* = (S_O, M*).
struct Embedding {
  Pose pose;
  Morphology morphology;
  ObjectiveTerms terms;
  double value = 0;                    ///< what the search ranks by: terms.total, a steep term for every protrusion and collision, and what painted regions ask for
  bool symmetric = false;              ///< folded as its own mirror image
  double deepest_protrusion = 0;       ///< how far the skeleton's surface sticks out of the target, target units; 0: inside
  double deepest_collision = 0;        ///< of two capsules that are not joined, target units; 0: none
  long evaluations = 0;
  double missed = 0;                   ///< how much nearer to painted regions the bones that they are to go to would have to be, target units; 0: near enough, or none
};

/// The objective for one character and target, with all that does not change between evaluations kept; one object
/// a thread. Reads both while it lives.
class Objective {
 public:
  Objective(const Character& character, const Target& target, const ObjectiveWeights& weights);
  ~Objective();
  Objective(const Objective&) = delete;
  Objective& operator=(const Objective&) = delete;

  /// Eq. 1. Allocates nothing after the first call.
  ObjectiveTerms operator()(const Pose& pose, const Morphology& morphology);

  /// The approximate segmentation of the last evaluation: the bone of each sample of target.distance, -1 outside.
  const std::vector<std::int16_t>& labels() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What of a posed skeleton is not as it should be, bone by bone.
struct SkeletonFit {
  struct Collision {
    int first = 0, second = 0;         ///< bones that are not joined, first < second
    double depth = 0;                  ///< of their capsules in one another, target units
  };
  std::vector<double> protrusion;      ///< of each bone: how far its surface sticks out of the target, target units; 0: inside
  std::vector<Collision> collisions;   ///< deepest first
};

/// @throws InvalidInput when the pose has not `angle_count` angles, or the morphology not a factor for each bone
SkeletonFit skeleton_fit(const Character& character, const Target& target, const Pose& pose, const Morphology& morphology);

/// Finds E* by CMA-ES from several starts, or from one given pose with a small step.
/// @param character  fitted to the target (character.h)
/// @param best_so_far  called, when set, each time a better pose is known
/// @throws InvalidInput when options are out of range, symmetry is on and the character or target has no mirror plane or
///         something is pinned, or a lock, pin or proportion is of no bone or angle of the character, given twice, or not finite, or a painted
///         region is of no bone or not finite
/// @throws Cancelled
Embedding embed(const Character& character, const Target& target, const EmbeddingOptions& options, const Progress& progress,
                const std::optional<Embedding>& start = {}, const std::function<void(const Embedding&)>& best_so_far = {});

struct ExploreOptions {
  int count = 5;                        ///< solutions wanted, 1 to 100; there may be fewer
  double least_difference = 0.15;       ///< share of inside voxels that must change bone between any two solutions; mirror images count as equal
};

/// Finds embeddings that differ in how they divide the target among the bones: many starts, of which those that are good
/// and different go on. Deterministic, whatever the number of threads.
/// @param best_so_far  called, when set, each time a better pose than all before is known
/// @param found  called, when set, each time a run has ended in a solution that differs from all before it; of two that are
///               alike the better one is returned, so not all that were told need be
/// @return the solutions, best `value` first; `embed` gives the first of such a search for one
/// @throws InvalidInput as embed, or when options are out of range
/// @throws Cancelled
std::vector<Embedding> explore(const Character& character, const Target& target, const EmbeddingOptions& options,
                               const ExploreOptions& wanted, const Progress& progress,
                               const std::function<void(const Embedding&)>& found = {},
                               const std::function<void(const Embedding&)>& best_so_far = {});

}  // namespace transformables
