// Signed distance of a closed mesh on a regular grid. Our own, and not OpenVDB's meshToVolume, because that one takes a
// cavity for solid, does not clip a mesh to the grid asked for, and ends the process when memory runs out.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/error.h"
#include "target/target.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kBand = 4;                      // steps: distances up to here are exact
constexpr double kMostSamples = 3e8;             // 1.2 GB of values
constexpr std::size_t kMostSweptSamples = 3000000;  // about a quarter of a second
constexpr float kFar = 1e15f;                    // not reached yet; its square is still a float

struct Triangle {
  Vector3d a, b, c;           // in steps from sample (0, 0, 0)
  Vector3d unit_normal;       // zero for a needle
  Vector3d middle;
  double radius;              // about the middle
  Vector3d low, high;
};

/// For each plane of samples the triangles that reach it, ascending.
struct Planes {
  std::vector<std::size_t> start;
  std::vector<std::uint32_t> triangle;
};

double length2_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (p - a - t * d).squaredNorm();
}

double length2_to_triangle(const Vector3d& p, const Triangle& t) {
  const Vector3d ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d00 = ab.dot(ab), d01 = ab.dot(ac), d11 = ac.dot(ac), d20 = ap.dot(ab), d21 = ap.dot(ac);
  const double area = d00 * d11 - d01 * d01, v = d11 * d20 - d01 * d21, w = d00 * d21 - d01 * d20;
  if (area > 1e-20 * d00 * d11 && v >= 0 && w >= 0 && v + w <= area) {
    const double height = t.unit_normal.dot(ap);
    return height * height;
  }
  return std::min({length2_to_segment(p, t.a, t.b), length2_to_segment(p, t.b, t.c), length2_to_segment(p, t.c, t.a)});
}

std::vector<Triangle> in_steps(const TriangleMesh& mesh, const GridShape& shape) {
  std::vector<Triangle> out(mesh.triangles.size());
  const auto place = [&](int v) -> Vector3d { return (mesh.vertices[v] - shape.origin) / shape.step; };
  tbb::parallel_for(std::size_t(0), out.size(), [&](std::size_t f) {
    Triangle& t = out[f];
    t.a = place(mesh.triangles[f][0]), t.b = place(mesh.triangles[f][1]), t.c = place(mesh.triangles[f][2]);
    const Vector3d normal = (t.b - t.a).cross(t.c - t.a);
    t.unit_normal = normal.norm() > 0 ? Vector3d(normal / normal.norm()) : Vector3d(Vector3d::Zero());
    t.low = t.a.cwiseMin(t.b).cwiseMin(t.c), t.high = t.a.cwiseMax(t.b).cwiseMax(t.c);
    t.middle = (t.low + t.high) / 2;
    t.radius = std::sqrt(std::max({(t.a - t.middle).squaredNorm(), (t.b - t.middle).squaredNorm(), (t.c - t.middle).squaredNorm()}));
  });
  return out;
}

/// Samples of one axis within a reach of an interval, clipped to the grid; empty when last < first.
struct Range {
  int first, last;
};
Range samples_between(double low, double high, int size) {
  return {int(std::ceil(std::clamp(low, 0.0, double(size)))), int(std::floor(std::clamp(high, -1.0, size - 1.0)))};
}

Planes by_plane(const std::vector<Triangle>& triangles, const Vector3i& size, double reach) {
  Planes planes;
  planes.start.assign(std::size_t(size.z()) + 1, 0);
  const auto range = [&](const Triangle& t) {
    const bool beside = t.high.x() + reach < 0 || t.high.y() + reach < 0 || t.low.y() - reach > size.y() - 1;
    return beside ? Range{0, -1} : samples_between(t.low.z() - reach, t.high.z() + reach, size.z());
  };
  for (const Triangle& t : triangles) {
    const Range r = range(t);
    for (int k = r.first; k <= r.last; ++k) ++planes.start[std::size_t(k) + 1];
  }
  for (std::size_t k = 1; k < planes.start.size(); ++k) planes.start[k] += planes.start[k - 1];
  planes.triangle.resize(planes.start.back());
  std::vector<std::size_t> next = planes.start;
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Range r = range(triangles[f]);
    for (int k = r.first; k <= r.last; ++k) planes.triangle[next[k]++] = std::uint32_t(f);
  }
  return planes;
}

