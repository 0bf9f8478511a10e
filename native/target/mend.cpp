#include "target/mend.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/error.h"
#include "target/crossings.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kLeastMeanThickness = 1e-5;     // target units: thinner is a sheet, not a solid
constexpr std::size_t kLongestFilledLoop = 400;  // CGAL's filling is cubic at worst; longer rims get a fan
constexpr double kLargestMendedShare = 0.05;     // of the faces; more than that is no small flaw
constexpr double kLargestVolumeChange = 0.005;   // of the volume, by mending

/// A fan about the middle of a loop.
void add_fan(TriangleMesh& mesh, const std::vector<int>& loop) {
  Vector3d middle = Vector3d::Zero();
  for (const int v : loop) middle += mesh.vertices[v];
  mesh.vertices.push_back(middle / double(loop.size()));
  const int hub = int(mesh.vertices.size()) - 1;
  for (std::size_t i = 0; i < loop.size(); ++i) mesh.triangles.emplace_back(hub, loop[i], loop[(i + 1) % loop.size()]);
}

/// The faces chosen, and those within so many rings of neighbours.
std::vector<char> grown(const TriangleMesh& mesh, const std::vector<int>& faces, int rings) {
  std::vector<char> chosen(mesh.triangles.size(), 0);
  for (const int f : faces) chosen[f] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<char> touched(mesh.vertices.size(), 0);
    for (std::size_t f = 0; f < chosen.size(); ++f)
      if (chosen[f])
        for (int c = 0; c < 3; ++c) touched[mesh.triangles[f][c]] = 1;
    for (std::size_t f = 0; f < chosen.size(); ++f)
      for (int c = 0; c < 3; ++c) chosen[f] |= touched[mesh.triangles[f][c]];
  }
  return chosen;
}

/// The mesh without the small scraps that cutting out faces left behind.
Manifold without_scraps(const Manifold& m, int wanted) {
  if (m.components <= wanted) return m;
  std::vector<std::size_t> size(std::size_t(m.components), 0);
  for (const int c : m.component) ++size[c];
  std::vector<std::size_t> ranked = size;
  std::nth_element(ranked.begin(), ranked.begin() + wanted - 1, ranked.end(), std::greater<>());
  const std::size_t least = ranked[std::size_t(wanted) - 1];
  std::vector<char> drop(m.component.size());
  for (std::size_t f = 0; f < drop.size(); ++f) drop[f] = size[m.component[f]] < least;
  return make_manifold(without_faces(m.mesh, drop));
}

}  // namespace

std::string count_of(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

TriangleMesh cap_holes(const Manifold& open, std::size_t& holes) {
  TriangleMesh mesh = open.mesh;
  for (const std::vector<int>& loop : border_loops(open)) {
    if (loop.size() < 3) continue;
    ++holes;
    std::vector<Vector3d> points;
    for (const int v : loop) points.push_back(mesh.vertices[v]);
    std::vector<Vector3i> cap;
    if (loop.size() <= kLongestFilledLoop) cap = fill_loop(points);
    for (const Vector3i& t : cap) mesh.triangles.emplace_back(loop[t[0]], loop[t[1]], loop[t[2]]);
    if (cap.empty()) add_fan(mesh, loop);
  }
  return mesh;
}

Manifold drop_sheets(const Manifold& m, std::vector<std::string>& warnings) {
  const std::vector<ComponentSize> sizes = component_sizes(m);
  std::vector<char> flat(sizes.size(), 0), drop(m.component.size(), 0);
  for (std::size_t i = 0; i < sizes.size(); ++i)
    flat[i] = 2 * std::abs(sizes[i].volume) <= kLeastMeanThickness * sizes[i].area;
  const std::size_t count = std::size_t(std::count(flat.begin(), flat.end(), 1));
  if (count == 0) return m;
  if (count == flat.size())
    throw InvalidInput("The target mesh has no volume (it is a sheet): give it thickness, for instance with a Solidify "
                       "modifier.");
  for (std::size_t f = 0; f < drop.size(); ++f) drop[f] = flat[m.component[f]];
  warnings.push_back("Left out " + count_of(count, "piece", "pieces") + " of the target without any thickness.");
  return make_manifold(without_faces(m.mesh, drop));
}

std::optional<Manifold> mend_crossings(const Manifold& m, const std::vector<int>& crossing, std::size_t& replaced) {
  const double volume = std::abs(signed_volume(m.mesh));
  for (int rings = 0; rings <= 3; ++rings) {
    const std::vector<char> drop = grown(m.mesh, crossing, rings);
    replaced = std::size_t(std::count(drop.begin(), drop.end(), 1));
    if (double(replaced) > kLargestMendedShare * double(drop.size())) return {};
    std::size_t holes = 0;
    const Manifold cut = without_scraps(make_manifold(without_faces(m.mesh, drop)), m.components);
    const Manifold mended = make_manifold(cap_holes(cut, holes));
    const double change = std::abs(std::abs(signed_volume(mended.mesh)) - volume);
    if (mended.closed() && mended.components == m.components && change < kLargestVolumeChange * volume &&
        crossing_faces(mended.mesh).empty())
      return mended;
  }
  return {};
}

}  // namespace transformables
