#include "target/solid.h"

#include <algorithm>
#include <optional>

#include "target/crossings.h"
#include "target/mend.h"
#include "target/nesting.h"
#include "target/soup.h"
#include "target/wrap.h"

namespace transformables {
namespace {

constexpr double kStitchTolerance = 1e-6;  // target units: single precision at a length of 0.5, and some
constexpr double kFinestWrap = 0.5 / 128;  // target units: finer costs minutes, and shows nothing of the surface
constexpr double kWrapOffset = 0.1;        // of the wrap's alpha
constexpr int kCappingRounds = 3;          // a cap may lie on another face; then there is a smaller hole to close

Manifold closed_surface(const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  Manifold m = make_manifold(mesh);
  if (!m.closed()) {
    Manifold stitched = make_manifold(stitch_borders(m, kStitchTolerance));
    if (stitched.open_edges < m.open_edges) {
      warnings.push_back("Stitched " + count_of(m.open_edges - stitched.open_edges, "open edge.", "open edges."));
      m = std::move(stitched);
    }
  }
  if (m.turned_faces)
    warnings.push_back("Turned " + count_of(m.turned_faces, "face", "faces") + " to agree with the neighbours.");
  std::size_t holes = 0;
  for (int round = 0; round < kCappingRounds && !m.closed(); ++round) m = make_manifold(cap_holes(m, holes));
  if (holes) warnings.push_back("Closed " + count_of(holes, "hole.", "holes."));
  return drop_sheets(m, warnings);
}

}  // namespace

Solid make_solid(const TriangleMesh& mesh, double voxel, const Progress& progress, std::vector<std::string>& warnings) {
  Manifold m = closed_surface(mesh, warnings);
  progress(0.2, "looking for crossing faces");
  const std::vector<int> crossing = crossing_faces(m.mesh);
  progress(0.4, "closing the surface");
  if (m.closed() && crossing.empty()) return {turn_outward(m, warnings), true};
  if (m.closed()) {
    std::size_t replaced = 0;
    if (const std::optional<Manifold> mended = mend_crossings(m, crossing, replaced)) {
      warnings.push_back("Replaced " + count_of(replaced, "face", "faces") + " that crossed each other, or lay beside one that did.");
      return {turn_outward(*mended, warnings), true};
    }
  }
  progress(0.5, "wrapping the surface");
  const double alpha = std::max(voxel, kFinestWrap);
  warnings.push_back("Wrapped the surface, because " + count_of(crossing.size(), "face crosses", "faces cross") +
                     " another: the target's own faces are not kept.");
  return {alpha_wrap(m.mesh, alpha, kWrapOffset * alpha), false};
}

}  // namespace transformables
