#include "finishing/solids.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "finishing/fresh.h"

namespace transformables::finishing {
namespace {

/// How often a closed mesh winds around a point that is not on it (van Oosterom and Strackee 1983).
double winding(const BoxTree& tree, const Eigen::Vector3d& p) {
  double sum = 0;
  for (const Triangle& t : tree.triangles) {
    const Eigen::Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

/// A point of each connected piece of a mesh.
std::vector<Eigen::Vector3d> piece_points(const TriangleMesh& mesh) {
  std::vector<int> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) root[find(t[k])] = find(t[0]);
  std::vector<Eigen::Vector3d> points;
  std::vector<char> seen(root.size(), 0);
  for (const auto& t : mesh.triangles) {
    char& flag = seen[find(t[0])];
    if (!flag) points.push_back(mesh.vertices[t[0]]);
    flag = 1;
  }
  return points;
}

}  // namespace

std::vector<Solid> solids_of(const std::vector<const Part*>& parts, const ReadyParts& before, bool compare) {
  std::vector<Solid> solids(parts.size());
  tbb::parallel_for(std::size_t(0), solids.size(), [&](std::size_t n) {
    const Part& part = *parts[n];
    const auto old = before.of.find(part.bone);
    if (old != before.of.end() && part.mesh.vertices == old->second->mesh.vertices && part.mesh.triangles == old->second->mesh.triangles) {
      solids[n] = {part.bone, old->second};
      return;
    }
    solids[n] = {part.bone, std::make_shared<const ReadyParts::Ready>(part.mesh, box_tree(part.mesh), piece_points(part.mesh))};
    if (compare && old != before.of.end()) solids[n].fresh = fresh_of(part.mesh, old->second->mesh);
  });
  std::sort(solids.begin(), solids.end(), [](const Solid& a, const Solid& b) { return a.bone < b.bone; });
  return solids;
}

bool holds_a_piece(const Solid& b, const Solid& a, const Eigen::Isometry3d& into_b) {
  const BoxNode& box = b.tree().nodes[0];
  return std::any_of(a.part->points.begin(), a.part->points.end(), [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d p = into_b * point;
    return (p - box.centre).norm() <= box.radius && std::abs(winding(b.tree(), p)) > 0.5;
  });
}

}  // namespace transformables::finishing
