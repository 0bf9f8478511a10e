#include "finishing/finishing.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "finishing/carve.h"
#include "finishing/certificate.h"
#include "finishing/hinges.h"
#include "finishing/input.h"
#include "finishing/losses.h"
#include "finishing/outer_surface.h"
#include "finishing/part_field.h"
#include "finishing/refill.h"
#include "finishing/thin.h"
#include "finishing/topology.h"

namespace transformables {
namespace {

using namespace finishing;

constexpr double kThinnest = 0.0034;   ///< target units: 1 mm of 150 mm
constexpr int kProofs = 10;            ///< tries to prove the motion, pairs that fail being set further apart after each
constexpr int kExactProofs = 7;        ///< of them, those after which parts that still fail may keep the target's own triangles
constexpr double kMore = 0.35;         ///< steps by which parts that touch are set further apart, for each try
constexpr double kFirst = 0.3;         ///< of that, in the first: most are far enough apart when they have the clearance
constexpr double kProvable = 1e-4;     ///< target units: a proof never asks for less of a gap to look at than this
constexpr double kAmple = 0.6;         ///< of the clearance: where parts are further apart, the proof does not ask how much
constexpr double kTouching = 0.02;     ///< of that, the least gap that is not a touch
constexpr long kSteps = 40'000'000;    ///< of a pair's proof: parts that travel side by side need many, and carving such a pair all over takes longer

/// Fills hollows. A part that sits in one could never come out: it is given up, and its room filled.
/// @param changed  flags of the parts that may have hollows; those of parts that are changed here are set
void fill_hollows(std::vector<PartField>& parts, const Character& character, std::vector<char>& changed, std::vector<std::string>& warnings) {
  std::vector<std::vector<char>> found(parts.size());
  tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t n) {
    if (changed[n]) found[n] = hollows(parts[n].psi);
  });
  for (std::size_t n = 0; n < parts.size(); ++n) {
    PartField& part = parts[n];
    const std::vector<char>& flags = found[n];
    if (flags.empty() || inside_count(part.psi) == 0) continue;
    for (PartField& other : parts) {
      if (&other == &part) continue;
      std::size_t enclosed = 0, all = 0;
      for (std::size_t at = 0; at < other.psi.values.size(); ++at) {
        if (!(other.psi[at] < 0)) continue;
        ++all;
        const Eigen::Vector3i c = other.corner + other.shape().cell(at) - part.corner;
        enclosed += part.shape().contains(c) && flags[part.shape().index(c)];
      }
      if (enclosed == 0 || enclosed < all) continue;
      adopt(other, Grid<float>(other.shape(), float(other.shape().step)));
      refresh(other);
      changed[std::size_t(other.bone)] = 1;
      warnings.push_back("The part of bone '" + character.bones[other.bone].name + "' was enclosed by that of '" +
                         character.bones[part.bone].name + "' and has been joined to it.");
    }
    Grid<float> psi = part.psi;
    fill(psi, flags);
    adopt(part, std::move(psi));
    refresh(part);
    changed[std::size_t(part.bone)] = 1;
  }
}

void refresh(std::vector<PartField>& parts, const std::vector<char>& wanted) {
  tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t n) {
    if (wanted[n]) refresh(parts[n]);
  });
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

CertificateOptions proof_options(const FinishingOptions& finishing) {
  const double clearance = std::max(finishing.clearance, kProvable);
  CertificateOptions options;
  // What is proved falls short of the true gap by the proof's tolerance.
  options.least = std::max(kTouching, finishing.least_share / (1 - options.tolerance)) * clearance * 0.999;
  options.enough = std::max(kAmple * clearance, 1.01 * options.least);
  options.steps = kSteps;
  options.threads = finishing.threads;
  return options;
}

/// A design being finished: fields that are carved, and meshes that are proved.
class Finisher {
 public:
  Finisher(const Scene& scene, const Target& target, std::vector<PartField> fields, const Progress& progress)
      : scene_(scene), fields_(std::move(fields)), dropped_(fields_.size(), 0), mesher_(scene, target), progress_(progress) {}

  void carve_all();
  void mesh_and_prove();
  void add_hinges();
  Parts result(double before, double target_volume) &&;

 private:
  void prove(double from, double to);
  bool set_apart(int round);

  const Scene& scene_;
  std::vector<PartField> fields_;
  std::vector<std::size_t> dropped_;
  Mesher mesher_;
  std::vector<Part> parts_;
  std::optional<Hinges> hinges_;
  std::optional<Prover> prover_;
  Certificate certificate_;
  std::vector<std::string> warnings_;
  const Progress& progress_;
};

void Finisher::carve_all() {
  tbb::parallel_for(std::size_t(0), fields_.size(), [&](std::size_t n) {
    Grid<float> psi = fields_[n].psi;
    const std::size_t dropped = keep_core_piece(psi, fields_[n].core);
    if (dropped == 0) return;
    dropped_[n] += dropped;
    adopt(fields_[n], std::move(psi));
    refresh(fields_[n]);
  });
  carve(scene_, fields_, dropped_, stage(progress_, 0.1, 0.45));
  const std::vector<char> all(fields_.size(), 1);
  refresh(fields_, all);
  if (scene_.options.style == Style::kSolid) {  // a shell is hollow on purpose, and its walls are thin
    refill(scene_, fields_, stage(progress_, 0.45, 0.55));
    tbb::parallel_for(std::size_t(0), fields_.size(), [&](std::size_t n) { take_thin(fields_[n], kThinnest); });
  }
  std::vector<char> changed = all;
  fill_hollows(fields_, scene_.character, changed, warnings_);
}

