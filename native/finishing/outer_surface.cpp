#include "finishing/outer_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace transformables::finishing {
namespace {

constexpr float kEverywhere = 1e3f;       ///< depth of a target that has no surface
constexpr float kBand = 3;                ///< steps: values beyond do not move a surface
constexpr float kBeyond = 2.5f;           ///< steps that a cutter stands out of the target
constexpr float kDepth = 0.75f;           ///< steps under the surface from where carving is continued outward
constexpr float kOwn = 0.7f;              ///< of the outer distance: a value nearer to 0 than that is not the outer surface's
constexpr int kAttempts = 3;              ///< cuts, each a little tighter: an accidental touch does not repeat
constexpr float kTighter = 0.03f;         ///< steps
constexpr std::size_t kMostTriangles = 200'000;   ///< of a target that is cut: beyond, every part would take seconds
constexpr double kMostSamples = 6e7;      ///< of a lattice that is held twice

/// Extends what carving took away from inside the target to just outside.
class Continuation {
 public:
  Continuation(const PartField& unbounded, const PartField& part, const Lattice& lattice)
      : unbounded_(unbounded), part_(part), lattice_(lattice), step_(float(lattice.step())), inside_(unbounded.shape(), 0) {
    for (std::size_t n = 0; n < inside_.values.size(); ++n) {
      const Eigen::Vector3i c = cell(n);
      if (outer(c) < 0) inside_[n] = inside_value(c, free(n));
    }
  }

  Grid<float> field() const {
    Grid<float> result(unbounded_.shape(), 0);
    for (std::size_t n = 0; n < result.values.size(); ++n) {
      const Eigen::Vector3i c = cell(n);
      const float o = outer(c);
      result[n] = o < 0 ? inside_[n] : std::max(free(n) + taken_below(c, o), o - kBeyond * step_);
    }
    close_border(result);
    return result;
  }

 private:
  Eigen::Vector3i cell(std::size_t n) const { return unbounded_.corner + unbounded_.shape().cell(n); }
  float outer(const Eigen::Vector3i& c) const { return lattice_.outer.at(c); }
  float clamped(float v) const { return std::clamp(v, -kBand * step_, kBand * step_); }
  float free(std::size_t n) const { return clamped(unbounded_.psi[n]); }
  float part_at(const Eigen::Vector3i& c) const {
    const Eigen::Vector3i local = c - part_.corner;
    return part_.shape().contains(local) ? clamped(part_.psi.at(local)) : kBand * step_;
  }

  /// The part's value without the outer surface's share. Which side a sample is on is known; how far from an
  /// interface, only where the outer surface is not nearer. Elsewhere neighbours beyond the interface tell.
  float inside_value(const Eigen::Vector3i& c, float unbounded) const {
    const float value = part_at(c), o = outer(c);
    if (value >= 0) return std::max(value, 1e-3f * step_);
    if (value > kOwn * o) return value;
    float known = unbounded;
    for (int n = 0; n < 27; ++n) {
      const Eigen::Vector3i d = Eigen::Vector3i(n % 3, n / 3 % 3, n / 9) - Eigen::Vector3i::Ones(), q = c + d;
      if (!lattice_.outer.shape.contains(q) || outer(q) >= 0) continue;
      const float theirs = part_at(q);
      if (theirs >= 0) known = std::max(known, theirs - step_ * d.cast<float>().norm());
    }
    return std::min(known, value);
  }

  /// How much more than the unbounded part's value there is under the surface below a sample outside.
  float taken_below(const Eigen::Vector3i& c, float o) const {
    if (o > (kBeyond + 1) * step_) return 0;
    const GridShape& s = lattice_.outer.shape;
    Eigen::Vector3f slope;
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3i low = c, high = c;
      low[axis] = std::max(low[axis] - 1, 0);
      high[axis] = std::min(high[axis] + 1, s.size[axis] - 1);
      slope[axis] = outer(high) - outer(low);
    }
    if (!(slope.norm() > 0)) return 0;
    const Eigen::Vector3f p = (c - unbounded_.corner).cast<float>() - (o / step_ + kDepth) * slope.normalized();
    const Eigen::Vector3i base = p.array().floor().matrix().cast<int>();
    const Eigen::Vector3f t = p - base.cast<float>();
    float sum = 0, weights = 0;
    for (int n = 0; n < 8; ++n) {
      const Eigen::Vector3i d(n & 1, n >> 1 & 1, n >> 2 & 1), q = base + d;
      if (!inside_.shape.contains(q) || outer(unbounded_.corner + q) >= 0) continue;
      const float w = (d.x() ? t.x() : 1 - t.x()) * (d.y() ? t.y() : 1 - t.y()) * (d.z() ? t.z() : 1 - t.z());
      const std::size_t at = inside_.shape.index(q);
      sum += w * std::max(0.0f, inside_[at] - free(at));
      weights += w;
    }
    return weights > 1e-3f ? sum / weights : 0;
  }

