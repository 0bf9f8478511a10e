// A part's fields after carving.
#include <algorithm>
#include <cmath>

#include "finishing/part_field.h"

namespace transformables::finishing {
namespace {

constexpr float kBand = 3;                   ///< steps: values beyond do not move a surface
constexpr float kDepth = 0.75f;              ///< steps under the target's surface from where carving is continued outward
constexpr float kOutside = 3.5f;             ///< steps outside the target as far as interfaces are known

/// How much carving took, just under the target's surface below a sample outside.
float taken_below(const PartField& part, std::size_t n) {
  const GridShape& s = part.shape();
  const float step = float(s.step);
  const Eigen::Vector3i c = s.cell(n);
  Eigen::Vector3f slope;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3i low = c, high = c;
    low[axis] = std::max(low[axis] - 1, 0);
    high[axis] = std::min(high[axis] + 1, s.size[axis] - 1);
    slope[axis] = part.away.at(high).outer - part.away.at(low).outer;
  }
  if (!(slope.norm() > 0)) return 0;
  const Eigen::Vector3f p = c.cast<float>() - (part.away[n].outer / step + kDepth) * slope.normalized();
  const Eigen::Vector3i base = p.array().floor().matrix().cast<int>();
  const Eigen::Vector3f t = p - base.cast<float>();
  float sum = 0, weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i d(corner & 1, corner >> 1 & 1, corner >> 2 & 1), q = base + d;
    if (!s.contains(q) || part.away.at(q).outer >= 0) continue;
    const float w = (d.x() ? t.x() : 1 - t.x()) * (d.y() ? t.y() : 1 - t.y()) * (d.z() ? t.z() : 1 - t.z());
    const std::size_t at = s.index(q);
    const auto clamped = [&](float v) { return std::clamp(v, -kBand * step, kBand * step); };
    sum += w * std::max(0.0f, clamped(part.inner[at]) - clamped(part.uncarved[at]));
    weights += w;
  }
  return weights > 1e-3f ? sum / weights : 0;
}

}  // namespace

void adopt(PartField& part, Grid<float> psi) {
  for (std::size_t n = 0; n < psi.values.size(); ++n)
    if (psi[n] != part.psi[n]) part.inner[n] = psi[n];
  part.psi = std::move(psi);
}

void refresh(PartField& part) {
  const float step = float(part.shape().step);
  for (std::size_t n = 0; n < part.inner.values.size(); ++n)
    if (const float out = part.away[n].outer; out >= 0 && out < kOutside * step) {
      const float taken = taken_below(part, n);
      if (taken > 0) part.inner[n] = std::max(part.inner[n], std::clamp(part.uncarved[n], -kBand * step, kBand * step) + taken);
    }
  const Grid<float> distance = redistanced(part.inner);
  for (std::size_t n = 0; n < part.psi.values.size(); ++n) {
    part.psi[n] = std::max(part.inner[n], part.away[n].outer);
    part.away[n].inner = distance[n];
  }
}

}  // namespace transformables::finishing
