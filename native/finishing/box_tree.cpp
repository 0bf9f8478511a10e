#include "finishing/box_tree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace transformables::finishing {
namespace {

constexpr int kLeaf = 4;           ///< triangles in a leaf, at most
constexpr double kRounding = 1e-12;  ///< boxes are this much larger than computed

/// Principal axes of triangles' corners: thin where the surface is flat.
Eigen::Matrix3d principal_axes(const Triangle* first, int count) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int n = 0; n < count; ++n)
    for (const auto& p : first[n]) mean += p;
  mean /= 3.0 * count;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (int n = 0; n < count; ++n)
    for (const auto& p : first[n]) spread.noalias() += (p - mean) * (p - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(spread);
  Eigen::Matrix3d axes;
  // Orthonormal whatever the solver gave: boxes must be boxes.
  axes.col(0) = solver.eigenvectors().col(2).normalized();
  if (!axes.col(0).allFinite() || axes.col(0).norm() < 0.5) return Eigen::Matrix3d::Identity();
  axes.col(1) = solver.eigenvectors().col(1) - axes.col(0).dot(solver.eigenvectors().col(1)) * axes.col(0);
  if (!axes.col(1).allFinite() || axes.col(1).norm() < 0.5) axes.col(1) = axes.col(0).unitOrthogonal();
  axes.col(1).normalize();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

void fit(BoxNode& node, const Triangle* first) {
  node.axes = principal_axes(first, node.count);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (int n = 0; n < node.count; ++n)
    for (const auto& p : first[n]) {
      const Eigen::Vector3d q = node.axes.transpose() * p;
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
  node.centre = node.axes * (0.5 * (low + high));
  node.half = (0.5 * (high - low)).array() + kRounding;
  double square = 0;
  for (int n = 0; n < node.count; ++n)
    for (const auto& p : first[n]) square = std::max(square, (p - node.centre).squaredNorm());
  node.radius = std::sqrt(square) + kRounding;
}

double middle_along(const Triangle& t, const Eigen::Vector3d& axis) { return (t[0] + t[1] + t[2]).dot(axis); }

}  // namespace

BoxTree box_tree(const TriangleMesh& mesh) {
  BoxTree tree;
  for (const auto& t : mesh.triangles) tree.triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  tree.nodes.emplace_back().count = std::int32_t(tree.triangles.size());
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    BoxNode node = tree.nodes[n];
    Triangle* first = tree.triangles.data() + node.first;
    fit(node, first);
    if (node.count > kLeaf) {
      const Eigen::Vector3d axis = node.axes.col(0);
      const int left = node.count / 2;
      std::nth_element(first, first + left, first + node.count,
                       [&](const Triangle& s, const Triangle& t) { return middle_along(s, axis) < middle_along(t, axis); });
      node.children = std::int32_t(tree.nodes.size());
      BoxNode child;
      child.first = node.first;
      child.count = left;
      tree.nodes.push_back(child);
      child.first = node.first + left;
      child.count = node.count - left;
      tree.nodes.push_back(child);
    }
    tree.nodes[n] = node;
  }
  return tree;
}

}  // namespace transformables::finishing
