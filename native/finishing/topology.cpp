#include "finishing/topology.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace transformables::finishing {
namespace {

/// Inside samples that follow each other along x.
struct Run {
  std::size_t first, end;   ///< samples
  std::size_t joined;       ///< a run of the same piece, no later than this one
  std::size_t core = 0;     ///< samples of the core
};

/// The first run of a piece, in the samples' order.
std::size_t piece_of(std::vector<Run>& runs, std::size_t n) {
  while (runs[n].joined != n) n = runs[n].joined = runs[runs[n].joined].joined;
  return n;
}

/// Runs of inside samples, each joined to those that touch it along an axis.
std::vector<Run> joined_runs(const Grid<float>& psi, const Grid<float>& core) {
  const std::size_t nx = std::size_t(psi.shape.size.x()), ny = std::size_t(psi.shape.size.y()), rows = ny * std::size_t(psi.shape.size.z());
  std::vector<Run> runs;
  std::vector<std::size_t> first_of(rows + 1, 0);   // the first run of each row
  const auto join = [&](std::size_t row, std::size_t with) {
    const std::size_t apart = (row - with) * nx;
    for (std::size_t n = first_of[row], m = first_of[with]; n < runs.size() && m < first_of[with + 1];) {
      if (runs[m].end + apart <= runs[n].first) ++m;
      else if (runs[n].end <= runs[m].first + apart) ++n;
      else {
        const std::size_t a = piece_of(runs, n), b = piece_of(runs, m);
        runs[std::max(a, b)].joined = std::min(a, b);
        runs[n].end < runs[m].end + apart ? ++n : ++m;
      }
    }
  };
  for (std::size_t row = 0; row < rows; ++row) {
    first_of[row] = runs.size();
    for (std::size_t at = row * nx, end = at + nx; at < end; ++at) {
      if (!(psi[at] < 0)) continue;
      Run run{at, at, runs.size()};
      for (; run.end < end && psi[run.end] < 0; ++run.end) run.core += core[run.end] < 0;
      at = run.end;
      runs.push_back(run);
    }
    first_of[row + 1] = runs.size();
    if (row % ny > 0) join(row, row - 1);
    if (row >= ny) join(row, row - ny);
  }
  return runs;
}

}  // namespace

std::size_t keep_core_piece(Grid<float>& psi, const Grid<float>& core) {
  std::vector<Run> runs = joined_runs(psi, core);
  struct Piece {
    std::size_t core = 0, size = 0;
  };
  std::vector<Piece> pieces(runs.size());
  for (std::size_t n = 0; n < runs.size(); ++n) {
    Piece& piece = pieces[piece_of(runs, n)];
    piece.core += runs[n].core;
    piece.size += runs[n].end - runs[n].first;
  }
  const auto best = std::max_element(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.core != b.core ? a.core < b.core : a.size < b.size;
  });
  std::size_t dropped = 0;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    if (std::ptrdiff_t(piece_of(runs, n)) == best - pieces.begin()) continue;
    for (std::size_t at = runs[n].first; at < runs[n].end; ++at) psi[at] = -psi[at];
    dropped += runs[n].end - runs[n].first;
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