  void close_border(Grid<float>& field) const {
    const Eigen::Vector3i n = field.shape.size;
    for (std::size_t i = 0; i < field.values.size(); ++i) {
      const Eigen::Array3i c = field.shape.cell(i).array();
      if ((c == 0).any() || (c == n.array() - 1).any()) field[i] = std::max(field[i], 1e-3f * step_);
    }
  }

  const PartField& unbounded_;
  const PartField& part_;
  const Lattice& lattice_;
  const float step_;
  Grid<float> inside_;
};

Part level_set_part(const PartField& field, const Eigen::Isometry3d& frame) {
  Part part;
  part.bone = field.bone;
  part.mesh = isosurface(field.psi);
  part.source.assign(part.mesh.triangles.size(), -1);
  const Eigen::Isometry3d into = frame.inverse(Eigen::Isometry);
  for (Eigen::Vector3d& v : part.mesh.vertices) v = (into * v).unaryExpr(&rounded_to_float);
  part.volume = signed_volume(part.mesh);
  if (!check(part.mesh).good()) throw std::logic_error("a finished part is not a closed simple solid in one piece");
  return part;
}

/// A cut that went wrong in a way of its own shows in the volume.
bool plausible(double volume, const PartField& field) {
  const double expected = double(inside_count(field.psi)) * std::pow(field.shape().step, 3);
  return std::abs(volume - expected) < 0.1 * expected + 50 * std::pow(field.shape().step, 3);
}

std::optional<Part> exact_part(const PartField& field, Grid<float> cutter, const CuttableTarget& target, const Eigen::Isometry3d& frame) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    for (float& v : cutter.values) v += attempt > 0 ? kTighter * float(cutter.shape.step) : 0;
    auto cut = target.cut(isosurface(cutter));
    if (!cut || !round_and_tidy(*cut, frame.inverse(Eigen::Isometry))) continue;
    Part part;
    part.bone = field.bone;
    part.volume = signed_volume(cut->mesh);
    if (!plausible(part.volume, field) || !check(cut->mesh).good()) continue;
    part.mesh = std::move(cut->mesh);
    part.source = std::move(cut->source);
    return part;
  }
  return std::nullopt;
}

/// Why no part can be exact; empty when they can.
std::string obstacle(const Scene& scene, const Target& target, const CuttableTarget& cuttable) {
  if (target.mesh.triangles.size() > kMostTriangles) return "the target has more than 200,000 triangles";
  if (double(scene.lattice.outer.shape.count()) > kMostSamples) return "the grid is too fine to be held twice";
  return cuttable.usable() ? "" : "the target's surface is not manifold";
}

}  // namespace

Grid<float> cutter_field(const PartField& unbounded, const PartField& part, const Lattice& lattice) {
  return Continuation(unbounded, part, lattice).field();
}

Mesher::Mesher(const Scene& scene, const Target& target)
    : scene_(scene), surface_(scene.character.bones.size(), Surface::kExact), all_(scene.character.bones.size()) {
  // A shell's inner wall is measured from the outer surface, which an unbounded part does not have.
  if (!scene.options.exact_surface || scene.options.style != Style::kSolid) return;
  cuttable_.emplace(target.mesh.triangles.size() > kMostTriangles ? TriangleMesh{} : target.mesh);
  obstacle_ = obstacle(scene, target, *cuttable_);
  if (!obstacle_.empty()) {
    cuttable_.reset();
    return;
  }
  Lattice open = scene.lattice;
  std::fill(open.outer.values.begin(), open.outer.values.end(), -kEverywhere);
  unbounded_ = make_part_fields(scene.segmentation, scene.character, scene.embedding, scene.options, open);
}

Part Mesher::part_of(const PartField& field, std::size_t n) {
  if (inside_count(field.psi) == 0) return {};
  const Eigen::Isometry3d& frame = scene_.segmentation.frames[field.bone];
  if (cuttable_ && surface_[n] == Surface::kExact) {
    if (auto exact = exact_part(field, cutter_field(unbounded_[n], field, scene_.lattice), *cuttable_, frame)) return std::move(*exact);
    surface_[n] = Surface::kCutFailed;
  }
  return level_set_part(field, frame);
}

const std::vector<Part>& Mesher::mesh(const std::vector<PartField>& fields, const std::vector<char>& wanted) {
  tbb::parallel_for(std::size_t(0), fields.size(), [&](std::size_t n) {
    if (wanted[n]) all_[n] = part_of(fields[n], n);
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
