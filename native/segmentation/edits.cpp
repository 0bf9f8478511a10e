#include "segmentation/edits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "segmentation/region.h"
#include "segmentation/seam_move.h"
#include "segmentation/skeleton.h"
#include "segmentation/surfaces.h"
#include "segmentation/tiling.h"
#include "segmentation/ways.h"

namespace transformables {
namespace {

using namespace segmentation_inner;

constexpr double kOnTarget = 0.5;      // of a painted area, that must lie on the target
constexpr double kHalved = 0.25;       // of a part: a larger piece that comes off is no crumb
constexpr double kWorthTelling = 0.02; // of the samples right under a painted area
constexpr std::size_t kCrumb = 8;      // samples of a region that are not worth a way of their own
constexpr int kTries = 3;              // bones that may keep a region whole
constexpr double kDeep = 2;            // steps below the surface, where ways do not show
constexpr double kShowing = 3;         // what a step costs there

std::string quoted(const std::string& name) { return "'" + name + "'"; }

std::string what_of(const Edit& edit) {
  switch (edit.kind) {
    case EditKind::kRemove: return "Removing the skin of " + quoted(edit.bone);
    case EditKind::kInhibit: return "Inhibiting the growth of " + quoted(edit.bone);
    case EditKind::kKeepWhole: return "Keeping " + quoted(edit.name) + " whole";
    case EditKind::kAssign: return "Assigning " + quoted(edit.name) + " to " + quoted(edit.bone);
    case EditKind::kMoveSeam: return "Moving the seam between " + quoted(edit.bone) + " and " + quoted(edit.other);
  }
  return {};
}

void check(const std::vector<Edit>& edits) {
  for (const Edit& edit : edits) {
    if (!std::isfinite(edit.reach) || edit.reach < 0)
      throw InvalidInput("edit: the thickness about bone " + quoted(edit.bone) + " must be a number of 0 or more");
    for (const auto& t : edit.painted)
      for (const auto& p : t)
        if (!p.allFinite()) throw InvalidInput("edit: the painted region " + quoted(edit.name) + " holds points that are no numbers; repair the target's mesh");
    if (edit.from.size() != edit.to.size())
      throw InvalidInput("edit: the seam between " + quoted(edit.bone) + " and " + quoted(edit.other) + " has " + std::to_string(edit.from.size()) + " points, but " +
                         std::to_string(edit.to.size()) + " places for them; move it again");
    for (const auto* points : {&edit.from, &edit.to})
      for (const auto& p : *points)
        if (!p.allFinite()) throw InvalidInput("edit: the seam between " + quoted(edit.bone) + " and " + quoted(edit.other) + " holds points that are no numbers; move it again");
  }
}

class Editing {
 public:
  Editing(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding, EditReport& report, int threads)
      : result_(segmentation), character_(character), target_(target), shape_(target.distance.shape), report_(report),
        threads_(threads), surfaces_(target), skeleton_(skeleton_of_edited(character, target, embedding, segmentation)) {
    result_.pinned.resize(result_.owner.size(), 0);
    result_.inhibited.resize(character.bones.size(), 0);
  }

  void remove(const Edit& edit);
  void inhibit(const Edit& edit);
  void paint(const Edit& edit);
  void move(const Edit& edit);
  void settle() { surfaces_.retile(result_, skeleton_.core, threads_); }
  Segmentation result();

 private:
  int bones() const { return int(character_.bones.size()); }
  const std::string& name_of(int bone) const { return character_.bones[bone].name; }
  void leave_out(const Edit& edit, const std::string& why) { report_.push_back(what_of(edit) + " was left out: " + why + "."); }
  int bone_of(const Edit& edit, const std::string& name);
  std::vector<std::size_t> sizes() const;
  std::vector<std::int16_t> guarded() const;
  std::vector<int> candidates(const Region& region, const std::vector<std::int16_t>& guard) const;
  std::string claim(const Region& region, const std::vector<std::int16_t>& guard, int bone);
  bool join(std::vector<std::int16_t>& owner, std::vector<std::size_t>& taken, const std::vector<std::int16_t>& guard, int bone) const;
  int halved(const std::vector<std::int16_t>& owner) const;
  void pin(const std::vector<std::size_t>& samples, int bone);
  void retile();
  void tell_what_shows(const Edit& edit, const Region& region, int bone);

