#include "finishing/outer_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "finishing/shared_surface.h"

namespace transformables::finishing {
namespace {

constexpr float kBeyond = 2.5f;           ///< steps that a cutter stands out of the target
constexpr int kAttempts = 3;              ///< cuts, each a little tighter: an accidental touch does not repeat
constexpr float kTighter = 0.03f;         ///< steps
constexpr std::size_t kMostTriangles = 200'000;   ///< of a target that is cut: beyond, every part would take seconds

/// The part's solid without the target's bound, closed a little outside of it: its surface crosses the target's where the interfaces do.
Grid<float> cutter(const PartField& part) {
  Grid<float> field = part.inner;
  const float step = float(part.shape().step);
  const Eigen::Array3i last = part.shape().size.array() - 1;
  for (std::size_t n = 0; n < field.values.size(); ++n) {
    field[n] = std::max(field[n], part.away[n].outer - kBeyond * step);
    const Eigen::Array3i c = part.shape().cell(n).array();
    if ((c == 0).any() || (c == last).any()) field[n] = std::max(field[n], 1e-3f * step);
  }
  return field;
}

Part level_set_part(const PartField& field, const Eigen::Isometry3d& frame, double scale) {
  Part part;
  part.bone = field.bone;
  part.mesh = isosurface(field.psi);
  part.source.assign(part.mesh.triangles.size(), -1);
  const Eigen::Isometry3d into = frame.inverse(Eigen::Isometry);
  for (Eigen::Vector3d& v : part.mesh.vertices) v = (into * v).unaryExpr([scale](double x) { return rounded_to_float(x, scale); });
  part.volume = signed_volume(part.mesh);
  if (!check(part.mesh).good()) throw std::logic_error("a finished part is not a closed simple solid in one piece");
  return part;
}

/// A cut that went wrong in a way of its own shows in the volume.
bool plausible(double volume, const PartField& field) {
  const double expected = double(inside_count(field.psi)) * std::pow(field.shape().step, 3);
  return std::abs(volume - expected) < 0.1 * expected + 50 * std::pow(field.shape().step, 3);
}

/// @param sharing  all parts, when they have their surfaces in common; null: this one alone
std::optional<Part> exact_part(const PartField& field, const std::vector<PartField>* sharing, const CuttableTarget& target, const Eigen::Isometry3d& frame, double scale) {
  Grid<float> knife = cutter(field);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    for (float& v : knife.values) v += attempt > 0 ? kTighter * float(knife.shape.step) : 0;
    auto cut = target.cut(attempt == 0 && sharing ? shared_surface(knife, field, *sharing) : isosurface(knife));
    if (!cut || !round_and_tidy(*cut, frame.inverse(Eigen::Isometry), scale)) continue;
    Part part;
    part.bone = field.bone;
    part.volume = signed_volume(cut->mesh);
    if (!plausible(part.volume, field) || !check(cut->mesh, true).good()) continue;
    part.mesh = std::move(cut->mesh);
    part.source = std::move(cut->source);
    return part;
  }
  return std::nullopt;
}

/// Why no part can be exact; empty when they can.
std::string obstacle(const Target& target, const CuttableTarget& cuttable) {
  if (target.mesh.triangles.size() > kMostTriangles) return "the target has more than 200,000 triangles";
  return cuttable.usable() ? "" : "the target's surface is not manifold";
}

}  // namespace

Mesher::Mesher(const Scene& scene, const Target& target)
    : scene_(scene), surface_(scene.character.bones.size(), Surface::kExact), all_(scene.character.bones.size()) {
  if (!scene.options.exact_surface) return;
  cuttable_.emplace(target.mesh.triangles.size() > kMostTriangles ? TriangleMesh{} : target.mesh);
  obstacle_ = obstacle(target, *cuttable_);
  if (!obstacle_.empty()) cuttable_.reset();
}

Part Mesher::part_of(const std::vector<PartField>& fields, std::size_t n) {
  const PartField& field = fields[n];
  if (inside_count(field.psi) == 0) return {};
  const Eigen::Isometry3d& frame = scene_.segmentation.frames[field.bone];
  if (cuttable_ && surface_[n] == Surface::kExact) {
    // Parts that have a gap are each taken as carving knows them, by samples: sharper edges would come nearer to others than it thinks. Shells end where they are hollow, too.
    const bool shared = scene_.lattice.gap == 0 && scene_.options.style == Style::kSolid;
    if (auto exact = exact_part(field, shared ? &fields : nullptr, *cuttable_, frame, scene_.lattice.scale)) return std::move(*exact);
    surface_[n] = Surface::kCutFailed;
  }
  return level_set_part(field, frame, scene_.lattice.scale);
}

const std::vector<Part>& Mesher::mesh(const std::vector<PartField>& fields, const std::vector<char>& wanted) {
  tbb::parallel_for(std::size_t(0), fields.size(), [&](std::size_t n) {
    if (wanted[n]) all_[n] = part_of(fields, n);
  });
  kept_.clear();
  for (const Part& part : all_)
    if (!part.mesh.empty()) kept_.push_back(part);
  return kept_;
}

bool Mesher::give_up_exact(int bone) {
  if (!cuttable_ || surface_[std::size_t(bone)] != Surface::kExact) return false;
  surface_[std::size_t(bone)] = Surface::kGivenUp;
  return true;
}

std::vector<std::string> Mesher::warnings() const {
  std::vector<std::string> result;
  if (!obstacle_.empty())
    result.push_back("The parts' outer surfaces are re-meshed, not the target's own triangles: " + obstacle_ + ".");
  for (std::size_t bone = 0; bone < surface_.size(); ++bone) {
    const std::string whose = "The outer surface of bone '" + scene_.character.bones[bone].name + "' is re-meshed: ";
    if (surface_[bone] == Surface::kCutFailed) result.push_back(whose + "cutting the target's own triangles gave no simple solid there.");
    if (surface_[bone] == Surface::kGivenUp) result.push_back(whose + "with the target's own sharp edges it would come too near to another part.");
  }
  return result;
}

}  // namespace transformables::finishing