/// Lowers the squared distances of one row of samples to those from a triangle, as far as its reach.
void lower_row(float* row, int size_x, double y, double z, const Triangle& t, double reach) {
  const double dy = std::max({t.low.y() - y, y - t.high.y(), 0.0}), dz = std::max({t.low.z() - z, z - t.high.z(), 0.0});
  const double left = reach * reach - dy * dy - dz * dz;
  if (left < 0) return;
  double low = t.low.x() - std::sqrt(left), high = t.high.x() + std::sqrt(left);
  const Vector3d& n = t.unit_normal;
  if (std::abs(n.x()) > 1e-3) {  // only where the triangle's plane is near; matters for large slanting triangles
    const double on_plane = t.a.x() - (n.y() * (y - t.a.y()) + n.z() * (z - t.a.z())) / n.x();
    const double half = reach / std::abs(n.x()) + 1e-9;
    low = std::max(low, on_plane - half), high = std::min(high, on_plane + half);
  }
  const Range range = samples_between(low, high, size_x);
  for (int i = range.first; i <= range.last; ++i) {
    const Vector3d p(i, y, z);
    const double bound = std::sqrt(double(row[i])) + t.radius;
    if ((p - t.middle).squaredNorm() > bound * bound) continue;
    const double d2 = length2_to_triangle(p, t);
    if (d2 <= reach * reach && d2 < double(row[i])) row[i] = float(d2);
  }
}

/// Squared distances of all samples within reach of the surface; the others keep what they have.
void lower_near_surface(std::vector<float>& values, const Vector3i& size, const std::vector<Triangle>& triangles, double reach) {
  const Planes planes = by_plane(triangles, size, reach);
  tbb::parallel_for(0, size.z(), [&](int k) {
    for (std::size_t n = planes.start[k]; n < planes.start[std::size_t(k) + 1]; ++n) {
      const Triangle& t = triangles[planes.triangle[n]];
      const Range rows = samples_between(t.low.y() - reach, t.high.y() + reach, size.y());
      for (int j = rows.first; j <= rows.last; ++j)
        lower_row(values.data() + (std::size_t(k) * size.y() + j) * size.x(), size.x(), j, k, t, reach);
    }
  });
}

/// Godunov's upwind solution of |grad u| = 1 at a sample, from the least value along each axis.
float upwind(float a, float b, float c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  if (a + 1 <= b) return a + 1;
  const float two = (a + b + std::sqrt(2 - (b - a) * (b - a))) / 2;
  if (two <= c) return two;
  const float p = b - a, q = c - a;  // relative to a: no cancellation between large squares
  const float s = p + q;
  return a + (s + std::sqrt(std::max(0.0f, s * s - 3 * (p * p + q * q - 1)))) / 3;
}

/// Solves |grad u| = 1 from the values up to `known` on, by fast sweeping (Zhao 2005), one step between neighbours. One
/// round of all eight directions does, as the ways back to the surface are straight.
void sweep(std::vector<float>& values, const Vector3i& n, float known) {
  const std::ptrdiff_t dy = n.x(), dz = std::ptrdiff_t(n.x()) * n.y();
  const float least = std::nextafter(known, kFar);
  for (int way = 0; way < 8; ++way) {
    const bool back_x = way & 1, back_y = way & 2, back_z = way & 4;
    for (int kk = 0; kk < n.z(); ++kk)
      for (int jj = 0; jj < n.y(); ++jj)
        for (int ii = 0; ii < n.x(); ++ii) {
          const int i = back_x ? n.x() - 1 - ii : ii, j = back_y ? n.y() - 1 - jj : jj, k = back_z ? n.z() - 1 - kk : kk;
          float* v = values.data() + k * dz + j * dy + i;
          if (*v <= known) continue;
          const float x = std::min(i > 0 ? v[-1] : kFar, i + 1 < n.x() ? v[1] : kFar);
          const float y = std::min(j > 0 ? v[-dy] : kFar, j + 1 < n.y() ? v[dy] : kFar);
          const float z = std::min(k > 0 ? v[-dz] : kFar, k + 1 < n.z() ? v[dz] : kFar);
          if (std::min({x, y, z}) + 1 < kFar) *v = std::min(*v, std::max(upwind(x, y, z), least));
        }
  }
}

/// Distances beyond the band. A large grid is swept on every second (or fourth) sample only, and the rest read between.
void fill_beyond_band(Grid<float>& grid) {
  const Vector3i n = grid.shape.size;
  int stride = 1;
  while (grid.shape.count() > kMostSweptSamples * std::size_t(stride * stride * stride) && stride < kBand) stride *= 2;
  if (stride == 1) return sweep(grid.values, n, float(kBand));
  GridShape coarse_shape;
  coarse_shape.size = ((n.array() - 1) / stride + 2).matrix();
  Grid<float> coarse(coarse_shape, kFar);
  for (std::size_t i = 0; i < coarse.values.size(); ++i) {
    const Vector3i c = stride * coarse_shape.cell(i);
    if (grid.shape.contains(c)) coarse[i] = std::min(kFar, grid.at(c) / float(stride));
  }
  sweep(coarse.values, coarse_shape.size, float(kBand / stride));
  const float least = std::nextafter(float(kBand), kFar);
  tbb::parallel_for(0, n.z(), [&](int k) {
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i) {
        float& v = grid.at({i, j, k});
        if (v > float(kBand)) v = std::max(least, float(stride) * sample(coarse, Vector3d(i, j, k) / stride));
      }
  });
}

