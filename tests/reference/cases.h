// Targets and characters made by hand, for the tests that compare production with the reference and for the benches.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "character/character.h"
#include "embedding/random.h"
#include "embedding/embedding.h"
#include "target/target.h"

namespace transformables::reference {

/// The inside of `distance` (exact, negative inside), in a box of the given half extents, target units. Samples stand half
/// a step off the box's faces, with four samples of padding.
Target target_of(const Eigen::Vector3d& half, double step, const std::function<double(const Eigen::Vector3d&)>& distance);
Target box(const Eigen::Vector3d& half, int resolution);
Target ball(int resolution);
/// Two towers on a base: the short way from tower to tower leads outside.
Target u_shape(int resolution);
/// An ellipsoid whose bounding box has so many voxels, the longest side being kLongestSide: the paper's Table 1 names its grids so.
/// With a mesh of 8,192 triangles, which the distance does not come from.
Target ellipsoid(const Eigen::Vector3i& voxels);
/// Exact signed distance to an ellipsoid about the origin, by bisection for the foot of the perpendicular (Eberly).
double ellipsoid_distance(const Eigen::Vector3d& half, Eigen::Vector3d p);

/// A humanoid of 21 bones: trunk and head, arms and legs of four, each joint one hinge; fitted to the target.
Character humanoid(const Target& target);
/// A spider of 17 bones: a body and eight legs of two.
Character spider(const Target& target);
/// Seven bones end to end.
Character snake(const Target& target);

struct Case {
  std::string name;
  Target target;
  Character character;
};

/// Three characters, in targets of which one has a gap that ways must go round.
std::vector<Case> made_cases(int resolution);

/// Root within the middle of the target, any rotation, angles over the hinges' ranges and a little beyond.
Pose random_pose(const Character& character, Random& random, double spread);
Morphology random_morphology(const Character& character, Random& random);
/// What a short search gives: a fold like those that growth and folding get.
Embedding folded(const Character& character, const Target& target, unsigned seed = 1, int evaluations = 1500);

}  // namespace transformables::reference
