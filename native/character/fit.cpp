#include <algorithm>
#include <cmath>
#include <string>

#include "character/character.h"
#include "common/error.h"

namespace transformables {
namespace {

constexpr double kLengthShare = 1.3;       // mean skeleton length per bone, of the edge of its share of the volume
constexpr double kRadiusShare = 0.1;       // radius, of the same edge
constexpr double kLongestBoneShare = 0.6;  // of the target's longest side

void check_positive(double value, const char* what) {
  if (!std::isfinite(value) || value <= 0)
    throw InvalidInput(std::string(what) + " must be a positive number, not " + std::to_string(value));
}

double chosen_scale(const Character& character, double edge, double longest_side) {
  double sum = 0, longest = 0;
  for (const Bone& bone : character.bones)
    for (const Segment& s : bone.segments) {
      const double length = (s.b - s.a).norm();
      sum += length;
      longest = std::max(longest, length);
    }
  const double mean = sum / double(character.bones.size());
  return std::min(kLengthShare * edge / mean, kLongestBoneShare * longest_side / longest);
}

}  // namespace

Character fitted(const Character& character, double target_volume, double longest_side, double least_radius, double scale) {
  check_positive(target_volume, "the target's volume");
  check_positive(longest_side, "the target's longest side");
  check_positive(least_radius, "the least radius of a bone");
  if (!std::isfinite(scale) || scale < 0)
    throw InvalidInput("the scale of the character must be positive, or 0 to have it chosen, not " + std::to_string(scale));
  const double edge = std::cbrt(target_volume / double(character.bones.size()));
  if (scale == 0) scale = chosen_scale(character, edge, longest_side);

  Character result = character;
  result.scale *= scale;
  result.mirror_x *= scale;
  result.root_rest.translation() *= scale;
  for (Bone& bone : result.bones) {
    bone.head_in_parent *= scale;
    for (Segment& s : bone.segments) s = {s.a * scale, s.b * scale};
    bone.radius = std::max(kRadiusShare * edge, least_radius);
  }
  return result;
}

}  // namespace transformables