/// Which side of the line from a to b a ray along x at (y, z) passes, 1 or -1; both triangles at an edge get the same
/// answer, also when the ray meets the edge: it counts as moved a little towards +y, and less towards +z.
int side_of(const Vector3d& a, const Vector3d& b, double y, double z) {
  const bool swapped = a.y() != b.y() ? a.y() > b.y() : a.z() > b.z();
  const Vector3d &p = swapped ? b : a, &q = swapped ? a : b;
  double s = (q.y() - p.y()) * (z - p.z()) - (q.z() - p.z()) * (y - p.y());
  if (s == 0) s = q.z() != p.z() ? p.z() - q.z() : q.y() - p.y();
  return (s > 0) != swapped ? 1 : -1;
}

struct Crossing {
  int row;
  double x;
  int turn;  ///< 1 where the ray to +x leaves the solid, -1 where it enters
};

std::vector<Crossing> crossings_of_plane(const std::vector<Triangle>& triangles, const Planes& planes, int k, int rows) {
  std::vector<Crossing> crossings;
  for (std::size_t n = planes.start[k]; n < planes.start[std::size_t(k) + 1]; ++n) {
    const Triangle& t = triangles[planes.triangle[n]];
    const Range range = samples_between(t.low.y(), t.high.y(), rows);
    for (int j = range.first; j <= range.last; ++j) {
      const int side = side_of(t.a, t.b, j, k);
      if (side_of(t.b, t.c, j, k) != side || side_of(t.c, t.a, j, k) != side) continue;
      const Vector3d& m = t.unit_normal;
      const double x = m.x() != 0 ? t.a.x() - (m.y() * (j - t.a.y()) + m.z() * (k - t.a.z())) / m.x() : t.a.x();
      crossings.push_back({j, std::clamp(x, t.low.x(), t.high.x()), side});
    }
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.row != b.row ? a.row < b.row : a.x > b.x;
  });
  return crossings;
}

/// Negative where the winding number is positive, counted along rays to +x: cavities stay empty, and solids that
/// overlap count as one.
void sign_by_winding(std::vector<float>& values, const Vector3i& size, const std::vector<Triangle>& triangles) {
  const Planes planes = by_plane(triangles, size, 0);
  tbb::parallel_for(0, size.z(), [&](int k) {
    const std::vector<Crossing> crossings = crossings_of_plane(triangles, planes, k, size.y());
    for (std::size_t n = 0; n < crossings.size();) {
      const int row = crossings[n].row;
      float* v = values.data() + (std::size_t(k) * size.y() + row) * size.x();
      int winding = 0;
      for (int i = size.x() - 1; i >= 0; --i) {
        for (; n < crossings.size() && crossings[n].row == row && crossings[n].x > i; ++n) winding += crossings[n].turn;
        if (winding > 0) v[i] = -v[i];
      }
      while (n < crossings.size() && crossings[n].row == row) ++n;
    }
  });
}

void check_grid(const TriangleMesh& mesh, const GridShape& shape) {
  if (mesh.empty()) throw InvalidInput("The mesh has no faces, so there is no distance to it.");
  if ((shape.size.array() < 1).any() || !(shape.step > 0) || !shape.origin.allFinite())
    throw InvalidInput("The distance grid is empty: give it at least one sample along each axis, and a step above 0.");
  const double samples = double(shape.size.x()) * shape.size.y() * shape.size.z();
  if (samples > kMostSamples)
    throw InvalidInput("The distance grid would have " + std::to_string(std::int64_t(samples / 1e6)) +
                       " million samples, too many for the memory: choose a lower resolution.");
}

}  // namespace

Grid<float> signed_distance(const TriangleMesh& mesh, const GridShape& shape) {
  check_grid(mesh, shape);
  Grid<float> grid(shape, kFar * kFar);
  const std::vector<Triangle> triangles = in_steps(mesh, shape);
  lower_near_surface(grid.values, shape.size, triangles, 1);  // a first bound, that saves most of the second pass
  lower_near_surface(grid.values, shape.size, triangles, kBand);
  const auto unreached = [&](float v) { return v >= kFar; };
  for (double reach = 2 * kBand; std::all_of(grid.values.begin(), grid.values.end(), unreached); reach *= 2)
    lower_near_surface(grid.values, shape.size, triangles, reach);  // the grid is far from the surface
  tbb::parallel_for(std::size_t(0), grid.values.size(), [&](std::size_t i) {
    grid.values[i] = grid.values[i] >= kFar ? kFar : std::sqrt(grid.values[i]);
  });
  fill_beyond_band(grid);
  const float step = float(shape.step);
  tbb::parallel_for(std::size_t(0), grid.values.size(), [&](std::size_t i) { grid.values[i] *= step; });
  sign_by_winding(grid.values, shape.size, triangles);
  return grid;
}

Grid<float> signed_distance(const Target& target, const GridShape& shape) { return signed_distance(target.mesh, shape); }

}  // namespace transformables
