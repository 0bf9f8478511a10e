// Embedding: fold the skeleton tightly into the target (paper, section 4).
#pragma once

#include <Eigen/Core>
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
  double total = 0;       ///< weighted sum of all
};

struct ObjectiveWeights {
  double compact = 1, skin = 1, skeleton = 1e3, protrude = 1e3, limits = 1, morphology = 0.01;
};

enum class Symmetry { kAuto, kOn, kOff };

struct EmbeddingOptions {
  std::uint64_t seed = 0;
  Symmetry symmetry = Symmetry::kAuto;  ///< kAuto: on when character and target both have a mirror plane
  bool proportions = true;              ///< let the optimiser scale bones
  double least_scale = 0.6;             ///< bounds of each bone's scale factor
  double largest_scale = 1.6;
  ObjectiveWeights weights;
  int runs = 4;                         ///< independent starts (root orientations, seeds); the best is kept
  int evaluations = 8000;               ///< bound for each run; a run ends earlier when it has converged
  int threads = 0;                      ///< 0: all cores. The result does not depend on it.
};

/// E* = (S_O, M*).
struct Embedding {
  Pose pose;
  Morphology morphology;
  ObjectiveTerms terms;
  bool symmetric = false;              ///< folded as its own mirror image
  double deepest_protrusion = 0;       ///< how far the skeleton's surface sticks out of the target, target units; 0: inside
  double deepest_collision = 0;        ///< of two capsules that are not joined, target units; 0: none
  long evaluations = 0;
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

/// Finds E* by CMA-ES from several starts, or from one given pose with a small step.
/// @param character  fitted to the target (character.h)
/// @param best_so_far  called, when set, each time a better pose is known
/// @throws InvalidInput when options are out of range, or symmetry is on and the character or target has no mirror plane
/// @throws Cancelled
Embedding embed(const Character& character, const Target& target, const EmbeddingOptions& options, const Progress& progress,
                const std::optional<Embedding>& start = {}, const std::function<void(const Embedding&)>& best_so_far = {});

}  // namespace transformables
