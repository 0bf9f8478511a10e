#include "segmentation/region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "segmentation/lattice.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kSpacing = 0.4;       // steps between the points that stand for a triangle
constexpr double kLeastDepth = 3;      // steps
constexpr double kUnder = 1.5;         // steps: as near as that to a painted place is painted, too
constexpr double kTolerance = 0.5;     // steps: sampled points and the target's distance are as exact as that
constexpr double kOnSurface = 2;       // steps

using Corners = std::array<Eigen::Vector3d, 3>;

double area_of(const Corners& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); }

// Points spread over a triangle; a small one is stood for by its centre.
void sprinkle(const Corners& t, double spacing, std::vector<Eigen::Vector3d>& points) {
  const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  const int n = int(std::ceil(longest / spacing));
  if (n <= 1) {
    points.push_back((t[0] + t[1] + t[2]) / 3);
    return;
  }
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) points.push_back(t[0] + (t[1] - t[0]) * (double(i) / n) + (t[2] - t[0]) * (double(j) / n));
}

// For each inside sample the distance to the nearest painted point, by ways within the target, up to a depth.
std::vector<double> distances(const Target& target, const std::vector<Eigen::Vector3d>& points, double depth) {
  const GridShape& shape = target.distance.shape;
  const std::vector<char> inside = inside_flags(target);
  std::vector<double> best(shape.count(), std::numeric_limits<double>::infinity());
  std::vector<int> nearest(shape.count(), -1);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto offer = [&](std::size_t i, int point) {
    const double d = (shape.position(i) - points[point]).norm();
    if (inside[i] && d <= depth && d < best[i]) best[i] = d, nearest[i] = point, open.push({d, i});
  };
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3i c = shape.nearest(points[k]);
    for (int o = 0; o < 27; ++o) {
      const Eigen::Vector3i n = c + Eigen::Vector3i(o % 3 - 1, o / 3 % 3 - 1, o / 9 - 1);
      if (shape.contains(n)) offer(shape.index(n), int(k));
    }
  }
  while (!open.empty()) {
    const auto [d, i] = open.top();
    open.pop();
    if (d > best[i]) continue;
    for_neighbours(shape, i, [&](std::size_t n) { offer(n, nearest[i]); });
  }
  return best;
}

}  // namespace

Region region_of(const Target& target, const std::vector<Corners>& painted) {
  const double step = target.distance.shape.step;
  Region region;
  std::vector<Eigen::Vector3d> points;
  double area = 0, on_target = 0;
  for (const Corners& t : painted) {
    const std::size_t first = points.size();
    sprinkle(t, kSpacing * step, points);
    std::size_t near = 0;
    for (std::size_t k = first; k < points.size(); ++k) near += std::abs(distance_at(target, points[k])) < kOnSurface * step;
    const double share = double(near) / double(points.size() - first);
    area += area_of(t);
    on_target += share * area_of(t);
  }
  region.on_target = area > 0 ? on_target / area : 0;
  const std::vector<double> way = distances(target, points, std::max(kLeastDepth * step, 0.5 * std::sqrt(area)));
  for (std::size_t i : target.inside) {
    const double depth = -target.distance[i];
    const bool under = way[i] < kUnder * step;
    if (!under && way[i] > depth + kTolerance * step) continue;
    region.samples.push_back(i);
    if (under && depth < kUnder * step) region.shown.push_back(i);
  }
  return region;
}

}  // namespace transformables::segmentation_inner
