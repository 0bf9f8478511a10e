#include "finishing/input.h"

#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

void demand(bool holds, const char* what) {
  if (!holds) throw InvalidInput(what);
}

}  // namespace

void check_options(const FinishingOptions& o) {
  demand(std::isfinite(o.clearance) && o.clearance >= 0 && o.clearance <= 0.1 * kLongestSide,
         "The clearance must lie between 0 and a tenth of the target's longest side.");
  demand(o.style != Style::kShell || (std::isfinite(o.wall) && o.wall > 0 && o.wall <= 0.5 * kLongestSide),
         "The wall of a shell must be positive and at most half of the target's longest side.");
  demand(o.refinement >= 1 && o.refinement <= 8, "The refinement must lie between 1 and 8.");
  demand(std::isfinite(o.largest_step_rad) && o.largest_step_rad > 0, "The largest step between configurations must be positive.");
  demand(o.least_share >= 0 && o.least_share <= 0.7, "The share of the clearance to be proved must lie between 0 and 0.7.");
  demand(o.threads >= 0, "The number of threads must not be negative; 0 means all cores.");
}

void check_design(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding) {
  const std::size_t bones = character.bones.size();
  demand(bones > 0 && segmentation.phi.size() == bones && segmentation.frames.size() == bones,
         "The segmentation was not made for this character; segment again.");
  demand(segmentation.shape == target.distance.shape, "The segmentation was not made for this target; segment again.");
  demand(embedding.pose.angles.size() == character.angle_count && embedding.morphology.size() == Eigen::Index(bones),
         "The embedding was not made for this character; embed again.");
  demand(!target.mesh.empty() && target.volume > 0 && target.distance.values.size() == target.distance.shape.count(),
         "The target is empty; make it again.");
  demand(std::any_of(segmentation.phi.begin(), segmentation.phi.end(), [](const auto& phi) { return !phi.values.empty(); }),
         "The segmentation has no parts; segment again.");
  for (const auto& phi : segmentation.phi)
    demand(phi.values.size() == phi.shape.count() && (phi.values.empty() || (phi.shape.size.array() >= 2).all()),
           "A level set of the segmentation has the wrong number of samples; segment again.");
}

void check_path(const FoldPath& path, const Embedding& embedding) {
  Eigen::VectorXd angles = embedding.pose.angles;
  constexpr double kSame = 1e-6;
  for (const Move& move : path.moves)
    for (const Move::Turn& turn : move.turns) {
      demand(turn.angle >= 0 && turn.angle < angles.size(), "The path turns a hinge that the character does not have; plan again.");
      demand(std::isfinite(turn.from_rad) && std::isfinite(turn.to_rad) && std::abs(turn.from_rad - angles[turn.angle]) < kSame,
             "A move of the path does not start where the hinge stands; plan again.");
      angles[turn.angle] = turn.to_rad;
    }
}

}  // namespace transformables::finishing
