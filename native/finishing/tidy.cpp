// Rounding to single precision moves vertices by up to 3e-8, which turns over triangles that are thinner than that.
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <algorithm>
#include <cmath>

#include "finishing/surface_mesh.h"

namespace transformables::finishing {
namespace {

using Face = HalfedgeMesh::Face_index;
using Halfedge = HalfedgeMesh::Halfedge_index;
using Vertex = HalfedgeMesh::Vertex_index;
using Eigen::Vector3d;

constexpr double kShort = 1e-5;      ///< target units: edges that are collapsed where nothing turns over
constexpr double kThin = 1e-6;       ///< a triangle's least height: under it rounding matters
constexpr double kReach = 2e-4;      ///< the longest edge that is collapsed to mend a fault: a twentieth of a fine sample
constexpr int kRounds = 8;

class Tidier {
 public:
  Tidier(HalfedgeMesh& mesh, SourceMap source) : mesh_(mesh), source_(source) {}

  bool run() {
    collapse_short_edges();
    for (int round = 0; round < kRounds; ++round) {
      flip_caps();
      std::vector<std::pair<Face, Face>> meeting;
      CGAL::Polygon_mesh_processing::self_intersections(mesh_, std::back_inserter(meeting));
      if (meeting.empty()) return true;
      // The order in which faults are found is not fixed.
      std::vector<Face> faulty;
      for (const auto& [a, b] : meeting) faulty.insert(faulty.end(), {a, b});
      std::sort(faulty.begin(), faulty.end());
      faulty.erase(std::unique(faulty.begin(), faulty.end()), faulty.end());
      bool changed = false;
      for (const Face f : faulty) changed |= !mesh_.is_removed(f) && mend(f);
      if (!changed) return false;
    }
    return false;
  }

 private:
  Vector3d at(Vertex v) const {
    const auto& p = mesh_.point(v);
    return {p.x(), p.y(), p.z()};
  }
  double length(Halfedge h) const { return (at(mesh_.source(h)) - at(mesh_.target(h))).norm(); }

  Vector3d normal(Halfedge h, Vertex moved, const Vector3d& to) const {
    Vector3d p[3];
    for (int k = 0; k < 3; ++k, h = mesh_.next(h)) p[k] = mesh_.target(h) == moved ? to : at(mesh_.target(h));
    return (p[1] - p[0]).cross(p[2] - p[0]);
  }

  /// No triangle about `gone` turns over, or becomes thin that was not, when it moves to `to` (those that vanish aside).
  bool keeps_its_sides(Vertex gone, Vertex kept) const {
    for (const Halfedge h : CGAL::halfedges_around_target(gone, mesh_)) {
      const Halfedge n = mesh_.next(h);
      if (mesh_.target(n) == kept || mesh_.source(h) == kept) continue;
      const Vector3d before = normal(h, gone, at(gone)), after = normal(h, gone, at(kept));
      const double longest = std::max({(at(kept) - at(mesh_.target(n))).norm(), (at(kept) - at(mesh_.source(h))).norm(), length(mesh_.next(n))});
      const bool thin_before = before.norm() < kThin * std::max({length(h), length(n), length(mesh_.next(n))});
      if (thin_before) {
        if (after.norm() < before.norm()) return false;
        continue;
      }
      if (before.dot(after) < 0.5 * before.norm() * after.norm() || after.norm() < kThin * longest) return false;
    }
    return true;
  }

  /// Takes the edge's source away; its target stays.
  bool collapse(Halfedge h) {
    const Vertex gone = mesh_.source(h), kept = mesh_.target(h);
    if (!CGAL::Euler::does_satisfy_link_condition(mesh_.edge(h), mesh_) || !keeps_its_sides(gone, kept)) return false;
    const auto place = mesh_.point(kept);
    const Vertex left = CGAL::Euler::collapse_edge(mesh_.edge(h), mesh_);
    mesh_.point(left) = place;
    return true;
  }
  bool collapse_either_way(Halfedge h) { return collapse(h) || collapse(mesh_.opposite(h)); }

  void collapse_short_edges() {
    for (std::size_t n = 0; n < mesh_.num_edges(); ++n) {
      const HalfedgeMesh::Edge_index e{HalfedgeMesh::size_type(n)};
      if (mesh_.is_removed(e) || length(mesh_.halfedge(e)) >= kShort) continue;
      collapse_either_way(mesh_.halfedge(e));
    }
  }

  Halfedge longest_edge(Face f) const {
    Halfedge best = mesh_.halfedge(f), h = best;
    for (int k = 0; k < 3; ++k, h = mesh_.next(h))
      if (length(h) > length(best)) best = h;
    return best;
  }
  Halfedge shortest_edge(Face f) const {
    Halfedge best = mesh_.halfedge(f), h = best;
    for (int k = 0; k < 3; ++k, h = mesh_.next(h))
      if (length(h) < length(best)) best = h;
    return best;
  }
  bool thin(Face f) const {
    const Halfedge h = longest_edge(f);
    return normal(h, mesh_.target(h), at(mesh_.target(h))).norm() < kThin * length(h);
  }

  /// A cap's longest edge goes to its other side, so that its tip lies in the neighbour's border, not in its middle.
  bool flip(Face f) {
    const Halfedge h = longest_edge(f), o = mesh_.opposite(h);
    const Vertex tip = mesh_.target(mesh_.next(h)), other = mesh_.target(mesh_.next(o));
    if (tip == other || mesh_.halfedge(tip, other) != HalfedgeMesh::null_halfedge()) return false;
    const Vector3d before = normal(o, mesh_.target(o), at(mesh_.target(o)));
    const Vector3d a = at(mesh_.source(h)), b = at(mesh_.target(h)), t = at(tip), d = at(other);
    const Vector3d first = (d - t).cross(a - t) * -1, second = (b - t).cross(d - t) * -1;
    for (const Vector3d& side : {first, second})
      if (side.dot(before) < 0.5 * side.norm() * before.norm() || side.norm() <= kThin * std::max((d - t).norm(), (b - a).norm())) return false;
    const Face neighbour = mesh_.face(o);
    CGAL::Euler::flip_edge(h, mesh_);
    source_[f] = source_[neighbour];
    return true;
  }

  void flip_caps() {
    for (std::size_t n = 0; n < mesh_.num_faces(); ++n) {
      const Face f{HalfedgeMesh::size_type(n)};
      if (!mesh_.is_removed(f) && thin(f)) mend(f);
    }
  }

  bool mend(Face f) {
    const Halfedge h = shortest_edge(f);
    if (length(h) < kReach && collapse_either_way(h)) return true;
    return flip(f);
  }

  HalfedgeMesh& mesh_;
  SourceMap source_;
};

}  // namespace

bool round_and_tidy(SourcedMesh& part, const Eigen::Isometry3d& into, double scale) {
  for (Vector3d& v : part.mesh.vertices) v = (into * v).unaryExpr([scale](double x) { return rounded_to_float(x, scale); });
  HalfedgeMesh mesh;
  if (!fill(mesh, part.mesh)) return false;
  SourceMap source = source_map(mesh);
  for (const Face f : mesh.faces()) source[f] = part.source[std::size_t(f)];
  if (!Tidier(mesh, source).run()) return false;
  part = arrays_of(mesh, source);
  return true;
}

}  // namespace transformables::finishing