void Finisher::prove(double from, double to) {
  if (!prover_) prover_.emplace(scene_.character, scene_.embedding, scene_.path, proof_options(scene_.options));
  certificate_ = prover_->certify(parts_, stage(progress_, from, to));
}

/// Sets the pairs that are not proved further apart; false when that changes nothing: distances on samples may say that they are, by so much.
bool Finisher::set_apart(int round) {
  std::vector<char> changed(fields_.size(), 0);
  if (round >= kExactProofs)
    for (const Uncertified& place : certificate_.open)
      for (const int bone : {place.bone_a, place.bone_b}) changed[bone] |= char(mesher_.give_up_exact(bone));
  Demands demands;
  for (const Uncertified& place : certificate_.open) {
    Demand& demand = demands[{place.bone_a, place.bone_b}];
    const double missing = std::max(0.0, scene_.options.clearance - place.distance);
    demand.extra = std::max(demand.extra, missing + kMore * (round + kFirst) * scene_.lattice.step());
    if (place.reason != Uncertified::Reason::kTouching) continue;
    demand.on_a.push_back(scene_.segmentation.frames[place.bone_a] * place.on_a);
    demand.on_b.push_back(scene_.segmentation.frames[place.bone_b] * place.on_b);
  }
  std::vector<char> carved = carve_again(scene_, demands, fields_, dropped_, stage(progress_, 0.72 + 0.02 * round, 0.72 + 0.02 * round));
  fill_hollows(fields_, scene_.character, carved, warnings_);
  refresh(fields_, carved);
  bool any = false;
  for (std::size_t n = 0; n < fields_.size(); ++n) any = (changed[n] |= carved[n]) || any;
  if (any) parts_ = mesher_.mesh(fields_, changed);
  return any;
}

void Finisher::mesh_and_prove() {
  progress_(0.6, "extracting surfaces");
  parts_ = mesher_.mesh(fields_, std::vector<char>(fields_.size(), 1));
  if (scene_.path.moves.empty()) return;
  prove(0.7, 0.72);
  for (int round = 0; !certificate_.holds && round + 1 < kProofs; ++round)
    if (set_apart(round)) prove(0.72 + 0.02 * round, 0.74 + 0.02 * round);
}

/// Hinges come last, into parts that are proved without them: where the proof fails now, it is theirs to go.
void Finisher::add_hinges() {
  if (!scene_.options.hinges || !certificate_.holds || scene_.path.moves.empty()) return;
  progress_(0.93, "fitting hinges");
  const Certificate without = certificate_;
  hinges_.emplace(scene_, std::move(parts_), fields_);
  for (double at = 0.94;; at += 0.5 * (1 - at)) {
    parts_ = hinges_->parts();
    prove(at, at + 0.5 * (1 - at));
    if (certificate_.holds) return;
    const std::vector<char> changed = hinges_->give_up(certificate_.open);
    if (std::count(changed.begin(), changed.end(), 1) > 0) continue;
    parts_ = hinges_->plain();
    certificate_ = without;
    hinges_.reset();
    warnings_.push_back("No joint has a pin: parts that have no hinges could not be proved apart again beside them.");
    return;
  }
}

Parts Finisher::result(double before, double target_volume) && {
  Parts parts;
  const double share = scene_.lattice.sample_volume() / target_volume;
  parts.carved_volume_pct = 100 * share * std::max(0.0, before - double(total_inside(fields_)));
  parts.minimum_clearance = certificate_.holds ? certificate_.gap : scene_.options.clearance;
  if (!certificate_.holds && !scene_.path.moves.empty()) {
    Measured measured = measure(scene_, fields_, stage(progress_, 0.93, 1));
    parts.collisions = std::move(measured.collisions);
    parts.minimum_clearance = measured.least_gap;
  }
  for (const Part& part : parts_) parts.filled_volume_pct += 100 * part.volume / target_volume;
  const std::vector<std::string> lost = losses(scene_, fields_, dropped_, parts_, target_volume);
  parts.parts = std::move(parts_);
  parts.certificate = std::move(certificate_);
  if (prover_) parts.ready = prover_->ready();
  parts.warnings = std::move(warnings_);
  if (hinges_) parts.pinned = hinges_->pinned();
  for (const auto& more : {mesher_.warnings(), lost, hinges_ ? hinges_->warnings() : std::vector<std::string>{}}) parts.warnings.insert(parts.warnings.end(), more.begin(), more.end());
  return parts;
}

Parts finish_here(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                  const FoldPath& path, const FinishingOptions& options, const Progress& progress) {
  progress(0, "sampling parts");
  Lattice lattice = make_lattice(target, options);
  if (path.moves.empty()) lattice.gap = options.clearance;  // nothing moves between configurations
  std::vector<PartField> fields = make_part_fields(segmentation, character, embedding, options, lattice);
  const double before = double(total_inside(fields));
  const Scene scene{character, embedding, segmentation, path, options, lattice};
  Finisher finisher(scene, target, std::move(fields), progress);
  finisher.carve_all();
  finisher.mesh_and_prove();
  finisher.add_hinges();
  Parts result = std::move(finisher).result(before, target.volume);
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
