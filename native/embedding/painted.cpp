#include "embedding/painted.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "embedding/voxels.h"

namespace transformables {
namespace {

constexpr int kPlaces = 48;   // of a region: as many as need be to tell which bone is nearest to most of it

constexpr double kClear = 0.02;   // target units: others have to be farther by that, or half a region would be near enough

using Triangle = std::array<Eigen::Vector3d, 3>;

double area_of(const Triangle& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); }

/// Places spread evenly over the area: along its sum, and within triangles by a sequence of low discrepancy (the plastic number's).
std::vector<Eigen::Vector3d> spread(const std::vector<Triangle>& triangles) {
  double whole = 0;
  for (const Triangle& t : triangles) whole += area_of(t);
  std::vector<Eigen::Vector3d> places;
  double passed = 0;
  for (const Triangle& t : triangles) {
    passed += area_of(t);
    while (int(places.size()) < kPlaces && passed > (double(places.size()) + 0.5) / kPlaces * whole) {
      const double k = double(places.size()) + 1;
      double u = std::fmod(0.7548776662 * k, 1), v = std::fmod(0.5698402910 * k, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      places.push_back(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]));
    }
  }
  return places;
}

/// Distance from a place to a bone's capsules; negative in them.
double distance_to(const Skeleton& skeleton, std::size_t bone, const Eigen::Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (int s = skeleton.first_segment[bone]; s < skeleton.first_segment[bone + 1]; ++s) {
    const Skeleton::PosedSegment& segment = skeleton.segments[std::size_t(s)];
    const Eigen::Vector3d from = p - segment.a;
    const double at = std::clamp(from.dot(segment.direction), 0.0, segment.length);
    least = std::min(least, (from - at * segment.direction).squaredNorm());
  }
  return std::sqrt(least) - skeleton.character.bones[bone].radius;
}

}  // namespace

PaintedTerm::PaintedTerm(const std::vector<PaintedRegion>& regions) {
  for (const PaintedRegion& region : regions)
    if (std::vector<Eigen::Vector3d> places = spread(region.triangles); !places.empty()) regions_.push_back({region.bone, std::move(places)});
}

double PaintedTerm::operator()(const Skeleton& skeleton) const {
  double sum = 0;
  const std::size_t bones = skeleton.character.bones.size();
  for (const Region& region : regions_) {
    std::array<double, kMostBones> behind{}, distance;   // of each bone: behind the nearest one, and to the place
    for (const Eigen::Vector3d& p : region.places) {
      double first = std::numeric_limits<double>::infinity(), second = first;
      for (std::size_t b = 0; b < bones; ++b) {
        distance[b] = distance_to(skeleton, b, p);
        second = std::min(second, std::max(first, distance[b]));
        first = std::min(first, distance[b]);
      }
      for (std::size_t b = 0; b < bones; ++b) behind[b] += std::max(0.0, distance[b] - (distance[b] > first ? first : second) + kClear);
    }
    const double missed = region.bone >= 0 ? behind[std::size_t(region.bone)] : *std::min_element(behind.begin(), behind.begin() + bones);
    sum += missed / double(region.places.size());
  }
  return sum;
}

}  // namespace transformables
