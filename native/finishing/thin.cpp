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
  Grid<float> shrunk = redistanced(part.psi);
  for (float& v : shrunk.values) v += radius;
  if (inside_count(shrunk) == 0) return 0;
  shrunk = redistanced(shrunk);
  const std::size_t before = inside_count(part.psi);
  for (std::size_t n = 0; n < part.psi.values.size(); ++n) {
    const float opened = std::max(part.psi[n], shrunk[n] - reach);
    part.psi[n] = std::min(opened, std::max(part.psi[n], part.core[n]));
  }
  keep_core_piece(part.psi, part.core);
  const std::size_t taken = before - inside_count(part.psi);
  if (taken > 0) part.distance = redistanced(part.psi);
  return taken;
}

}  // namespace transformables::finishing
