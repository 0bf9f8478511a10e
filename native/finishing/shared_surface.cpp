// Marching tetrahedra for many solids at once (after Nielson and Franke 1997). Each cube of eight samples is split into six tetrahedra about its diagonal
// (Kuhn 1960), and each of their corners is some part's. An edge is divided among its corners' parts at one point, a face at one, the inside at one: where those parts
// are equally far, kept within. From that point straight lines go on to where the border is divided. Nothing is lost: what is not one corner's is another's.
// A cone over a figure on the border of a convex body does not meet itself, so the surface is simple; points depend on nothing but their own corners, so neighbours agree.
#include "finishing/shared_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace transformables::finishing {
namespace {

constexpr int kNobody = -1;                  ///< of a sample of which no more is known than the field's own value
constexpr float kNear = 2;                   ///< steps outside a part: farther off are no corners of a cell with its surface
constexpr float kFar = 1e3f;                 ///< a distance that is longer than any target
constexpr double kLeastWeight = 1.0 / 24;    ///< of a corner, before weights add up to one: no two points are near each other, measured by the rounding to float, which comes later
constexpr double kParallel = 1e-6;           ///< planes that enclose less than this have no point in common that is worth looking for

/// The corners in the order in which a way along the axes passes them, and the tetrahedron's faces, against the clock as seen from outside.
constexpr std::array<std::array<int, 3>, 6> kWays{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}};   // the last three are mirror images
constexpr std::array<std::array<int, 3>, 4> kFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A sample as a corner; they are told apart, and sorted, by their places in the grid.
struct Corner {
  Eigen::Vector3i at;
  std::size_t sample = 0;
};
template <std::size_t N>
using Corners = std::array<Corner, N>;

/// What tells some corners of a tetrahedron, sorted, from all others: the first, and which ways the rest lie from it.
template <std::size_t N>
std::uint64_t key_of(const Corners<N>& corners) {
  std::uint64_t ways = 0;
  for (std::size_t n = 1; n < N; ++n) {
    const Eigen::Vector3i d = corners[n].at - corners[0].at;
    ways = ways << 3 | std::uint64_t(d.x() | d.y() << 1 | d.z() << 2);
  }
  return std::uint64_t(corners[0].sample) << 9 | ways;
}

/// Whose samples are, as seen by one part.
class Owners {
 public:
  Owners(const Grid<float>& field, const PartField& part, const std::vector<PartField>& parts) : part_(part), parts_(parts), of_(field.values.size(), kNobody) {
    const float near = kNear * float(field.shape.step);
    for (std::size_t n = 0; n < of_.size(); ++n) {
      if (field[n] != part.uncarved[n] || field[n] >= near) continue;
      of_[n] = field[n] < 0 ? std::int16_t(part.bone) : nearest(part.corner + field.shape.cell(n));
    }
  }

  int of(const Corner& c) const { return of_[c.sample]; }
  /// How far a sample is from a part, 0 within it. In the midst of others that is truer than how deep it lies within one.
  double away(int bone, const Corner& c) const { return std::max(0.0f, value(parts_[std::size_t(bone)], part_.corner + c.at)); }

 private:
  static float value(const PartField& part, const Eigen::Vector3i& at_lattice) {
    const Eigen::Vector3i c = at_lattice - part.corner;
    return part.uncarved.shape.contains(c) ? part.uncarved.at(c) : kFar;
  }
  std::int16_t nearest(const Eigen::Vector3i& at_lattice) const {
    float least = kFar;
    int bone = kNobody;
    for (const PartField& other : parts_) {
      const float away = &other == &part_ ? kFar : value(other, at_lattice);
      if (away < least) least = away, bone = other.bone;
    }
    return std::int16_t(bone);
  }

  const PartField& part_;
  const std::vector<PartField>& parts_;
  std::vector<std::int16_t> of_;   // a sample each
};

class Extraction {
 public:
  Extraction(const Grid<float>& field, const PartField& part, const std::vector<PartField>& parts) : field_(field), owners_(field, part, parts) {}

  TriangleMesh run() && {
    const Eigen::Vector3i n = field_.shape.size;
    for (int k = 0; k + 1 < n.z(); ++k)
      for (int j = 0; j + 1 < n.y(); ++j)
        for (int i = 0; i + 1 < n.x(); ++i)
          if (ends_in({i, j, k})) add_cell({i, j, k});
    return std::move(mesh_);
  }

 private:
  bool inside(const Corner& c) const { return field_[c.sample] < 0; }

  int add(const Eigen::Vector3d& at_lattice) {
    mesh_.vertices.push_back(field_.shape.origin + field_.shape.step * at_lattice);
    return int(mesh_.vertices.size()) - 1;
  }

  /// Whether corners are of as many parts.
  template <std::size_t N>
  bool all_differ(const Corners<N>& corners) const {
    for (std::size_t n = 0; n < N; ++n)
      for (std::size_t m = 0; m < n; ++m)
        if (owners_.of(corners[n]) == owners_.of(corners[m])) return false;
    return std::none_of(corners.begin(), corners.end(), [&](const Corner& c) { return owners_.of(c) == kNobody; });
  }

