#include "finishing/joint_plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "finishing/exact_cut.h"
#include "finishing/joint_room.h"

namespace transformables::finishing {
namespace {

// In steps of the lattice, on which surfaces stand to a tenth.
constexpr double kUnder = 0.35;        ///< under the body's surface from where what carries must be solid
constexpr double kRoot = 0.8;          ///< how deep it is rooted in the body
constexpr double kBody = 1.5;          ///< how thick the body must be there: a hinge on a thin shell breaks off
constexpr double kDepth = 0.15;        ///< a field's value from which on it is solid
constexpr double kInto = 0.2;          ///< of the housing's radius: how far a block reaches into what it carries
constexpr int kAroundRing = 24;

/// Rows of a sphere map wholly above a height, and wholly within it, at a radius.
struct Zones {
  int above_to, within_from, within_to;   ///< rows 0 to above_to; the same from below by mirror symmetry
};
Zones zones(double height_above, double radius_above, double height_within, double radius_within) {
  const double cell = polar_edge(1);
  const double above = std::acos(std::min(1.0, height_above / radius_above)), within = std::acos(std::min(1.0, height_within / radius_within));
  return {int(std::floor(above / cell)) - 1, int(std::ceil(within / cell)), SphereMap::kRows - 1 - int(std::ceil(within / cell))};
}

/// One joint as it is examined: fields of both parts, and what is solid and free on a sphere about it.
class JointExaminer {
 public:
  JointExaminer(const Lattice& lattice, const PartField& child, const PartField& parent, const Eigen::Isometry3d& frame, const HingeSize& size,
                std::pair<double, double> range, double further)
      : child_(child), frame_(frame), size_(size), step_(lattice.step()), body_(size.outer + size.gap / 2 + further) {
    neck_ = solid_between(child.psi, frame, size.outer + kUnder * step_, size.outer + kBody * step_, kDepth * step_);
    arms_ = solid_between(parent.psi, frame, body_ + kUnder * step_, body_ + kBody * step_, kDepth * step_);
    const SphereMap free = free_between(child.psi, frame, size.outer, body_ + kUnder * step_, size.gap, range);
    for (int row = 0; row < SphereMap::kRows; ++row)
      for (int c = 0; c < SphereMap::kColumns; ++c) arms_.set(row, c, arms_.at(row, c) && free.at(row, c));
  }

  /// The tongue is the child's, ears and pin the parent's.
  std::optional<HingeSolids> tongue_on_child() const {
    const Zones z = zones(size_.ear_face(), reach_in(), size_.half_tongue, size_.outer + kRoot * step_);
    if (!neck_.largest(z.within_from, z.within_to, size_.outer) || !ring_is_whole()) return std::nullopt;
    const std::vector<Block> blocks = both_ends(arms_, z, body_);
    if (blocks.empty()) return std::nullopt;
    return solids(spool(size_.outer, size_.half_tongue, size_.hole()), spool(size_.inner, size_.ear_face(), size_.pin), blocks);
  }

  /// The tongue is the parent's.
  std::optional<HingeSolids> tongue_on_parent() const {
    const Zones z = zones(size_.ear_face(), size_.outer, size_.half_tongue, body_ + kRoot * step_);
    if (both_ends(neck_, z, size_.outer).empty() || !ears_are_whole()) return std::nullopt;
    const auto arm = arms_.largest(z.within_from, z.within_to, body_);
    if (!arm) return std::nullopt;
    return solids(ring(size_.outer, size_.ear_face(), size_.pin), ring(size_.inner, size_.half_tongue, size_.hole()), {*arm});
  }

 private:
  double reach_in() const { return size_.inner - kInto * size_.outer; }
  bool child_has(const Eigen::Vector3d& p) const { return sample(child_.psi, frame_ * p) < 0; }

  static std::vector<Block> both_ends(const SphereMap& map, const Zones& z, double radius) {
    std::vector<Block> blocks;
    for (const auto& found : {map.largest(0, z.above_to, radius), map.largest(SphereMap::kRows - 1 - z.above_to, SphereMap::kRows - 1, radius)})
      if (found) blocks.push_back(*found);
    return blocks;
  }

  bool ring_is_whole() const {
    const double middle = (size_.hole() + size_.outer - size_.gap) / 2;
    for (int n = 0; n < kAroundRing; ++n) {
      const double a = azimuth_edge(n * SphereMap::kColumns / kAroundRing);
      if (!child_has({middle * std::cos(a), middle * std::sin(a), 0})) return false;
    }
    return true;
  }

  bool ears_are_whole() const {
    const double middle = (size_.ear_face() + size_.outer - size_.gap) / 2;
    return child_has({0, 0, middle}) && child_has({0, 0, -middle}) && child_has({0, 0, 0});
  }

  std::optional<HingeSolids> solids(const TriangleMesh& taken, const TriangleMesh& given, const std::vector<Block>& blocks) const {
    std::optional<SourcedMesh> whole = SourcedMesh{given, std::vector<std::int32_t>(given.triangles.size(), -1)};
    for (Block b : blocks) {
      b.from = reach_in(), b.to = body_ + kRoot * step_;
      if (whole) whole = combined(*whole, block(b), Combination::kUnion, 0);
    }
    if (!whole) return std::nullopt;
    return HingeSolids{frame_.translation(), body_, moved(taken, frame_), moved(whole->mesh, frame_)};
  }

  const PartField& child_;
  const Eigen::Isometry3d frame_;
  const HingeSize size_;
  const double step_, body_;    // `body`: the radius at which the parent's own body begins
  SphereMap neck_, arms_;
};

}  // namespace

TriangleMesh moved(TriangleMesh mesh, const Eigen::Isometry3d& by) {
  for (Eigen::Vector3d& v : mesh.vertices) v = by * v;
  return mesh;
}

std::optional<HingeSolids> plan_hinge(const Lattice& lattice, const PartField& child, const PartField& parent, const Eigen::Isometry3d& frame,
                                      const HingeSize& size, std::pair<double, double> range, double further) {
  const JointExaminer joint(lattice, child, parent, frame, size, range, further);
  auto solids = joint.tongue_on_child();
  return solids ? solids : joint.tongue_on_parent();
}

}  // namespace transformables::finishing
