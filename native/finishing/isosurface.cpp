// The surface of a sampled field, cell by cell: within each cube of eight samples, what lies outside the solid is the
// convex hull of the outside corners and of the crossings on the cube's edges (Bhaniramka, Wenger and Crawfis 2004).
//
// Why this and not a table: a hull in a cube meets each face of the cube in the hull of what lies on that face, so two
// neighbours agree on their common face; and the boundary of a convex body does not meet itself. So the surface is closed,
// manifold and simple whatever the field is, with two to three triangles a cell. Inside samples are connected through the
// six neighbours along the axes, outside samples through all 26; topology.h relies on that.
//
// Crossings keep off the corners (kLeast), so every edge, angle and gap is large against the rounding to float, which
// comes later. All decisions are made on integers: exact.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "finishing/finishing.h"

namespace transformables {
namespace {

using Point = Eigen::Matrix<std::int64_t, 3, 1>;

constexpr int kUnit = 4096;                ///< integer length of a cell's edge
constexpr int kLeast = kUnit / 20;         ///< crossings stay this far from both corners
constexpr int kMostCrossings = 12;

struct Crossing {
  Point at;       ///< in the cell, 0 to kUnit
  int vertex = 0; ///< index into the mesh
};

/// The eight corners and twelve edges of a cell with a surface in it.
struct Cell {
  std::array<Crossing, kMostCrossings> crossings;
  int count = 0;
  std::array<Point, 8> outside;
  int outside_count = 0;
};

int crossing_parameter(float from, float to) {
  const double t = double(from) / (double(from) - double(to));
  return std::clamp(int(t * kUnit + 0.5), kLeast, kUnit - kLeast);
}

bool on_a_face(const Point& a, const Point& b, const Point& c) {
  for (int axis = 0; axis < 3; ++axis)
    if (a[axis] == b[axis] && b[axis] == c[axis] && (a[axis] == 0 || a[axis] == kUnit)) return true;
  return false;
}

/// Which crossings lie in the plane through three of them, when the plane has all other points on one side; else 0.
/// `normal` is turned towards those points, that is, out of the solid.
unsigned supporting_plane(const Cell& cell, int i, int j, int k, Point& normal) {
  const Point& a = cell.crossings[i].at;
  normal = (cell.crossings[j].at - a).cross(cell.crossings[k].at - a);
  unsigned members = 0;
  int side = 0;
  const auto fits = [&](std::int64_t height) {
    if (height == 0) return true;
    const int sign = height > 0 ? 1 : -1;
    if (side == 0) side = sign;
    return side == sign;
  };
  for (int n = 0; n < cell.count; ++n) {
    const std::int64_t height = normal.dot(cell.crossings[n].at - a);
    if (!fits(height)) return 0;
    if (height == 0) members |= 1u << n;
  }
  for (int n = 0; n < cell.outside_count; ++n)
    if (!fits(normal.dot(cell.outside[n] - a))) return 0;
  normal *= side;
  return members;
}

/// Triangles of a convex polygon whose corners are given as a set: its border is found by wrapping, then fanned.
void add_polygon(const Cell& cell, unsigned members, const Point& normal, std::vector<Eigen::Vector3i>& triangles) {
  int first = 0;
  while (!(members >> first & 1)) ++first;
  std::array<int, kMostCrossings> loop;
  int length = 0, at = first;
  do {
    loop[length++] = at;
    int next = -1;
    for (int n = 0; n < cell.count; ++n) {
      if (n == at || !(members >> n & 1)) continue;
      if (next < 0) {
        next = n;
        continue;
      }
      const Point &p = cell.crossings[at].at, &q = cell.crossings[next].at, &r = cell.crossings[n].at;
      if (normal.dot((q - p).cross(r - p)) < 0) next = n;
    }
    at = next;
  } while (at != first && length < kMostCrossings);
  for (int n = 1; n + 1 < length; ++n)
    triangles.emplace_back(cell.crossings[loop[0]].vertex, cell.crossings[loop[n]].vertex,
                           cell.crossings[loop[n + 1]].vertex);
}

void add_cell(const Cell& cell, std::vector<Eigen::Vector3i>& triangles) {
  std::array<unsigned, 64> done;
  std::size_t done_count = 0;
  for (int i = 0; i < cell.count; ++i)
    for (int j = i + 1; j < cell.count; ++j)
      for (int k = j + 1; k < cell.count; ++k) {
        if (on_a_face(cell.crossings[i].at, cell.crossings[j].at, cell.crossings[k].at)) continue;
        Point normal;
        const unsigned members = supporting_plane(cell, i, j, k, normal);
        if (members == 0) continue;
        // A plane with more than three crossings is met once for each three of them.
        if ((members & (members - 1)) == 0) continue;
        if (std::find(done.begin(), done.begin() + done_count, members) != done.begin() + done_count) continue;
        done[done_count++] = members;
        add_polygon(cell, members, normal, triangles);
      }
}

/// The mesh vertex on each lattice edge that the surface crosses, three edges a sample.
struct EdgeVertices {
  std::vector<std::array<std::int32_t, 3>> vertex;
  std::vector<std::array<std::int16_t, 3>> parameter;
};

bool inside(float value) { return value < 0; }

void check_border(const Grid<float>& field) {
  const Eigen::Vector3i n = field.shape.size;
  if ((n.array() < 2).any() || field.values.size() != field.shape.count())
    throw InvalidInput("The field has fewer than two samples along an axis, or the wrong number of values.");
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j) {
      const bool edge = k == 0 || j == 0 || k + 1 == n.z() || j + 1 == n.y();
      for (int i = 0; i < n.x(); i += edge ? 1 : n.x() - 1)
        if (!(field.at({i, j, k}) >= 0))
          throw InvalidInput("The field is not positive at its border; give the solid a margin of one sample.");
    }
}

EdgeVertices place_vertices(const Grid<float>& field, TriangleMesh& mesh) {
  const GridShape& s = field.shape;
  EdgeVertices edges;
  edges.vertex.assign(s.count(), {-1, -1, -1});
  edges.parameter.assign(s.count(), {0, 0, 0});
  const std::array<std::size_t, 3> stride{1, std::size_t(s.size.x()), std::size_t(s.size.x()) * s.size.y()};
  for (int k = 0; k < s.size.z(); ++k)
    for (int j = 0; j < s.size.y(); ++j)
      for (int i = 0; i < s.size.x(); ++i) {
        const std::size_t here = s.index(i, j, k);
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3i c(i, j, k);
          if (c[axis] + 1 >= s.size[axis]) continue;
          const float a = field[here], b = field[here + stride[axis]];
          if (inside(a) == inside(b)) continue;
          const int t = crossing_parameter(a, b);
          Eigen::Vector3d p = c.cast<double>();
          p[axis] += double(t) / kUnit;
          edges.vertex[here][axis] = int(mesh.vertices.size());
          edges.parameter[here][axis] = std::int16_t(t);
          mesh.vertices.push_back(s.origin + s.step * p);
        }
      }
  return edges;
}