  /// Weights of corners, all of different parts, at the place where these are equally far.
  template <std::size_t N>
  Eigen::Array<double, int(N), 1> where_all_meet(const Corners<N>& corners) const {
    constexpr int kCount = int(N) - 1;
    Eigen::Matrix<double, kCount, kCount> slopes;
    Eigen::Matrix<double, kCount, 1> heights;
    for (int row = 0; row < kCount; ++row) {
      const auto farther = [&](const Corner& c) { return owners_.away(owners_.of(corners[std::size_t(row) + 1]), c) - owners_.away(owners_.of(corners[0]), c); };
      heights[row] = -farther(corners[0]);
      for (int n = 0; n < kCount; ++n) slopes(row, n) = farther(corners[std::size_t(n) + 1]) + heights[row];
    }
    Eigen::Array<double, int(N), 1> weights;
    if (std::abs(slopes.determinant()) > kParallel * std::pow(slopes.cwiseAbs().maxCoeff(), kCount)) {
      const Eigen::Matrix<double, kCount, 1> others = slopes.inverse() * heights;
      weights << 1 - others.sum(), others.array();
    } else {
      weights.setConstant(1.0 / double(N));
    }
    return weights;
  }

  Eigen::Array2d where_the_field_ends(const Corners<2>& corners) const {
    const double first = field_[corners[0].sample], second = field_[corners[1].sample];
    return {second / (second - first), first / (first - second)};
  }

  /// The point at which corners, sorted, part; of two, one is inside.
  template <std::size_t N>
  Eigen::Vector3d parting(const Corners<N>& corners) const {
    Eigen::Array<double, int(N), 1> weights;
    if constexpr (N == 2) weights = all_differ(corners) ? where_all_meet(corners) : where_the_field_ends(corners);
    else weights = where_all_meet(corners);
    weights = weights.max(kLeastWeight).min(1);
    weights /= weights.sum();
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < N; ++n) p += weights[Eigen::Index(n)] * corners[n].at.template cast<double>();
    return p;
  }

  /// The point of an edge or a face.
  template <std::size_t N>
  int point_of(Corners<N> corners) {
    std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) { return a.sample < b.sample; });
    const auto [found, fresh] = points_.try_emplace(key_of(corners), int(mesh_.vertices.size()));
    if (fresh) add(parting(corners));
    return found->second;
  }

  /// The way along which the solid ends on a face, with the solid on the left as seen from outside.
  void end_on(const Corners<3>& face) {
    int leaves = -1, enters = -1;
    for (int n = 0; n < 3; ++n) {
      const bool in = inside(face[n]), next = inside(face[(n + 1) % 3]);
      if (in && !next) leaves = n;
      if (!in && next) enters = n;
    }
    if (leaves < 0) return;
    const int from = point_of<2>({face[leaves], face[(leaves + 1) % 3]}), to = point_of<2>({face[enters], face[(enters + 1) % 3]});
    if (!all_differ(face)) {
      border_.push_back({from, to});
      return;
    }
    meetings_.push_back(point_of(face));
    border_.insert(border_.end(), {{from, meetings_.back()}, {meetings_.back(), to}});
  }

  int middle_of(const std::vector<int>& points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int n : points) sum += mesh_.vertices[std::size_t(n)];
    mesh_.vertices.push_back(sum / double(points.size()));
    return int(mesh_.vertices.size()) - 1;
  }

  /// What the triangles in a tetrahedron have in common. With no more than two parts that is the point of the first of the edges that have one: on either side the same.
  int apex(const Corners<4>& corners) {
    if (all_differ(corners)) return add(parting(corners));
    if (meetings_.size() > 1) return middle_of(meetings_);
    if (meetings_.empty()) {
      const auto beyond = std::find_if(corners.begin(), corners.end(), [&](const Corner& c) { return inside(c) != inside(corners[0]); });
      return point_of<2>({corners[0], *beyond});
    }
    std::vector<int> all;
    for (const auto& way : border_) all.push_back(way[0]);
    return middle_of(all);
  }

  bool ends_in(const Eigen::Vector3i& cell) const {
    int count = 0;
    for (int n = 0; n < 8; ++n) count += field_.at(cell + Eigen::Vector3i(n & 1, n >> 1 & 1, n >> 2)) < 0;
    return count > 0 && count < 8;
  }

  void add_cell(const Eigen::Vector3i& cell) {
    for (std::size_t n = 0; n < kWays.size(); ++n) {
      Corners<4> corners;
      Eigen::Vector3i at = cell;
      for (std::size_t c = 0; c < 4; ++c) {
        corners[c] = {at, field_.shape.index(at)};
        if (c < 3) ++at[kWays[n][c]];
      }
      border_.clear();
      meetings_.clear();
      for (const auto& f : kFaces) {
        Corners<3> face{corners[std::size_t(f[0])], corners[std::size_t(f[1])], corners[std::size_t(f[2])]};
        if (n > 2) std::swap(face[1], face[2]);
        end_on(face);
      }
      if (border_.empty()) continue;
      const int top = apex(corners);
      for (const auto& [from, to] : border_)
        if (from != top && to != top) mesh_.triangles.emplace_back(to, from, top);
    }
  }

  const Grid<float>& field_;
  const Owners owners_;
  TriangleMesh mesh_;
  std::unordered_map<std::uint64_t, int> points_;   // of edges and faces
  std::vector<std::array<int, 2>> border_;          // of the tetrahedron at hand: how the surface goes about it
  std::vector<int> meetings_;                       // of its faces: the points where three parts meet
};

}  // namespace

TriangleMesh shared_surface(const Grid<float>& field, const PartField& part, const std::vector<PartField>& parts) {
  return Extraction(field, part, parts).run();
}

}  // namespace transformables::finishing
