// Finite differences of one level set around a row of samples, in steps. Inner to the room.
#pragma once

#include <Eigen/Core>

namespace transformables::segmentation_inner {

/// Values at samples side by side, which are worked on at once.
template <int N>
using Row = Eigen::Array<float, N, 1>;

/// Reads a row and its neighbours in an array whose rows and slices are so far apart.
template <int N>
struct Stencil {
  const float* p;
  int row, slice;

  Row<N> at(int offset) const { return Eigen::Map<const Row<N>>(p + offset); }
  Row<N> at(int x, int y, int z) const { return at(x + y * row + z * slice); }
};

/// |grad phi| upwind for a front that moves outward (Godunov).
template <int N>
Row<N> growing_slope(const Stencil<N>& s) {
  const Row<N> c = s.at(0);
  Row<N> sum = Row<N>::Zero();
  for (const int stride : {1, s.row, s.slice}) sum += (c - s.at(-stride)).max(c - s.at(stride)).max(0.f).square();
  return sum.sqrt();
}

/// The same for |grad phi| = 1: information runs away from the zero set on both sides. `side`: 1 where phi is positive, else -1.
template <int N>
Row<N> distance_slope(const Stencil<N>& s, const Row<N>& side) {
  const Row<N> c = s.at(0);
  Row<N> sum = Row<N>::Zero();
  for (const int stride : {1, s.row, s.slice}) sum += (side * (c - s.at(-stride))).max(side * (c - s.at(stride))).max(0.f).square();
  return sum.sqrt();
}

/// div(grad phi / |grad phi|), clamped to 1 / step, which is all that a grid can show; 0 where there is no slope.
template <int N>
Row<N> curvature(const Stencil<N>& s) {
  const Row<N> c2 = 2 * s.at(0);
  const Row<N> x = 0.5f * (s.at(1, 0, 0) - s.at(-1, 0, 0)), y = 0.5f * (s.at(0, 1, 0) - s.at(0, -1, 0)), z = 0.5f * (s.at(0, 0, 1) - s.at(0, 0, -1));
  const Row<N> xx = s.at(1, 0, 0) - c2 + s.at(-1, 0, 0), yy = s.at(0, 1, 0) - c2 + s.at(0, -1, 0), zz = s.at(0, 0, 1) - c2 + s.at(0, 0, -1);
  const Row<N> xy = 0.25f * (s.at(1, 1, 0) - s.at(-1, 1, 0) - s.at(1, -1, 0) + s.at(-1, -1, 0));
  const Row<N> xz = 0.25f * (s.at(1, 0, 1) - s.at(-1, 0, 1) - s.at(1, 0, -1) + s.at(-1, 0, -1));
  const Row<N> yz = 0.25f * (s.at(0, 1, 1) - s.at(0, -1, 1) - s.at(0, 1, -1) + s.at(0, -1, -1));
  const Row<N> slope2 = x * x + y * y + z * z;
  const Row<N> up = x * x * (yy + zz) + y * y * (xx + zz) + z * z * (xx + yy) - 2 * (x * y * xy + x * z * xz + y * z * yz);
  Row<N> kappa = (up / (slope2 * slope2.sqrt()).max(1e-9f)).max(-1.f).min(1.f);
  for (int k = 0; k < N; ++k) kappa[k] = slope2[k] < 1e-6f ? 0.f : kappa[k];
  return kappa;
}

/// Not positive at samples beside the zero set, or on it.
template <int N>
Row<N> beside_zero(const Stencil<N>& s) {
  const Row<N> c = s.at(0);
  Row<N> least = c * s.at(1);
  for (const int offset : {-1, s.row, -s.row, s.slice, -s.slice}) least = least.min(c * s.at(offset));
  return least;
}

/// Distance of samples beside the zero set, from their own value and slope (Russo and Smereka 2000): redistancing must not move the zero.
template <int N>
Row<N> distance_beside_zero(const Stencil<N>& s) {
  const Row<N> c = s.at(0);
  Row<N> slope2 = Row<N>::Zero();
  for (const int stride : {1, s.row, s.slice}) {
    const Row<N> below = s.at(-stride), above = s.at(stride);
    slope2 += (0.5f * (above - below).abs().max((c - below).abs()).max((above - c).abs())).square();
  }
  return c / slope2.sqrt().max(0.3f);
}

}  // namespace transformables::segmentation_inner
