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
SourcedMesh largest_piece(const SourcedMesh& all) {
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
  for (const auto& t : m.triangles) volume[find(t[0])] += m.vertices[t[0]].dot(m.vertices[t[1]].cross(m.vertices[t[2]]));
  const int kept = int(std::max_element(volume.begin(), volume.end()) - volume.begin());
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
  HalfedgeMesh target = surface_->mesh, tool, result;
  TriangleMesh moved = cutter;
  for (auto& v : moved.vertices) v += kOffLattice;
  if (!fill(tool, moved)) return std::nullopt;
  SourceVisitor::Maps maps{&target, source_map(target), source_map(result)};
  try {
    const bool manifold = pmp::corefine_and_compute_intersection(
        target, tool, result, CGAL::parameters::visitor(SourceVisitor(maps)).throw_on_self_intersection(true));
    if (!manifold || result.number_of_faces() == 0) return std::nullopt;
  } catch (const pmp::Corefinement::Self_intersection_exception&) {
    return std::nullopt;  // the target meets itself near the cut
  } catch (const CGAL::Failure_exception&) {
    return std::nullopt;  // a target that meets itself breaks CGAL's assumptions in other ways, too
  }
  return largest_piece(arrays_of(result, maps.result_source));
}

}  // namespace transformables::finishing