/// Fills `cell` with what the cube at (i, j, k) holds; false when the surface does not pass through it.
bool gather(const Grid<float>& field, const EdgeVertices& edges, const Eigen::Vector3i& corner, Cell& cell) {
  const GridShape& s = field.shape;
  cell.count = cell.outside_count = 0;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3i d(n & 1, n >> 1 & 1, n >> 2 & 1);
    if (!inside(field.at(corner + d))) cell.outside[cell.outside_count++] = d.cast<std::int64_t>() * kUnit;
  }
  if (cell.outside_count == 0 || cell.outside_count == 8) return false;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3i d(n & 1, n >> 1 & 1, n >> 2 & 1);
    const std::size_t here = s.index(corner + d);
    for (int axis = 0; axis < 3; ++axis) {
      if (d[axis] || edges.vertex[here][axis] < 0) continue;
      Crossing& crossing = cell.crossings[cell.count++];
      crossing.at = d.cast<std::int64_t>() * kUnit;
      crossing.at[axis] += edges.parameter[here][axis];
      crossing.vertex = edges.vertex[here][axis];
    }
  }
  return true;
}

}  // namespace

TriangleMesh isosurface(const Grid<float>& field) {
  check_border(field);
  TriangleMesh mesh;
  const EdgeVertices edges = place_vertices(field, mesh);
  Cell cell;
  const Eigen::Vector3i n = field.shape.size;
  for (int k = 0; k + 1 < n.z(); ++k)
    for (int j = 0; j + 1 < n.y(); ++j)
      for (int i = 0; i + 1 < n.x(); ++i)
        if (gather(field, edges, {i, j, k}, cell)) add_cell(cell, mesh.triangles);
  return mesh;
}

}  // namespace transformables
