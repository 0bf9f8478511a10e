#include "finishing/thin.h"

#include <algorithm>

#include "finishing/topology.h"

namespace transformables::finishing {
namespace {

/// Steps that what is thin may stand out: sharp edges stay, as samples show the middle of an edge or a wall only to about one step.
constexpr double kStandOut = 1.5;

}  // namespace

std::size_t take_thin(PartField& part, double wall) {
  const float radius = float(wall / 2), reach = radius + float(kStandOut * part.shape().step);
  // An opening: what is left of the part when it shrinks by the radius, grown again, and by more than it shrank.
  Grid<float> shrunk = part.psi;
  for (std::size_t n = 0; n < shrunk.values.size(); ++n) shrunk[n] = part.bound(n) + radius;  // inside, the nearer of the two bounds is the surface
  if (inside_count(shrunk) == 0) return 0;
  shrunk = redistanced(shrunk);
  Grid<float> psi = part.psi;
  for (std::size_t n = 0; n < psi.values.size(); ++n) {
    const float opened = std::max(psi[n], shrunk[n] - reach);
    psi[n] = std::min(opened, std::max(psi[n], part.core[n]));
  }
  keep_core_piece(psi, part.core);
  const std::size_t taken = inside_count(part.psi) - inside_count(psi);
  if (taken == 0) return 0;
  adopt(part, std::move(psi));
  refresh(part);
  return taken;
}

}  // namespace transformables::finishing
