#include "segmentation/edits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "segmentation/editing.h"
#include "segmentation/seam_move.h"
#include "segmentation/tiling.h"
#include "segmentation/ways.h"

namespace transformables {
namespace segmentation_inner {

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

}  // namespace segmentation_inner

namespace {

using namespace segmentation_inner;

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
