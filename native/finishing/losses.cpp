#include "finishing/losses.h"

#include <cstdio>
#include <numbers>

namespace transformables::finishing {
namespace {

constexpr double kWorthTelling = 5e-4;   ///< share of the target's volume from which on a loss is reported
constexpr double kLeastRod = 0.008;      ///< target units: 2.4 mm of 150 mm, two of the thinnest printed walls (1.2 mm)

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f %%", 100 * share);
  return text;
}

/// Of a bone that has no part. Bones that hang on it where it hangs itself (the crosses of universal joints) keep a ball in a socket.
std::string consequence(const Scene& scene, int bone) {
  const auto& bones = scene.character.bones;
  const auto head = [&](int b) { return scene.segmentation.frames[std::size_t(b)].translation(); };
  bool carries = false, loose = bones[std::size_t(bone)].parent < 0;
  for (int child = 0; child < int(bones.size()); ++child) {
    if (bones[std::size_t(child)].parent != bone) continue;
    carries = true;
    loose = loose || (head(child) - head(bone)).norm() > bones[std::size_t(bone)].radius;
  }
  if (!carries) return ".";
  return loose ? ": what hangs on it is loose. Try another seed." : ": its joint and the next are at one place, and turn as a ball in a socket.";
}

/// A rod from a bone's joint to its ends, as thin as one can be that is printed: what holds less can't reach from one to the other.
double least_rod(const Scene& scene, int bone) {
  double volume = 0;
  for (const Segment& s : skeleton_of(scene.character.bones[std::size_t(bone)], scene.embedding.morphology[bone]))
    volume += std::numbers::pi / 4 * kLeastRod * kLeastRod * ((s.b - s.a).norm() + 2 * kLeastRod / 3);
  return volume;
}

}  // namespace

std::vector<std::string> losses(const Scene& scene, const std::vector<PartField>& fields, const std::vector<std::size_t>& dropped,
                                const std::vector<Part>& parts, double target_volume) {
  std::vector<std::string> told;
  for (const PartField& field : fields) {
    const std::string& name = scene.character.bones[std::size_t(field.bone)].name;
    const double share = double(dropped[std::size_t(field.bone)]) * scene.lattice.sample_volume() / target_volume;
    if (share > kWorthTelling)
      told.push_back("Pieces of bone '" + name + "' that carving cut off were dropped: " + percent(share) + " of the target's volume.");
    const bool had_part = !scene.segmentation.phi[std::size_t(field.bone)].values.empty();
    if (inside_count(field.psi) == 0 && had_part) told.push_back("Nothing is left of the part of bone '" + name + "'" + consequence(scene, field.bone));
  }
  for (const Part& part : parts)
    if (part.volume < least_rod(scene, part.bone))
      told.push_back("Only a speck is left of the part of bone '" + scene.character.bones[std::size_t(part.bone)].name + "' (" + percent(part.volume / target_volume) +
                     " of the target's volume), less than a rod along the bone: simplify the bone away, or fix it to its parent by locking its axes.");
  return told;
}

}  // namespace transformables::finishing
