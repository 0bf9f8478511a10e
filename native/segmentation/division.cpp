#include "segmentation/division.h"

#include <map>

#include "segmentation/surfaces.h"

namespace transformables {
namespace {

using namespace segmentation_inner;

constexpr float kNear = 2.5f;   // steps: farther from all parts than that a place is of none

// Halves long edges, a pass over all triangles at a time. Triangles on both sides of an edge agree on it, so no crack opens.
class Halving {
 public:
  Halving(const TriangleMesh& mesh, double longest) : vertices_(mesh.vertices), triangles_(mesh.triangles), longest_(longest) {}

  TriangleMesh run() {
    for (std::size_t before = 0; before != vertices_.size();) {
      before = vertices_.size();
      middle_.clear();
      std::vector<Eigen::Vector3i> all;
      for (const Eigen::Vector3i& t : triangles_) split(t, all);
      triangles_ = std::move(all);
    }
    return {std::move(vertices_), std::move(triangles_)};
  }

 private:
  // The vertex in the middle of an edge; -1 when the edge is short enough.
  int middle(int a, int b) {
    if (a > b) std::swap(a, b);
    if ((vertices_[a] - vertices_[b]).norm() <= longest_) return -1;
    const auto [at, fresh] = middle_.try_emplace({a, b}, int(vertices_.size()));
    if (fresh) vertices_.push_back(0.5 * (vertices_[a] + vertices_[b]));
    return at->second;
  }

  void split(Eigen::Vector3i t, std::vector<Eigen::Vector3i>& all) {
    Eigen::Vector3i m;   // m[k]: of the edge from corner k to the next
    for (int k = 0; k < 3; ++k) m[k] = middle(t[k], t[(k + 1) % 3]);
    const int count = int((m.array() >= 0).count());
    if (count == 0) return all.push_back(t);
    if (count == 3) {
      for (int k = 0; k < 3; ++k) all.push_back({t[k], m[k], m[(k + 2) % 3]});
      return all.push_back(m);
    }
    int first = 0;   // turned so that the first edge is halved and the last is not
    while (m[first] < 0 || m[(first + 2) % 3] >= 0) ++first;
    t = Eigen::Vector3i(t[first], t[(first + 1) % 3], t[(first + 2) % 3]);
    m = Eigen::Vector3i(m[first], m[(first + 1) % 3], m[(first + 2) % 3]);
    all.push_back({t[0], m[0], t[2]});
    if (count == 1) return all.push_back({m[0], t[1], t[2]});
    all.push_back({m[0], t[1], m[1]});
    all.push_back({m[0], m[1], t[2]});
  }

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Eigen::Vector3i> triangles_;
  double longest_;
  std::map<std::pair<int, int>, int> middle_;
};

}  // namespace

Division division(const Segmentation& segmentation, const Target& target, double spacing_steps) {
  if (!(spacing_steps >= 0.25 && spacing_steps <= 16)) throw InvalidInput("division: the spacing must be 0.25 to 16 steps of the grid");
  if (!(segmentation.shape == target.distance.shape) || segmentation.owner.size() != segmentation.shape.count())
    throw InvalidInput("division: the segmentation belongs to another target or resolution; segment again");
  const double step = segmentation.shape.step;
  Division result{Halving(target.mesh, spacing_steps * step).run(), {}};
  std::vector<float> least(result.mesh.vertices.size(), float(kNear * step));
  result.bones.assign(least.size(), -1);
  for (std::size_t bone = 0; bone < segmentation.phi.size(); ++bone)
    for (std::size_t i = 0; i < least.size(); ++i) {
      const float value = value_at(segmentation.phi[bone], result.mesh.vertices[i]);
      if (value < least[i]) least[i] = value, result.bones[i] = std::int16_t(bone);
    }
  return result;
}

}  // namespace transformables
