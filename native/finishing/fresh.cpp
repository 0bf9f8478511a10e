#include "finishing/fresh.h"

#include <algorithm>
#include <array>
#include <vector>

namespace transformables::finishing {
namespace {

using Corners = std::array<double, 9>;

/// A mesh's triangles as numbers, each beginning with its least corner.
std::vector<Corners> corners_of(const TriangleMesh& mesh) {
  std::vector<Corners> all;
  for (const auto& t : mesh.triangles) {
    Corners best;
    for (int first = 0; first < 3; ++first) {
      Corners c;
      for (int k = 0; k < 9; ++k) c[std::size_t(k)] = mesh.vertices[std::size_t(t[(first + k / 3) % 3])][k % 3];
      if (first == 0 || c < best) best = c;
    }
    all.push_back(best);
  }
  return all;
}

}  // namespace

std::optional<BoxTree> fresh_of(const TriangleMesh& now, const TriangleMesh& before) {
  if (now.vertices == before.vertices && now.triangles == before.triangles) return std::nullopt;
  std::vector<Corners> old = corners_of(before);
  std::sort(old.begin(), old.end());
  const std::vector<Corners> all = corners_of(now);
  TriangleMesh fresh{now.vertices, {}};
  for (std::size_t n = 0; n < all.size(); ++n)
    if (!std::binary_search(old.begin(), old.end(), all[n])) fresh.triangles.push_back(now.triangles[n]);
  return fresh.triangles.empty() ? std::nullopt : std::optional(box_tree(fresh));
}

}  // namespace transformables::finishing
