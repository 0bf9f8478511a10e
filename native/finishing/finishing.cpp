#include "finishing/finishing.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "finishing/carve.h"
#include "finishing/outer_surface.h"
#include "finishing/part_field.h"
#include "finishing/topology.h"

namespace transformables {
namespace {

using namespace finishing;

constexpr int kRounds = 3;             ///< carving passes at most; each starts from exact distances again
constexpr double kWorthTelling = 5e-4; ///< share of the target's volume from which on a loss is reported

void demand(bool holds, const char* what) {
  if (!holds) throw InvalidInput(what);
}

void check_options(const FinishingOptions& o) {
  demand(std::isfinite(o.clearance) && o.clearance >= 0 && o.clearance <= 0.1 * kLongestSide,
         "The clearance must lie between 0 and a tenth of the target's longest side.");
  demand(o.style != Style::kShell || (std::isfinite(o.wall) && o.wall > 0 && o.wall <= 0.5 * kLongestSide),
         "The wall of a shell must be positive and at most half of the target's longest side.");
  demand(o.refinement >= 1 && o.refinement <= 8, "The refinement must lie between 1 and 8.");
  demand(std::isfinite(o.largest_step_rad) && o.largest_step_rad > 0, "The largest step between configurations must be positive.");
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

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f %%", 100 * share);
  return text;
}

/// Fills each part's hollows. A part that sits in one could never come out: it is given up, and its room filled.
void fill_hollows(std::vector<PartField>& parts, const Character& character, std::vector<std::string>& warnings) {
  for (PartField& part : parts) {
    const std::vector<char> flags = hollows(part.psi);
    if (flags.empty()) continue;
    for (PartField& other : parts) {
      if (&other == &part) continue;
      std::size_t enclosed = 0, all = 0;
      for (std::size_t n = 0; n < other.psi.values.size(); ++n) {
        if (!(other.psi[n] < 0)) continue;
        ++all;
        const Eigen::Vector3i c = other.corner + other.shape().cell(n) - part.corner;
        enclosed += part.shape().contains(c) && flags[part.shape().index(c)];
      }
      if (enclosed == 0 || enclosed < all) continue;
      std::fill(other.psi.values.begin(), other.psi.values.end(), float(other.shape().step));
      other.distance = redistanced(other.psi);
      warnings.push_back("The part of bone '" + character.bones[other.bone].name + "' was enclosed by that of '" +
                         character.bones[part.bone].name + "' and has been joined to it.");
    }
    fill(part.psi, flags);
    part.distance = redistanced(part.psi);
  }
}

void redistance(std::vector<PartField>& parts) {
  tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t n) { parts[n].distance = redistanced(parts[n].psi); });
}

std::size_t total_inside(const std::vector<PartField>& parts) {
  std::size_t sum = 0;
  for (const PartField& part : parts) sum += inside_count(part.psi);
  return sum;
}

/// Stages of the work within the whole, for progress.
Progress stage(const Progress& progress, double from, double to) {
  return {[&progress, from, to](double fraction, std::string_view note) {
    progress(from + fraction * (to - from), note);
    return true;
  }};
}

void carve_all(const Scene& scene, std::vector<PartField>& parts, std::vector<std::size_t>& dropped, const Progress& progress,
               std::vector<std::string>& warnings) {
  const Character& character = scene.character;
  for (PartField& part : parts) dropped[part.bone] += keep_core_piece(part.psi, part.core);
  redistance(parts);
  for (int round = 0; round < kRounds; ++round) {
    const bool changed = carve(scene, parts, dropped, round > 0, stage(progress, 0.1 + 0.2 * round, 0.3 + 0.2 * round));
    fill_hollows(parts, character, warnings);
    if (!changed) break;
    redistance(parts);
  }
}

void warn_of_losses(const std::vector<PartField>& fields, const Segmentation& segmentation, const Character& character,
                    const std::vector<std::size_t>& dropped, double share_of_sample, std::vector<std::string>& warnings) {
  for (const PartField& field : fields) {
    const std::string& name = character.bones[field.bone].name;
    const double share = double(dropped[field.bone]) * share_of_sample;
    if (share > kWorthTelling)
      warnings.push_back("Pieces of bone '" + name + "' that carving cut off were dropped: " + percent(share) + " of the target's volume.");
    const bool had_part = !segmentation.phi[field.bone].values.empty();
    if (inside_count(field.psi) == 0 && had_part) warnings.push_back("Nothing is left of the part of bone '" + name + "'.");
  }
}

Parts finish_here(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                  const FoldPath& path, const FinishingOptions& options, const Progress& progress) {
  progress(0, "sampling parts");
  const Lattice lattice = make_lattice(target, options);
  std::vector<PartField> fields = make_part_fields(segmentation, character, embedding, options, lattice);
  const Scene scene{character, embedding, segmentation, path, options, lattice};
  const std::size_t before = total_inside(fields);
  Parts result;
  std::vector<std::size_t> dropped(fields.size(), 0);
  carve_all(scene, fields, dropped, progress, result.warnings);
  const double share = lattice.sample_volume() / target.volume;
  result.carved_volume_pct = 100 * share * std::max(0.0, double(before) - double(total_inside(fields)));
  Measured measured = measure(scene, fields, stage(progress, 0.7, 0.9));
  result.collisions = std::move(measured.collisions);
  result.minimum_clearance = measured.least_gap;
  progress(0.9, "extracting surfaces");
  result.parts = mesh_parts(fields, scene, target, result.warnings);
  for (const Part& part : result.parts) result.filled_volume_pct += 100 * part.volume / target.volume;
  warn_of_losses(fields, segmentation, character, dropped, share, result.warnings);
  progress(1, "parts are finished");
  return result;
}

}  // namespace

Parts finish(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
             const FoldPath& path, const FinishingOptions& options, const Progress& progress) {
  check_options(options);
  check_design(segmentation, character, target, embedding);
  check_path(path, embedding);
  tbb::task_arena arena(options.threads > 0 ? options.threads : int(tbb::task_arena::automatic));
  Parts result;
  arena.execute([&] {
    result = finish_here(segmentation, character, target, embedding, path, options, progress);
  });
  return result;
}

}  // namespace transformables
