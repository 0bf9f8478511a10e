// First aid for a triangle soup: what can't be used goes, what is the same becomes one.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/error.h"
#include "target/soup.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Least height of a face, as a share of its longest edge, that counts as area: above double rounding, below any
/// sliver that single precision can still tell from a line.
constexpr double kLeastRelativeHeight = 1e-10;

void check_indices(const std::vector<Vector3d>& vertices, const std::vector<Vector3i>& triangles) {
  if (triangles.empty())
    throw InvalidInput("The target mesh has no faces: choose a mesh object with a closed surface.");
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (int c = 0; c < 3; ++c)
      if (triangles[f][c] < 0 || std::size_t(triangles[f][c]) >= vertices.size())
        throw InvalidInput("The target mesh is damaged: face " + std::to_string(f) + " refers to vertex " +
                           std::to_string(triangles[f][c]) + " of " + std::to_string(vertices.size()) +
                           ". Run Mesh > Clean Up, or export it again.");
}

/// For each vertex the first one at exactly the same place. Only finite vertices matter.
std::vector<int> first_at_same_place(const std::vector<Vector3d>& vertices) {
  std::vector<int> order, first(vertices.size());
  std::iota(first.begin(), first.end(), 0);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (vertices[v].allFinite()) order.push_back(int(v));
  const auto less = [&](int a, int b) {
    for (int k = 0; k < 3; ++k)
      if (vertices[a][k] != vertices[b][k]) return vertices[a][k] < vertices[b][k];
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  for (std::size_t i = 1; i < order.size(); ++i)
    if (vertices[order[i]] == vertices[order[i - 1]]) first[order[i]] = first[order[i - 1]];
  return first;
}

bool repeats_a_corner(const Vector3i& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

bool has_no_area(const std::vector<Vector3d>& vertices, const Vector3i& t) {
  const Vector3d a = vertices[t[1]] - vertices[t[0]], b = vertices[t[2]] - vertices[t[0]];
  const double longest2 = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
  return a.cross(b).norm() <= kLeastRelativeHeight * longest2;
}

/// Marks all but the first of faces with the same three corners.
std::vector<char> mark_duplicates(const std::vector<Vector3i>& triangles) {
  std::vector<Vector3i> sorted(triangles);
  for (Vector3i& t : sorted) std::sort(t.data(), t.data() + 3);
  std::vector<int> order(triangles.size());
  std::iota(order.begin(), order.end(), 0);
  const auto corners_less = [&](int a, int b) {
    return std::lexicographical_compare(sorted[a].data(), sorted[a].data() + 3, sorted[b].data(), sorted[b].data() + 3);
  };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return corners_less(a, b) || (!corners_less(b, a) && a < b); });
  std::vector<char> duplicate(triangles.size(), 0);
  for (std::size_t i = 1; i < order.size(); ++i)
    duplicate[order[i]] = sorted[order[i]] == sorted[order[i - 1]];
  return duplicate;
}

/// Some real meshes are closed only by needles; without them there would be a slit.
bool closed_only_with(const TriangleMesh& with, const TriangleMesh& without) {
  return !make_manifold(without).closed() && make_manifold(with).closed();
}

}  // namespace

TriangleMesh without_faces(const TriangleMesh& mesh, const std::vector<char>& drop) {
  TriangleMesh out;
  std::vector<int> place(mesh.vertices.size(), -1);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    if (!drop[f])
      for (int c = 0; c < 3; ++c) place[mesh.triangles[f][c]] = 0;
  for (std::size_t v = 0; v < place.size(); ++v)
    if (place[v] == 0) {
      place[v] = int(out.vertices.size());
      out.vertices.push_back(mesh.vertices[v]);
    }
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    if (!drop[f]) {
      const Vector3i& t = mesh.triangles[f];
      out.triangles.emplace_back(place[t[0]], place[t[1]], place[t[2]]);
    }
  return out;
}

TriangleMesh clean_soup(const std::vector<Vector3d>& vertices, const std::vector<Vector3i>& triangles,
                        SoupReport& report) {
  check_indices(vertices, triangles);
  const std::vector<int> first = first_at_same_place(vertices);
  TriangleMesh kept{vertices, {}};
  for (const Vector3i& t : triangles) {
    const bool finite = vertices[t[0]].allFinite() && vertices[t[1]].allFinite() && vertices[t[2]].allFinite();
    const Vector3i welded(first[t[0]], first[t[1]], first[t[2]]);
    if (!finite) ++report.non_finite;
    else if (repeats_a_corner(welded)) ++report.degenerate;
    else kept.triangles.push_back(welded);
  }
  const std::vector<char> duplicate = mark_duplicates(kept.triangles);
  report.duplicates = std::size_t(std::count(duplicate.begin(), duplicate.end(), 1));
  const TriangleMesh with = without_faces(kept, duplicate);

  std::vector<char> needle(with.triangles.size(), 0);
  for (std::size_t f = 0; f < needle.size(); ++f) needle[f] = has_no_area(with.vertices, with.triangles[f]);
  const std::size_t needles = std::size_t(std::count(needle.begin(), needle.end(), 1));
  TriangleMesh out = needles ? without_faces(with, needle) : with;
  if (needles && closed_only_with(with, out)) return with;
  report.degenerate += needles;
  if (out.empty())
    throw InvalidInput("The target mesh has no usable face (" + std::to_string(report.non_finite) +
                       " with a vertex that is not a number, " + std::to_string(report.degenerate) +
                       " without area): choose a mesh with a closed surface.");
  return out;
}

}  // namespace transformables
