#include "finishing/exact_cut.h"

#include <CGAL/Polygon_mesh_processing/corefinement.h>

#include <algorithm>
#include <numeric>

#include "finishing/surface_mesh.h"

namespace transformables::finishing {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Face = HalfedgeMesh::Face_index;

/// Cutters come from a lattice, and so may coordinates of the target. Of boxes that begin at the same number CGAL takes first the one that is first
/// in memory, which differs from run to run, and with it the order of the result: this move, far below what rounding does, leaves no two alike.
const Eigen::Vector3d kOffLattice(1.37e-9, 2.11e-9, 1.73e-9);

/// Carries each triangle's source through cutting and copying.
struct SourceVisitor : pmp::Corefinement::Default_visitor<HalfedgeMesh> {
  struct Maps {
    const HalfedgeMesh* target;
    SourceMap target_source, result_source;
  };
  Maps* maps;
  std::int32_t split = -1;

  explicit SourceVisitor(Maps& m) : maps(&m) {}
  void before_subface_creations(Face f, HalfedgeMesh& mesh) { split = &mesh == maps->target ? maps->target_source[f] : -1; }
  void after_subface_created(Face f, HalfedgeMesh& mesh) {
    if (&mesh == maps->target) maps->target_source[f] = split;
  }
  void after_face_copy(Face from, const HalfedgeMesh& mesh, Face to, HalfedgeMesh&) {
    maps->result_source[to] = &mesh == maps->target ? maps->target_source[from] : -1;
  }
};

/// The piece with the largest volume; others, and cavities, which have a negative one, are left out.
/// @param dropped  the volume of other pieces is put there
SourcedMesh largest_piece(const SourcedMesh& all, double& dropped) {
  const TriangleMesh& m = all.mesh;
  std::vector<int> root(m.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& t : m.triangles)
    for (int k = 1; k < 3; ++k) root[find(t[k])] = find(t[0]);
  std::vector<double> volume(m.vertices.size(), 0);
  for (const auto& t : m.triangles) volume[find(t[0])] += m.vertices[t[0]].dot(m.vertices[t[1]].cross(m.vertices[t[2]])) / 6;
  const int kept = int(std::max_element(volume.begin(), volume.end()) - volume.begin());
  dropped = 0;
  for (std::size_t v = 0; v < volume.size(); ++v) dropped += int(v) == kept ? 0 : std::max(0.0, volume[v]);
  SourcedMesh piece;
  std::vector<int> index(m.vertices.size(), -1);
  for (std::size_t n = 0; n < m.triangles.size(); ++n) {
    if (find(m.triangles[n][0]) != kept) continue;
    piece.mesh.triangles.push_back(m.triangles[n].unaryExpr([&](int v) {
      if (index[v] < 0) {
        index[v] = int(piece.mesh.vertices.size());
        piece.mesh.vertices.push_back(m.vertices[v]);
      }
      return index[v];
    }));
    piece.source.push_back(all.source[n]);
  }
  return piece;
}

bool fill_with_source(HalfedgeMesh& into, const SourcedMesh& from) {
  if (!fill(into, from.mesh)) return false;
  SourceMap source = source_map(into);
  for (const Face f : into.faces()) source[f] = from.source[std::size_t(f)];
  return true;
}

using Corefine = bool (*)(HalfedgeMesh&, HalfedgeMesh&, HalfedgeMesh&, const SourceVisitor&);

template <class Visitor>
auto careful(const Visitor& visitor) {
  return CGAL::parameters::visitor(visitor).throw_on_self_intersection(true);
}

/// What `corefine` makes of a mesh with sources and a tool.
std::optional<SourcedMesh> corefined(HalfedgeMesh& mesh, const TriangleMesh& tool_mesh, Corefine corefine) {
  HalfedgeMesh tool, result;
  TriangleMesh moved = tool_mesh;
  for (auto& v : moved.vertices) v += kOffLattice;
  if (!fill(tool, moved)) return std::nullopt;
  SourceVisitor::Maps maps{&mesh, source_map(mesh), source_map(result)};
  try {
    if (!corefine(mesh, tool, result, SourceVisitor(maps)) || result.number_of_faces() == 0) return std::nullopt;
  } catch (const pmp::Corefinement::Self_intersection_exception&) {
    return std::nullopt;  // the mesh meets itself near the cut
  } catch (const CGAL::Failure_exception&) {
    return std::nullopt;  // a mesh that meets itself breaks CGAL's assumptions in other ways, too
  }
  return arrays_of(result, maps.result_source);
}

}  // namespace

struct CuttableTarget::Surface {
  HalfedgeMesh mesh;
};

CuttableTarget::CuttableTarget(const TriangleMesh& target) {
  auto surface = std::make_unique<Surface>();
  if (!fill(surface->mesh, target) || !CGAL::is_closed(surface->mesh)) return;
  SourceMap source = source_map(surface->mesh);
  for (const Face f : surface->mesh.faces()) source[f] = std::int32_t(std::size_t(f));
  surface_ = std::move(surface);
}

CuttableTarget::~CuttableTarget() = default;

std::optional<SourcedMesh> CuttableTarget::cut(const TriangleMesh& cutter) const {
  if (!usable()) return std::nullopt;
  HalfedgeMesh target = surface_->mesh;
  const auto common = corefined(target, cutter, [](HalfedgeMesh& a, HalfedgeMesh& b, HalfedgeMesh& out, const SourceVisitor& visitor) {
    return pmp::corefine_and_compute_intersection(a, b, out, careful(visitor));
  });
  double dropped = 0;
  return common ? std::optional(largest_piece(*common, dropped)) : std::nullopt;
}

std::optional<SourcedMesh> combined(const SourcedMesh& first, const TriangleMesh& second, Combination how, double most_dropped) {
  HalfedgeMesh mesh;
  if (!fill_with_source(mesh, first)) return std::nullopt;
  const Corefine join = [](HalfedgeMesh& a, HalfedgeMesh& b, HalfedgeMesh& out, const SourceVisitor& visitor) {
    return pmp::corefine_and_compute_union(a, b, out, careful(visitor));
  };
  const Corefine take = [](HalfedgeMesh& a, HalfedgeMesh& b, HalfedgeMesh& out, const SourceVisitor& visitor) {
    return pmp::corefine_and_compute_difference(a, b, out, careful(visitor));
  };
  const auto all = corefined(mesh, second, how == Combination::kUnion ? join : take);
  if (!all) return std::nullopt;
  double dropped = 0;
  SourcedMesh piece = largest_piece(*all, dropped);
  return dropped > most_dropped ? std::nullopt : std::optional(std::move(piece));
}

}  // namespace transformables::finishing
