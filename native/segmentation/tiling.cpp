#include "segmentation/tiling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "common/error.h"
#include "segmentation/lattice.h"

namespace transformables::segmentation_inner {
namespace {

struct Piece {
  std::int16_t bone;
  std::size_t core_samples = 0;
  std::vector<std::size_t> samples;
};

std::vector<Piece> pieces_of(const Target& target, const std::vector<std::int16_t>& core, const std::vector<std::int16_t>& owner) {
  const GridShape& shape = target.distance.shape;
  std::vector<char> seen(owner.size(), 0);
  std::vector<Piece> pieces;
  for (std::size_t start : target.inside) {
    if (seen[start] || owner[start] < 0) continue;
    Piece piece{owner[start], 0, {start}};
    seen[start] = 1;
    for (std::size_t k = 0; k < piece.samples.size(); ++k) {
      piece.core_samples += core[piece.samples[k]] == piece.bone;
      for_neighbours(shape, piece.samples[k], [&](std::size_t n) {
        if (owner[n] == piece.bone && !seen[n]) seen[n] = 1, piece.samples.push_back(n);
      });
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

// For each bone the piece with most of its core, then the largest; the others are returned.
std::vector<Piece> cut_off(std::vector<Piece> pieces, int bones) {
  std::vector<int> kept(bones, -1);
  const auto better = [](const Piece& a, const Piece& b) {
    return a.core_samples != b.core_samples ? a.core_samples > b.core_samples : a.samples.size() > b.samples.size();
  };
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    int& best = kept[pieces[k].bone];
    if (best < 0 || better(pieces[k], pieces[best])) best = int(k);
  }
  std::vector<Piece> rest;
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (kept[pieces[k].bone] != int(k)) rest.push_back(std::move(pieces[k]));
  return rest;
}

bool may_grow(const std::vector<char>& growing, int bone) { return growing.empty() || growing[std::size_t(bone)]; }

// The bone that a fragment touches along most faces, one that may grow if there is any; -1 when it touches none.
std::int16_t most_touched(const GridShape& shape, const Piece& piece, const std::vector<std::int16_t>& owner,
                          const std::vector<char>& growing, std::vector<int>& faces) {
  std::fill(faces.begin(), faces.end(), 0);
  for (std::size_t i : piece.samples)
    for_neighbours(shape, i, [&](std::size_t n) {
      if (owner[n] >= 0) ++faces[owner[n]];
    });
  bool any = false;
  for (std::size_t b = 0; b < faces.size(); ++b) any |= faces[b] > 0 && may_grow(growing, int(b));
  for (std::size_t b = 0; any && b < faces.size(); ++b)
    if (!may_grow(growing, int(b))) faces[b] = 0;
  const auto most = std::max_element(faces.begin(), faces.end());
  return *most > 0 ? std::int16_t(most - faces.begin()) : std::int16_t(-1);
}

void give_away(const GridShape& shape, std::vector<Piece> fragments, int bones, const std::vector<char>& growing,
               std::vector<std::int16_t>& owner) {
  for (const Piece& piece : fragments)
    for (std::size_t i : piece.samples) owner[i] = -1;
  std::vector<int> faces(bones);
  for (bool moved = true; moved;) {
    moved = false;
    for (Piece& piece : fragments) {
      if (piece.samples.empty()) continue;
      const std::int16_t bone = most_touched(shape, piece, owner, growing, faces);
      if (bone < 0) continue;
      for (std::size_t i : piece.samples) owner[i] = bone;
      piece.samples.clear();
      moved = true;
    }
  }
}

// First-order solution of |grad t| = 1 at a sample from its neighbours' known times.
double arrival(const GridShape& shape, const std::vector<double>& time, std::size_t i) {
  const Eigen::Vector3i c = shape.cell(i);
  const std::size_t stride[3] = {1, std::size_t(shape.size.x()), std::size_t(shape.size.x()) * shape.size.y()};
  std::array<double, 3> t;
  for (int axis = 0; axis < 3; ++axis) {
    t[axis] = std::numeric_limits<double>::infinity();
    if (c[axis] > 0) t[axis] = time[i - stride[axis]];
    if (c[axis] + 1 < shape.size[axis]) t[axis] = std::min(t[axis], time[i + stride[axis]]);
  }
  std::sort(t.begin(), t.end());
  double result = t[0] + 1, sum = t[0], squares = t[0] * t[0];
  for (int n = 2; n <= 3 && t[n - 1] < result; ++n) {
    sum += t[n - 1];
    squares += t[n - 1] * t[n - 1];
    const double under = sum * sum - n * (squares - 1);
    if (under < 0) break;
    result = (sum + std::sqrt(under)) / n;
  }
  return result;
}

// Fast marching from the owned samples; each new one takes the bone of its earliest face neighbour, so pieces stay connected.
void fill(const Target& target, const std::vector<char>& inside, const std::vector<char>& growing, std::vector<std::int16_t>& owner) {
  const GridShape& shape = target.distance.shape;
  std::vector<double> time(owner.size(), std::numeric_limits<double>::infinity());
  std::vector<double> offer = time;
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto reach = [&](std::size_t from) {
    for_neighbours(shape, from, [&](std::size_t n) {
      if (!inside[n] || owner[n] >= 0) return;
      const double t = arrival(shape, time, n);
      if (t < offer[n]) offer[n] = t, open.push({t, n});
    });
  };
  for (std::size_t i : target.inside)
    if (owner[i] >= 0 && may_grow(growing, owner[i])) time[i] = 0;
  for (std::size_t i : target.inside)
    if (time[i] == 0) reach(i);
  while (!open.empty()) {
    const auto [t, i] = open.top();
    open.pop();
    if (owner[i] >= 0) continue;
    double earliest = std::numeric_limits<double>::infinity();
    std::int16_t bone = -1;
    for_neighbours(shape, i, [&](std::size_t n) {
      if (owner[n] >= 0 && time[n] < earliest) earliest = time[n], bone = owner[n];
    });
    owner[i] = bone;
    time[i] = t;
    reach(i);
  }
}

}  // namespace

void make_tiling(const Target& target, const std::vector<std::int16_t>& core, int bones, std::vector<std::int16_t>& owner,
                 const std::vector<char>& growing) {
  const std::vector<char> inside = inside_flags(target);
  std::vector<char> present(bones, 0);
  for (std::size_t i = 0; i < owner.size(); ++i) {
    if (!inside[i]) owner[i] = -1;
    if (owner[i] < -1 || owner[i] >= bones) throw InvalidInput("a sample is owned by a bone that does not exist; owners run from 0 to the number of bones");
    if (owner[i] >= 0) present[owner[i]] = 1;
  }
  if (std::find(present.begin(), present.end(), 1) == present.end())
    throw InvalidInput("no bone owns anything of the target; give at least one sample to a bone");
  for (std::size_t i : target.inside)
    if (core[i] >= 0 && present[core[i]]) owner[i] = core[i];
  give_away(target.distance.shape, cut_off(pieces_of(target, core, owner), bones), bones, growing, owner);
  const auto unowned = [&] { return std::any_of(target.inside.begin(), target.inside.end(), [&](std::size_t i) { return owner[i] < 0; }); };
  if (unowned()) fill(target, inside, growing, owner);
  if (!growing.empty() && unowned()) fill(target, inside, {}, owner);
  for (std::size_t i : target.inside)
    if (owner[i] < 0) throw InvalidInput("the inside of the target is not one connected piece; use its largest piece only");
}

}  // namespace transformables::segmentation_inner