  Segmentation result_;
  const Character& character_;
  const Target& target_;
  const GridShape& shape_;
  EditReport& report_;
  int threads_;
  Surfaces surfaces_;
  Skeleton skeleton_;   // its cores hold what is pinned, too
};

// The bone that an edit names, when it has a skin; else the edit is left out and told.
int Editing::bone_of(const Edit& edit, const std::string& name) {
  const auto at = std::find_if(character_.bones.begin(), character_.bones.end(), [&](const Bone& b) { return b.name == name; });
  if (at == character_.bones.end()) {
    leave_out(edit, "the character has no bone " + quoted(name));
    return -1;
  }
  const int bone = int(at - character_.bones.begin());
  if (sizes()[bone] > 0) return bone;
  leave_out(edit, "bone " + quoted(name) + " has no skin");
  return -1;
}

std::vector<std::size_t> Editing::sizes() const {
  std::vector<std::size_t> count(bones(), 0);
  for (std::size_t i : target_.inside) ++count[result_.owner[i]];
  return count;
}

void Editing::retile() {
  std::vector<char> growing(bones());
  for (int b = 0; b < bones(); ++b) growing[b] = result_.may_grow(b);
  make_tiling(target_, skeleton_.core, bones(), result_.owner, growing);
}

void Editing::remove(const Edit& edit) {
  const int bone = bone_of(edit, edit.bone);
  if (bone < 0) return;
  const std::vector<std::size_t> count = sizes();
  if (std::count_if(count.begin(), count.end(), [](std::size_t n) { return n > 0; }) < 2) return leave_out(edit, "it is the only one left, and the target must be filled");
  for (std::size_t i : target_.inside) {
    if (skeleton_.core[i] == bone) skeleton_.core[i] = -1;
    if (result_.owner[i] == bone) result_.owner[i] = -1, result_.pinned[i] = 0;
  }
  retile();
}

void Editing::inhibit(const Edit& edit) {
  const int bone = bone_of(edit, edit.bone);
  if (bone < 0) return;
  const std::vector<std::size_t> count = sizes();
  bool other = false;
  for (int b = 0; b < bones(); ++b) other |= b != bone && count[b] > 0 && result_.may_grow(b);
  if (!other) return leave_out(edit, "no part would be left to grow, and the target must be filled");
  result_.inhibited[bone] = 1;
  for (std::size_t i : target_.inside)
    if (result_.owner[i] == bone && skeleton_.core[i] != bone && distance_to_bone(skeleton_, bone, shape_.position(i)) > edit.reach)
      result_.owner[i] = -1;
  retile();
}

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

// Pins samples of a bone, and ways through its part that hold them to its core whatever else it loses.
void Editing::pin(const std::vector<std::size_t>& samples, int bone) {
  for (std::size_t i : samples) result_.pinned[i] = 1, skeleton_.core[i] = std::int16_t(bone);
  retile();
  const auto held = [&](std::size_t i) { return skeleton_.core[i] == bone; };
  for (;;) {
    auto all = pieces(shape_, target_.inside, held);
    if (all.size() < 2) return;
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    std::vector<char> mine(shape_.count(), 0);
    for (std::size_t i : all.front()) mine[i] = 1;
    bool found = false;
    const auto cost = [&](std::size_t i) { return result_.owner[i] == bone ? 1.0 : std::numeric_limits<double>::infinity(); };
    const auto way = way_between(shape_, all.front(), [&](std::size_t i) { return held(i) && !mine[i]; }, cost, found);
    for (std::size_t i : found ? way : all.front()) {
      skeleton_.core[i] = found ? std::int16_t(bone) : std::int16_t(-1);   // without a way: a piece that tiling gave to others
      result_.pinned[i] = found;
    }
  }
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

// Level sets must be settled when this is called, and are afterwards.
void Editing::move(const Edit& edit) {
  const int a = bone_of(edit, edit.bone), b = a < 0 ? -1 : bone_of(edit, edit.other);
  if (b < 0) return;
  const SeamMove seam{std::min(a, b), std::max(a, b), edit.from, edit.to};
  const std::string problem = move_seam(result_, target_, surfaces_, skeleton_.core, seam, threads_);
  if (!problem.empty()) return leave_out(edit, problem);
  for (int bone : {a, b}) {
    std::vector<std::size_t> own;
    for (std::size_t i : beside_seam(result_, seam))
      if (result_.owner[i] == bone) own.push_back(i);
    pin(own, bone);
  }
}

Segmentation Editing::result() {
  if (std::find(result_.inhibited.begin(), result_.inhibited.end(), 1) == result_.inhibited.end()) result_.inhibited.clear();
  settle();
  if (std::find(result_.pinned.begin(), result_.pinned.end(), 1) == result_.pinned.end()) result_.pinned.clear();
  return std::move(result_);
}

}  // namespace

Segmentation edited(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                    const std::vector<Edit>& edits, EditReport* report, int threads) {
  check(edits);
  if (!(segmentation.shape == target.distance.shape) || segmentation.phi.size() != character.bones.size())
    throw InvalidInput("edit: the segmentation belongs to another character, target or resolution; segment again");
  if (threads < 0) throw InvalidInput("edit: the number of threads must be 0 (all cores) or more");
  EditReport unread;
  Editing editing(segmentation, character, target, embedding, report ? *report : unread, threads);
  const auto all_of = [&](auto&& kinds, auto&& work) {
    for (const Edit& edit : edits)
      if (std::find(kinds.begin(), kinds.end(), edit.kind) != kinds.end()) work(edit);
  };
  all_of(std::array{EditKind::kRemove}, [&](const Edit& e) { editing.remove(e); });
  all_of(std::array{EditKind::kInhibit}, [&](const Edit& e) { editing.inhibit(e); });
  all_of(std::array{EditKind::kKeepWhole, EditKind::kAssign}, [&](const Edit& e) { editing.paint(e); });
  editing.settle();
  all_of(std::array{EditKind::kMoveSeam}, [&](const Edit& e) { editing.move(e); });
  return editing.result();
}

}  // namespace transformables
