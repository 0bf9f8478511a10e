#include "finishing/topology.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace transformables::finishing {
namespace {

/// Visits all samples that are joined to `seed` by six neighbours and are inside; numbers them.
template <class Visit>
void flood_inside(const Grid<float>& psi, std::size_t seed, std::vector<int>& label, int number,
                  std::vector<std::size_t>& stack, Visit&& visit) {
  const GridShape& s = psi.shape;
  const std::array<std::size_t, 3> stride{1, std::size_t(s.size.x()), std::size_t(s.size.x()) * s.size.y()};
  stack.assign(1, seed);
  label[seed] = number;
  while (!stack.empty()) {
    const std::size_t at = stack.back();
    stack.pop_back();
    visit(at);
    const Eigen::Vector3i c = s.cell(at);
    const auto push = [&](std::size_t n) {
      if (label[n] >= 0 || !(psi[n] < 0)) return;
      label[n] = number;
      stack.push_back(n);
    };
    for (int axis = 0; axis < 3; ++axis) {
      if (c[axis] > 0) push(at - stride[axis]);
      if (c[axis] + 1 < s.size[axis]) push(at + stride[axis]);
    }
  }
}

}  // namespace

std::size_t keep_core_piece(Grid<float>& psi, const Grid<float>& core) {
  struct Piece {
    std::size_t core = 0, size = 0;
  };
  std::vector<Piece> pieces;
  std::vector<int> label(psi.values.size(), -1);
  std::vector<std::size_t> stack;
  for (std::size_t n = 0; n < psi.values.size(); ++n) {
    if (label[n] >= 0 || !(psi[n] < 0)) continue;
    Piece piece;
    flood_inside(psi, n, label, int(pieces.size()), stack, [&](std::size_t at) {
      ++piece.size;
      piece.core += core[at] < 0;
    });
    pieces.push_back(piece);
  }
  if (pieces.size() < 2) return 0;
  const auto best = std::max_element(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.core != b.core ? a.core < b.core : a.size < b.size;
  });
  const int kept = int(best - pieces.begin());
  std::size_t dropped = 0;
  for (std::size_t n = 0; n < psi.values.size(); ++n) {
    if (label[n] < 0 || label[n] == kept) continue;
    psi[n] = -psi[n];
    ++dropped;
  }
  return dropped;
}

std::vector<char> hollows(const Grid<float>& psi) {
  const GridShape& s = psi.shape;
  std::vector<char> reached(s.count(), 0);
  std::vector<std::size_t> stack;
  const auto push = [&](const Eigen::Vector3i& c) {
    const std::size_t n = s.index(c);
    if (reached[n] || psi[n] < 0) return;
    reached[n] = 1;
    stack.push_back(n);
  };
  // All of the border is outside and joined, so one of its samples reaches the rest.
  push(Eigen::Vector3i::Zero());
  while (!stack.empty()) {
    const Eigen::Vector3i c = s.cell(stack.back());
    stack.pop_back();
    const Eigen::Vector3i low = (c.array() - 1).max(0), high = (c.array() + 1).min(s.size.array() - 1);
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i) push({i, j, k});
  }
  bool any = false;
  for (std::size_t n = 0; n < reached.size(); ++n) {
    reached[n] = !reached[n] && !(psi[n] < 0);
    any |= reached[n] != 0;
  }
  return any ? reached : std::vector<char>{};
}

void fill(Grid<float>& psi, const std::vector<char>& flags) {
  const float least = float(1e-3 * psi.shape.step);
  for (std::size_t n = 0; n < flags.size(); ++n)
    if (flags[n]) psi[n] = -std::max(psi[n], least);
}

}  // namespace transformables::finishing
