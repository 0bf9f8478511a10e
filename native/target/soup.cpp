// Neighbourhood, orientation and cutting apart of a triangle soup.
#include "target/soup.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int a, int b) {
    a = find(a), b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

/// Neighbours across edges that exactly two faces share.
Neighbours edge_neighbours(const std::vector<Vector3i>& triangles) {
  struct Side {
    std::uint64_t edge;
    std::uint32_t face_corner;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (int c = 0; c < 3; ++c) {
      const std::uint64_t a = std::uint64_t(triangles[f][c]), b = std::uint64_t(triangles[f][(c + 1) % 3]);
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), std::uint32_t(3 * f + c)});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return std::tie(s.edge, s.face_corner) < std::tie(t.edge, t.face_corner);
  });
  Neighbours neighbours(triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0, j; i < sides.size(); i = j) {
    for (j = i + 1; j < sides.size() && sides[j].edge == sides[i].edge;) ++j;
    if (j - i != 2) continue;
    const std::uint32_t s = sides[i].face_corner, t = sides[i + 1].face_corner;
    neighbours[s / 3][s % 3] = int(t / 3);
    neighbours[t / 3][t % 3] = int(s / 3);
  }
  return neighbours;
}

/// The edge of face g that runs between the ends of edge c of face f.
int matching_edge(const std::vector<Vector3i>& triangles, int f, int c, int g) {
  const int a = triangles[f][c], b = triangles[f][(c + 1) % 3];
  for (int d = 0; d < 3; ++d) {
    const int p = triangles[g][d], q = triangles[g][(d + 1) % 3];
    if ((p == a && q == b) || (p == b && q == a)) return d;
  }
  return -1;
}

/// Which faces must be turned so that neighbours agree; as few of each component as possible.
std::vector<std::int8_t> faces_to_turn(const std::vector<Vector3i>& triangles, const Neighbours& neighbours) {
  std::vector<std::int8_t> turn(triangles.size(), -1);
  std::vector<int> queue;
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (turn[start] >= 0) continue;
    queue.assign(1, int(start));
    turn[start] = 0;
    std::size_t turned = 0;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const int f = queue[head];
      turned += std::size_t(turn[f]);
      for (int c = 0; c < 3; ++c) {
        const int g = neighbours[f][c];
        if (g < 0 || turn[g] >= 0) continue;
        const int d = matching_edge(triangles, f, c, g);
        const bool same_way = triangles[g][d] == triangles[f][c];
        turn[g] = std::int8_t(turn[f] ^ int(same_way));
        queue.push_back(g);
      }
    }
    if (2 * turned > queue.size())
      for (const int f : queue) turn[f] ^= 1;
  }
  return turn;
}

/// Edges whose two faces still run the same way belong to a one-sided surface: cut there.
void cut_one_sided(const std::vector<Vector3i>& triangles, Neighbours& neighbours) {
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (int c = 0; c < 3; ++c) {
      const int g = neighbours[f][c];
      if (g < 0) continue;
      const int d = matching_edge(triangles, int(f), c, g);
      if (triangles[g][d] == triangles[f][c]) neighbours[f][c] = neighbours[g][d] = -1;
    }
}

/// Gives each fan of faces about a vertex a vertex of its own; returns how many copies were made.
std::size_t split_fans(TriangleMesh& mesh, const Neighbours& neighbours) {
  UnionFind corners(3 * mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    for (int c = 0; c < 3; ++c) {
      const int g = neighbours[f][c];
      if (g < int(f)) continue;
      const int d = matching_edge(mesh.triangles, int(f), c, g);
      corners.join(int(3 * f) + c, 3 * g + (d + 1) % 3);
      corners.join(int(3 * f) + (c + 1) % 3, 3 * g + d);
    }
  std::vector<char> taken(mesh.vertices.size(), 0);
  std::vector<int> vertex_of(3 * mesh.triangles.size(), -1);
  std::size_t copies = 0;
  for (std::size_t i = 0; i < vertex_of.size(); ++i) {
    const int root = corners.find(int(i));
    int& v = mesh.triangles[i / 3][i % 3];
    if (vertex_of[root] < 0) {
      vertex_of[root] = v;
      if (taken[v]) {
        vertex_of[root] = int(mesh.vertices.size());
        const Vector3d copy = mesh.vertices[v];
        mesh.vertices.push_back(copy);
        ++copies;
      } else {
        taken[v] = 1;
      }
    }
    v = vertex_of[root];
  }
  return copies;
}

void number_components(Manifold& m) {
  UnionFind faces(m.mesh.triangles.size());
  for (std::size_t f = 0; f < m.neighbours.size(); ++f)
    for (const int g : m.neighbours[f])
      if (g >= 0) faces.join(int(f), g);
      else ++m.open_edges;
  m.component.assign(m.mesh.triangles.size(), -1);
  for (std::size_t f = 0; f < m.component.size(); ++f) {
    const int root = faces.find(int(f));
    if (root == int(f)) m.component[f] = m.components++;
    else m.component[f] = m.component[root];
  }
}

}  // namespace

