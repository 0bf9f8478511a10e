#include "finishing/joint_room.h"

#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNarrow = 0.25;      ///< radians: what carries must be wider, both ways
constexpr double kNarrowest = 0.0045; ///< target units: and than 1.3 mm of 150 mm
constexpr double kSmall = 0.15;        ///< of a sphere of radius 1: and larger
constexpr double kClear = 0.4;        ///< of the gap: a solid's value from which on it is not there; the housing itself reads a whole gap
constexpr int kBeside = 8;
constexpr double kHalfCell = 0.71 * kPi / SphereMap::kRows;   ///< radians from a cell's middle to its corner

Eigen::Vector3d direction(double polar, double azimuth) {
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}
Eigen::Vector3d middle_of(int row, int column) {
  return direction((polar_edge(row) + polar_edge(row + 1)) / 2, (azimuth_edge(column) + azimuth_edge(column + 1)) / 2);
}

/// The longest run of flagged columns around the sphere: where it begins, and how long it is.
std::pair<int, int> longest_run(const std::vector<char>& flags) {
  const int count = int(flags.size());
  std::pair<int, int> best{0, 0};
  int run = 0;
  for (int n = 0; n < 2 * count && best.second < count; ++n) {
    run = flags[std::size_t(n % count)] ? run + 1 : 0;
    if (run > best.second) best = {n - run + 1, run};
  }
  return best;
}

template <class F>
SphereMap mapped(F&& flag) {
  SphereMap map;
  for (int row = 0; row < SphereMap::kRows; ++row)
    for (int column = 0; column < SphereMap::kColumns; ++column) map.set(row, column, flag(middle_of(row, column)));
  return map;
}

}  // namespace

double polar_edge(int row) { return kPi * row / SphereMap::kRows; }
double azimuth_edge(int column) { return 2 * kPi * column / SphereMap::kColumns; }

std::optional<Block> SphereMap::largest(int first, int last, double radius) const {
  const double narrow = std::max(kNarrow, kNarrowest / radius);
  std::optional<Block> best;
  double largest = kSmall;
  // A piece that reached the axis would have a point there.
  for (int top = std::max(first, 1); top <= last; ++top) {
    std::vector<char> all(kColumns, 1);
    for (int row = top; row <= std::min(last, kRows - 2); ++row) {
      for (int c = 0; c < kColumns; ++c) all[std::size_t(c)] = all[std::size_t(c)] && at(row, c);
      const auto [begin, length] = longest_run(all);
      const double from = polar_edge(top), to = polar_edge(row + 1), wide = azimuth_edge(length);
      const double area = (std::cos(from) - std::cos(to)) * wide;
      if (area <= largest || to - from < narrow || wide * std::sin((from + to) / 2) < narrow) continue;
      largest = area;
      best = Block{0, 0, from, to, azimuth_edge(begin), azimuth_edge(begin) + wide};
    }
  }
  return best;
}

SphereMap solid_between(const Grid<float>& psi, const Eigen::Isometry3d& frame, double from, double to, double depth) {
  const int layers = std::max(1, int(std::ceil((to - from) / psi.shape.step)));
  return mapped([&](const Eigen::Vector3d& d) {
    for (int n = 0; n <= layers; ++n)
      if (!(sample(psi, frame * ((from + (to - from) * n / layers) * d)) < -depth)) return false;
    return true;
  });
}

SphereMap free_between(const Grid<float>& psi, const Eigen::Isometry3d& frame, double from, double to, double gap, std::pair<double, double> turned) {
  const SphereMap still = mapped([&](const Eigen::Vector3d& d) {
    const Eigen::Vector3d first = d.unitOrthogonal(), second = d.cross(first);
    for (const double radius : {from, (from + to) / 2, to})
      for (int n = 0; n <= kBeside; ++n) {
        const double a = 2 * kPi * n / kBeside, wide = n < kBeside ? gap + kHalfCell * radius : 0;
        const Eigen::Vector3d p = radius * d + wide * (std::cos(a) * first + std::sin(a) * second);
        if (sample(psi, frame * p) < kClear * gap) return false;
      }
    return true;
  });
  const double cell = azimuth_edge(1);
  const int low = int(std::floor(turned.first / cell)) - 1, high = int(std::ceil(turned.second / cell)) + 1;
  SphereMap swept;
  for (int row = 0; row < SphereMap::kRows; ++row)
    for (int c = 0; c < SphereMap::kColumns; ++c) {
      bool free = true;
      for (int by = low; by <= high && free; ++by) free = still.at(row, c - by + 4 * SphereMap::kColumns);
      swept.set(row, c, free);
    }
  return swept;
}

}  // namespace transformables::finishing
