#include "finishing/hinge_shape.h"

#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kAround = 40;              ///< sides of whatever is round: of a pin of 3 mm a side is 5 thousandths flat
constexpr double kArcStep = kPi / 18;

// Shares of the housing's radius. At 3.5 mm: a pin of 2.9 mm, a tongue of 2.5 mm, ears of 1.8 mm at the least.
constexpr double kPin = 0.42;
constexpr double kHalfTongue = 0.36;
constexpr double kWeakEar = 0.2;
constexpr double kWeakRing = 0.22;

/// Half an outline: (distance from the axis, height).
using Outline = std::vector<Eigen::Vector2d>;

void append_arc(Outline& outline, double radius, double polar_from, double polar_to) {
  const int steps = std::max(1, int(std::ceil(std::abs(polar_to - polar_from) / kArcStep)));
  for (int n = 0; n <= steps; ++n) {
    const double polar = polar_from + (polar_to - polar_from) * n / steps;
    outline.emplace_back(radius * std::sin(polar), radius * std::cos(polar));
  }
}

double polar_at(double height, double radius) { return std::acos(std::clamp(height / radius, -1.0, 1.0)); }

/// Turns an outline, given from above to below on its outer side, about the axis. Its first and last points are on the axis, or it is a loop.
TriangleMesh turned(Outline outline, bool loop) {
  if (!loop) outline.front().x() = outline.back().x() = 0;
  TriangleMesh mesh;
  std::vector<int> first;
  for (const Eigen::Vector2d& p : outline) {
    first.push_back(int(mesh.vertices.size()));
    const int count = p.x() > 0 ? kAround : 1;
    for (int n = 0; n < count; ++n) {
      const double a = 2 * kPi * n / kAround;
      mesh.vertices.emplace_back(p.x() * std::cos(a), p.x() * std::sin(a), p.y());
    }
  }
  const std::size_t rings = outline.size();
  const auto at = [&](std::size_t r, int n) { return first[r] + (outline[r].x() > 0 ? n % kAround : 0); };
  for (std::size_t r = 0; r < (loop ? rings : rings - 1); ++r) {
    const std::size_t s = (r + 1) % rings;
    for (int n = 0; n < kAround; ++n) {
      if (outline[s].x() > 0) mesh.triangles.emplace_back(at(r, n), at(s, n), at(s, n + 1));
      if (outline[r].x() > 0) mesh.triangles.emplace_back(at(r, n), at(s, n + 1), at(r, n + 1));
    }
  }
  return mesh;
}

}  // namespace

bool hinge_size(double housing, double gap, double room, HingeSize& size) {
  size.outer = housing + gap / 2;
  size.inner = std::min(size.outer - gap, room);
  size.gap = gap;
  size.pin = kPin * housing;
  size.half_tongue = kHalfTongue * housing;
  return size.inner - size.ear_face() >= kWeakEar * housing && size.inner - size.hole() >= kWeakRing * housing;
}

TriangleMesh spool(double ball, double face, double radius) {
  const double edge = polar_at(face, ball);
  Outline outline;
  append_arc(outline, ball, 0, edge);
  outline.emplace_back(radius, face);
  outline.emplace_back(radius, -face);
  append_arc(outline, ball, kPi - edge, kPi);
  return turned(std::move(outline), false);
}

TriangleMesh ring(double ball, double face, double radius) {
  const double edge = polar_at(face, ball);
  Outline outline;
  append_arc(outline, ball, edge, kPi - edge);
  outline.emplace_back(radius, -face);
  outline.emplace_back(radius, face);
  return turned(std::move(outline), true);
}

TriangleMesh block(const Block& b) {
  const bool band = b.azimuth_to - b.azimuth_from > 2 * kPi - 1e-9;
  const int across = std::max(1, int(std::ceil((b.polar_to - b.polar_from) / kArcStep)));
  const int along = std::max(1, int(std::ceil((b.azimuth_to - b.azimuth_from) / kArcStep)));
  const int columns = band ? along : along + 1;
  TriangleMesh mesh;
  for (const double radius : {b.from, b.to})
    for (int n = 0; n < columns; ++n)
      for (int m = 0; m <= across; ++m) {
        const double polar = b.polar_from + (b.polar_to - b.polar_from) * m / across;
        const double azimuth = b.azimuth_from + (b.azimuth_to - b.azimuth_from) * n / along;
        mesh.vertices.emplace_back(radius * std::sin(polar) * std::cos(azimuth), radius * std::sin(polar) * std::sin(azimuth), radius * std::cos(polar));
      }
  const auto at = [&](int layer, int n, int m) { return (layer * columns + n % columns) * (across + 1) + m; };
  const auto quad = [&](int p, int q, int r, int s) {
    mesh.triangles.emplace_back(p, q, r);
    mesh.triangles.emplace_back(p, r, s);
  };
  for (int n = 0; n < along; ++n) {
    for (int m = 0; m < across; ++m) {
      quad(at(1, n, m), at(1, n, m + 1), at(1, n + 1, m + 1), at(1, n + 1, m));
      quad(at(0, n, m), at(0, n + 1, m), at(0, n + 1, m + 1), at(0, n, m + 1));
    }
    quad(at(0, n, 0), at(1, n, 0), at(1, n + 1, 0), at(0, n + 1, 0));
    quad(at(0, n, across), at(0, n + 1, across), at(1, n + 1, across), at(1, n, across));
  }
  if (band) return mesh;
  for (int m = 0; m < across; ++m) {
    quad(at(0, 0, m), at(0, 0, m + 1), at(1, 0, m + 1), at(1, 0, m));
    quad(at(0, along, m), at(1, along, m), at(1, along, m + 1), at(0, along, m + 1));
  }
  return mesh;
}

}  // namespace transformables::finishing
