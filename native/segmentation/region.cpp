#include "segmentation/region.h"

#include <algorithm>
#include <cmath>

#include "segmentation/lattice.h"
#include "segmentation/ways.h"

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
  const std::vector<char> inside = inside_flags(target);
  const double deepest = std::max(kLeastDepth * step, 0.5 * std::sqrt(area));
  const std::vector<double> way = nearest_points(target.distance.shape, points, deepest, [&](std::size_t i) { return inside[i] != 0; }).distance;
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
