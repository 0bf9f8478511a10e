// Painted regions: who gets them, and what is in the way.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "segmentation/editing.h"
#include "segmentation/lattice.h"
#include "segmentation/ways.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kOnTarget = 0.5;      // of a painted area, that must lie on the target
constexpr double kHalved = 0.25;       // of a part: a larger piece that comes off is no crumb
constexpr double kWorthTelling = 0.02; // of the samples right under a painted area
constexpr std::size_t kCrumb = 8;      // samples of a region that are not worth a way of their own
constexpr int kTries = 3;              // bones that may keep a region whole
constexpr double kDeep = 2;            // steps below the surface, where ways do not show
constexpr double kShowing = 3;         // what a step costs there

}  // namespace

// Samples that can't change hands: skeletons within their own parts, and what is pinned.
std::vector<std::int16_t> Editing::guarded() const {
  std::vector<std::int16_t> guard = skeleton_.core;
  for (std::size_t i : target_.inside)
    if (guard[i] < 0 && is_protected(skeleton_, shape_, result_.owner[i], i)) guard[i] = result_.owner[i];
  return guard;
}

// Bones that may keep a region whole: those that hold most of it, first.
std::vector<int> Editing::candidates(const Region& region, const std::vector<std::int16_t>& guard) const {
  std::vector<std::size_t> share(bones(), 0);
  for (std::size_t i : region.samples) ++share[result_.owner[i]];
  for (std::size_t i : region.shown)   // whose skeleton lies right under the paint can't give that away
    if (guard[i] >= 0) share[guard[i]] += region.samples.size();
  std::vector<int> order(bones());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return share[a] > share[b]; });
  std::erase_if(order, [&](int b) { return share[b] == 0 || !result_.may_grow(b); });
  if (int(order.size()) > kTries) order.resize(kTries);
  return order;
}

void Editing::paint(const Edit& edit) {
  int named = -1;
  if (edit.kind == EditKind::kAssign) {
    named = bone_of(edit, edit.bone);
    if (named < 0) return;
  }
  if (edit.painted.empty()) return leave_out(edit, "no face is painted");
  const Region region = region_of(target_, edit.painted);
  if (region.on_target < kOnTarget || region.samples.empty()) return leave_out(edit, "the painted region is not on the target's surface; paint it again");
  const std::vector<std::int16_t> guard = guarded();
  std::string why = "no part may grow there";
  for (int bone : named >= 0 ? std::vector<int>{named} : candidates(region, guard)) {
    const std::string problem = claim(region, guard, bone);
    if (problem.empty()) return tell_what_shows(edit, region, bone);
    why = problem;
  }
  leave_out(edit, why);
}

// Gives a region to a bone; says what is in the way when that can't be.
std::string Editing::claim(const Region& region, const std::vector<std::int16_t>& guard, int bone) {
  std::vector<std::int16_t> owner = result_.owner;
  std::vector<std::size_t> taken;
  for (std::size_t i : region.samples)
    if (guard[i] < 0 || guard[i] == bone) owner[i] = std::int16_t(bone), taken.push_back(i);
  if (!join(owner, taken, guard, bone)) return "the part of " + quoted(name_of(bone)) + " can't reach it past the skeletons of others";
  const int cut = halved(owner);
  if (cut >= 0) return "it would cut the part of " + quoted(name_of(cut)) + " in two";
  result_.owner = std::move(owner);
  pin(taken, bone);
  return {};
}

// Connects pieces that were given to a bone with its part, by ways deep in the target. What is too small for that is given back.
bool Editing::join(std::vector<std::int16_t>& owner, std::vector<std::size_t>& taken, const std::vector<std::int16_t>& guard, int bone) const {
  const auto own = [&](std::size_t i) { return owner[i] == bone; };
  std::vector<char> main(shape_.count(), 0);
  const auto all = pieces(shape_, target_.inside, own);
  std::vector<std::vector<std::size_t>> apart;
  for (const auto& piece : all) {
    const bool has_core = std::any_of(piece.begin(), piece.end(), [&](std::size_t i) { return skeleton_.core[i] == bone; });
    if (has_core)
      for (std::size_t i : piece) main[i] = 1;
    else
      apart.push_back(piece);
  }
  const auto cost = [&](std::size_t i) {
    if (owner[i] < 0 || (guard[i] >= 0 && guard[i] != bone)) return std::numeric_limits<double>::infinity();
    return -target_.distance[i] > kDeep * shape_.step ? 1.0 : kShowing;
  };
  for (const auto& piece : apart) {
    if (std::any_of(piece.begin(), piece.end(), [&](std::size_t i) { return main[i]; })) continue;  // joined on another's way
    if (piece.size() < kCrumb) {
      for (std::size_t i : piece) owner[i] = result_.owner[i];
      std::erase_if(taken, [&](std::size_t i) { return std::find(piece.begin(), piece.end(), i) != piece.end(); });
      continue;
    }
    bool found = false;
    std::vector<std::size_t> way = way_between(shape_, piece, [&](std::size_t i) { return main[i] != 0; }, cost, found);
    if (!found) return false;
    for (std::size_t i : std::vector<std::size_t>(way))   // a rod, not a thread
      for_neighbours(shape_, i, [&](std::size_t n) {
        if (std::isfinite(cost(n))) way.push_back(n);
      });
    for (std::size_t i : way)
      if (owner[i] != bone) owner[i] = std::int16_t(bone), taken.push_back(i);
    for (std::size_t i : piece) main[i] = 1;
    for (std::size_t i : way) main[i] = 1;
  }
  return true;
}

// A bone whose part would lose a large piece that it keeps no hold of; -1: none.
int Editing::halved(const std::vector<std::int16_t>& owner) const {
  std::vector<std::size_t> before = sizes(), after(bones(), 0);
  for (std::size_t i : target_.inside) ++after[owner[i]];
  for (int b = 0; b < bones(); ++b) {
    if (after[b] >= before[b]) continue;
    for (const auto& piece : pieces(shape_, target_.inside, [&](std::size_t i) { return owner[i] == b; })) {
      const bool has_core = std::any_of(piece.begin(), piece.end(), [&](std::size_t i) { return skeleton_.core[i] == b; });
      if (!has_core && double(piece.size()) > kHalved * double(before[b])) return b;
    }
  }
  return -1;
}

void Editing::tell_what_shows(const Edit& edit, const Region& region, int bone) {
  std::size_t missed = 0;
  int whose = -1;
  for (std::size_t i : region.shown)
    if (result_.owner[i] != bone) ++missed, whose = result_.owner[i];
  const double share = double(missed) / double(std::max<std::size_t>(1, region.shown.size()));
  if (share <= kWorthTelling) return;
  char percent[16];
  std::snprintf(percent, sizeof percent, "%.0f %%", 100 * share);
  report_.push_back(what_of(edit) + ": " + percent + " of it stays elsewhere, as the skeleton or another region of " + quoted(name_of(whose)) + " lies there.");
}

}  // namespace transformables::segmentation_inner
