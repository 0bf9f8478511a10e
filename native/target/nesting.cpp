#include "target/nesting.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "target/mend.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

struct Piece {
  TriangleMesh mesh;
  Eigen::AlignedBox3d box;
  double volume = 0;  ///< as the user turned it
  int parent = -1;    ///< the smallest kept piece around it
  bool kept = true;
  int side = 1;       ///< 1: solid within, -1: a cavity
};

std::vector<Piece> pieces_of(const Manifold& m) {
  std::vector<Piece> pieces(std::size_t(m.components));
  for (std::size_t i = 0; i < pieces.size(); ++i) pieces[i].volume = 0;
  for (std::size_t f = 0; f < m.component.size(); ++f) pieces[m.component[f]].mesh.triangles.push_back(m.mesh.triangles[f]);
  const std::vector<ComponentSize> sizes = component_sizes(m);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    pieces[i].volume = sizes[i].volume;
    for (Vector3i& t : pieces[i].mesh.triangles)
      for (int c = 0; c < 3; ++c) {
        pieces[i].mesh.vertices.push_back(m.mesh.vertices[t[c]]);
        t[c] = int(pieces[i].mesh.vertices.size()) - 1;
        pieces[i].box.extend(pieces[i].mesh.vertices.back());
      }
  }
  return pieces;
}

bool encloses(const Piece& outer, const Piece& inner) {
  return outer.box.contains(inner.box) && std::abs(winding_number(outer.mesh, inner.mesh.vertices.front())) > 0.5;
}

}  // namespace

double winding_number(const TriangleMesh& mesh, const Vector3d& p) {
  double angle = 0;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p, c = mesh.vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

TriangleMesh turn_outward(const Manifold& m, std::vector<std::string>& warnings) {
  std::vector<Piece> pieces = pieces_of(m);
  std::vector<int> largest_first(pieces.size());
  std::iota(largest_first.begin(), largest_first.end(), 0);
  std::stable_sort(largest_first.begin(), largest_first.end(),
                   [&](int a, int b) { return std::abs(pieces[a].volume) > std::abs(pieces[b].volume); });
  std::vector<int> kept;
  std::size_t dropped = 0, turned = 0;
  for (const int i : largest_first) {
    Piece& piece = pieces[i];
    for (const int j : kept)  // the last one that encloses it is the smallest
      if (encloses(pieces[j], piece)) piece.parent = j;
    if (piece.parent >= 0) {
      piece.kept = piece.volume * pieces[piece.parent].volume < 0;
      piece.side = -pieces[piece.parent].side;
    }
    if (piece.kept) kept.push_back(i);
    else ++dropped;
  }
  TriangleMesh out = m.mesh;
  std::vector<char> drop(out.triangles.size(), 0);
  for (std::size_t f = 0; f < drop.size(); ++f) {
    const Piece& piece = pieces[m.component[f]];
    drop[f] = !piece.kept;
    if (piece.volume * piece.side < 0) std::swap(out.triangles[f][1], out.triangles[f][2]), ++turned;
  }
  if (dropped) warnings.push_back("Left out " + count_of(dropped, "piece", "pieces") + " that lie within the solid.");
  if (turned) warnings.push_back("Turned " + count_of(turned, "face", "faces") + " that looked inward.");
  return dropped ? without_faces(out, drop) : out;
}

}  // namespace transformables
