// Finite differences of one level set around one sample, in steps. Inner to the room.
#pragma once

#include <algorithm>
#include <cmath>

namespace transformables::segmentation_inner {

/// Reads a sample's neighbours in an array with the given strides.
struct Stencil {
  const float* p;
  int sx, sy, sz;

  float at(int x, int y, int z) const { return p[x * sx + y * sy + z * sz]; }
};

inline float square(float v) { return v * v; }

/// |grad phi| upwind for a front that moves outward (Godunov).
inline float growing_slope(const Stencil& s) {
  const float c = *s.p;
  const auto axis = [&](int stride) {
    return std::max(square(std::max(c - s.p[-stride], 0.f)), square(std::min(s.p[stride] - c, 0.f)));
  };
  return std::sqrt(axis(s.sx) + axis(s.sy) + axis(s.sz));
}

/// The same for |grad phi| = 1: information runs away from the zero set on both sides.
inline float distance_slope(const Stencil& s) {
  const float c = *s.p;
  const auto axis = [&](int stride) {
    const float back = c - s.p[-stride], forth = s.p[stride] - c;
    return c > 0 ? std::max(square(std::max(back, 0.f)), square(std::min(forth, 0.f)))
                 : std::max(square(std::min(back, 0.f)), square(std::max(forth, 0.f)));
  };
  return std::sqrt(axis(s.sx) + axis(s.sy) + axis(s.sz));
}

/// div(grad phi / |grad phi|), clamped to 1 / step, which is all that a grid can show.
inline float curvature(const Stencil& s) {
  const float c = *s.p;
  const float x = 0.5f * (s.at(1, 0, 0) - s.at(-1, 0, 0)), y = 0.5f * (s.at(0, 1, 0) - s.at(0, -1, 0)), z = 0.5f * (s.at(0, 0, 1) - s.at(0, 0, -1));
  const float xx = s.at(1, 0, 0) - 2 * c + s.at(-1, 0, 0), yy = s.at(0, 1, 0) - 2 * c + s.at(0, -1, 0), zz = s.at(0, 0, 1) - 2 * c + s.at(0, 0, -1);
  const float xy = 0.25f * (s.at(1, 1, 0) - s.at(-1, 1, 0) - s.at(1, -1, 0) + s.at(-1, -1, 0));
  const float xz = 0.25f * (s.at(1, 0, 1) - s.at(-1, 0, 1) - s.at(1, 0, -1) + s.at(-1, 0, -1));
  const float yz = 0.25f * (s.at(0, 1, 1) - s.at(0, -1, 1) - s.at(0, 1, -1) + s.at(0, -1, -1));
  const float slope2 = x * x + y * y + z * z;
  if (slope2 < 1e-6f) return 0;
  const float up = x * x * (yy + zz) + y * y * (xx + zz) + z * z * (xx + yy) - 2 * (x * y * xy + x * z * xz + y * z * yz);
  return std::clamp(up / (slope2 * std::sqrt(slope2)), -1.f, 1.f);
}

inline bool beside_zero(const Stencil& s) {
  const bool negative = *s.p <= 0;
  for (int stride : {s.sx, s.sy, s.sz})
    if ((s.p[stride] <= 0) != negative || (s.p[-stride] <= 0) != negative) return true;
  return false;
}

/// Distance of a sample beside the zero set, from its own value and slope (Russo and Smereka 2000): redistancing must not move the zero.
inline float distance_beside_zero(const Stencil& s) {
  const float c = *s.p;
  float slope2 = 0;
  for (int stride : {s.sx, s.sy, s.sz}) {
    const float back = std::abs(c - s.p[-stride]), forth = std::abs(s.p[stride] - c), both = std::abs(s.p[stride] - s.p[-stride]);
    slope2 += square(std::max(0.5f * both, 0.5f * std::max(back, forth)));
  }
  return c / std::max(std::sqrt(slope2), 0.3f);
}

}  // namespace transformables::segmentation_inner