Manifold make_manifold(const TriangleMesh& mesh) {
  Manifold m;
  m.mesh = mesh;
  // Cutting apart can leave two faces alone at an edge that four shared: they are neighbours then, so look again.
  for (int pass = 0; pass < 4; ++pass) {
    m.neighbours = edge_neighbours(m.mesh.triangles);
    const std::vector<std::int8_t> turn = faces_to_turn(m.mesh.triangles, m.neighbours);
    for (std::size_t f = 0; f < turn.size(); ++f)
      if (turn[f]) {
        std::swap(m.mesh.triangles[f][1], m.mesh.triangles[f][2]);
        std::swap(m.neighbours[f][0], m.neighbours[f][2]);
        ++m.turned_faces;
      }
    cut_one_sided(m.mesh.triangles, m.neighbours);
    const std::size_t copies = split_fans(m.mesh, m.neighbours);
    m.split_vertices += copies;
    if (copies == 0) break;
  }
  number_components(m);
  return m;
}

std::vector<std::vector<int>> border_loops(const Manifold& open) {
  std::vector<int> next(open.mesh.vertices.size(), -1);
  for (std::size_t f = 0; f < open.neighbours.size(); ++f)
    for (int c = 0; c < 3; ++c)
      if (open.neighbours[f][c] < 0) next[open.mesh.triangles[f][(c + 1) % 3]] = open.mesh.triangles[f][c];
  std::vector<std::vector<int>> loops;
  for (std::size_t start = 0; start < next.size(); ++start) {
    if (next[start] < 0) continue;
    loops.emplace_back();
    for (int v = int(start); next[v] >= 0;) {
      loops.back().push_back(v);
      const int following = next[v];
      next[v] = -1;
      v = following;
    }
  }
  return loops;
}

TriangleMesh stitch_borders(const Manifold& open, double tolerance) {
  std::vector<int> border;
  for (const auto& loop : border_loops(open)) border.insert(border.end(), loop.begin(), loop.end());
  std::sort(border.begin(), border.end());
  using Cell = std::array<long, 3>;
  std::map<Cell, std::vector<int>> cells;
  std::vector<int> merged(open.mesh.vertices.size());
  std::iota(merged.begin(), merged.end(), 0);
  for (const int v : border) {
    const Vector3d& p = open.mesh.vertices[v];
    Cell home;
    for (int k = 0; k < 3; ++k) home[k] = long(std::floor(p[k] / tolerance));
    for (long n = 0; n < 27 && merged[v] == v; ++n) {
      const auto found = cells.find({home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1});
      if (found == cells.end()) continue;
      for (const int w : found->second)
        if (merged[v] == v && (open.mesh.vertices[w] - p).norm() <= tolerance) merged[v] = w;
    }
    if (merged[v] == v) cells[home].push_back(v);
  }
  TriangleMesh out = open.mesh;
  std::vector<char> collapsed(out.triangles.size(), 0);
  for (std::size_t f = 0; f < out.triangles.size(); ++f) {
    Vector3i& t = out.triangles[f];
    for (int c = 0; c < 3; ++c) t[c] = merged[t[c]];
    collapsed[f] = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  }
  out = without_faces(out, collapsed);
  return make_manifold(out).open_edges < open.open_edges ? out : open.mesh;
}

std::vector<ComponentSize> component_sizes(const Manifold& m) {
  std::vector<Vector3d> origin(std::size_t(m.components), Vector3d::Zero());
  std::vector<double> count(std::size_t(m.components), 0.0);
  for (std::size_t f = 0; f < m.component.size(); ++f)
    for (int c = 0; c < 3; ++c) {
      origin[m.component[f]] += m.mesh.vertices[m.mesh.triangles[f][c]];
      ++count[m.component[f]];
    }
  for (std::size_t i = 0; i < origin.size(); ++i) origin[i] /= count[i];
  std::vector<ComponentSize> sizes(std::size_t(m.components));
  for (std::size_t f = 0; f < m.component.size(); ++f) {
    const Vector3d& o = origin[m.component[f]];
    const Vector3i& t = m.mesh.triangles[f];
    const Vector3d a = m.mesh.vertices[t[0]] - o, b = m.mesh.vertices[t[1]] - o, c = m.mesh.vertices[t[2]] - o;
    sizes[m.component[f]].volume += a.dot(b.cross(c)) / 6;
    sizes[m.component[f]].area += (b - a).cross(c - a).norm() / 2;
  }
  return sizes;
}

}  // namespace transformables
