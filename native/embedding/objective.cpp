#include <algorithm>
#include <utility>

#include "common/error.h"
#include "embedding/evaluator.h"

namespace transformables {

struct Objective::State {
  Evaluator evaluator;
  bool read = false;                    // whether labels are those of the last evaluation
  std::vector<std::int16_t> labels;
};

Objective::Objective(const Character& character, const Target& target, const ObjectiveWeights& weights) {
  if (character.bones.empty() || character.bones.size() > std::size_t(kMostBones))
    throw InvalidInput("the character has " + std::to_string(character.bones.size()) + " rigid bones: 1 to " +
                       std::to_string(kMostBones) + " can be embedded; simplify it");
  state_.reset(new State{Evaluator(character, target, std::make_shared<const Voxels>(target), weights), false, {}});
}

Objective::~Objective() = default;

ObjectiveTerms Objective::operator()(const Pose& pose, const Morphology& morphology) {
  state_->read = false;
  return state_->evaluator(pose, morphology).terms;
}

const std::vector<std::int16_t>& Objective::labels() const {
  if (!state_->read) state_->evaluator.read_labels(state_->labels);
  state_->read = true;
  return state_->labels;
}

SkeletonFit skeleton_fit(const Character& character, const Target& target, const Pose& pose, const Morphology& morphology) {
  if (pose.angles.size() != character.angle_count || morphology.size() != Eigen::Index(character.bones.size()))
    throw InvalidInput("the pose is of another character: its numbers of angles or bones differ");
  Evaluator evaluator(character, target, std::make_shared<const Voxels>(target), {});
  evaluator.without_flood(pose, morphology);
  SkeletonFit fit;
  fit.protrusion = evaluator.protrusions();
  evaluator.skeleton().for_each_collision([&](int i, int j, double depth) { fit.collisions.push_back({i, j, depth}); });
  std::stable_sort(fit.collisions.begin(), fit.collisions.end(), [](const auto& a, const auto& b) { return a.depth > b.depth; });
  return fit;
}

}  // namespace transformables
