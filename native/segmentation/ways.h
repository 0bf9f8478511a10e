// Pieces of a part, and ways between them. Inner to the room.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <vector>

#include "segmentation/lattice.h"

namespace transformables::segmentation_inner {

/// Face-connected pieces of the samples in `among` for which `in` holds, in the order of their first sample.
template <class In>
std::vector<std::vector<std::size_t>> pieces(const GridShape& shape, const std::vector<std::size_t>& among, const In& in) {
  std::vector<char> seen(shape.count(), 0);
  std::vector<std::vector<std::size_t>> found;
  for (std::size_t start : among) {
    if (seen[start] || !in(start)) continue;
    std::vector<std::size_t> piece{start};
    seen[start] = 1;
    for (std::size_t k = 0; k < piece.size(); ++k)
      for_neighbours(shape, piece[k], [&](std::size_t n) {
        if (!seen[n] && in(n)) seen[n] = 1, piece.push_back(n);
      });
    found.push_back(std::move(piece));
  }
  return found;
}

/// Cheapest face-connected way from `start` to a sample for which `goal` holds, neither end included; empty when there is
/// none, or when they touch. `found` tells which. `cost(i)` of entering a sample is positive; infinite: not that way.
template <class Goal, class Cost>
std::vector<std::size_t> way_between(const GridShape& shape, const std::vector<std::size_t>& start, const Goal& goal, const Cost& cost, bool& found) {
  std::vector<double> spent(shape.count(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(shape.count(), shape.count());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (std::size_t i : start) spent[i] = 0, open.push({0, i});
  found = false;
  std::vector<std::size_t> way;
  while (!open.empty()) {
    const auto [c, i] = open.top();
    open.pop();
    if (c > spent[i]) continue;
    if (c > 0 && goal(i)) {
      found = true;
      for (std::size_t k = from[i]; spent[k] > 0; k = from[k]) way.push_back(k);
      return way;
    }
    for_neighbours(shape, i, [&](std::size_t n) {
      const double next = c + cost(n);
      if (next < spent[n]) spent[n] = next, from[n] = i, open.push({next, n});
    });
  }
  return way;
}

/// For each sample the nearest of some points, and its distance; -1 and infinity where none is.
struct NearestPoints {
  std::vector<int> point;
  std::vector<double> distance;
};

/// Points pass their names from sample to sample as long as `in` holds and they are no farther than `reach`: nothing gets across a gap.
template <class In>
NearestPoints nearest_points(const GridShape& shape, const std::vector<Eigen::Vector3d>& points, double reach, const In& in) {
  NearestPoints found{std::vector<int>(shape.count(), -1), std::vector<double>(shape.count(), std::numeric_limits<double>::infinity())};
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto offer = [&](std::size_t i, int point) {
    if (!in(i)) return;
    const double d = (shape.position(i) - points[std::size_t(point)]).norm();
    if (d <= reach && d < found.distance[i]) found.distance[i] = d, found.point[i] = point, open.push({d, i});
  };
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3i c = shape.nearest(points[k]);
    for (int o = 0; o < 27; ++o) {
      const Eigen::Vector3i n = c + Eigen::Vector3i(o % 3 - 1, o / 3 % 3 - 1, o / 9 - 1);
      if (shape.contains(n)) offer(shape.index(n), int(k));
    }
  }
  while (!open.empty()) {
    const auto [d, i] = open.top();
    open.pop();
    if (d > found.distance[i]) continue;
    for_neighbours(shape, i, [&](std::size_t n) { offer(n, found.point[i]); });
  }
  return found;
}

}  // namespace transformables::segmentation_inner
