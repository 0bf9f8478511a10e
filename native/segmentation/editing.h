// The artist's edits at work on one segmentation. Inner to the room.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "segmentation/edits.h"
#include "segmentation/region.h"
#include "segmentation/skeleton.h"
#include "segmentation/surfaces.h"

namespace transformables::segmentation_inner {

inline std::string quoted(const std::string& name) { return "'" + name + "'"; }

/// What an edit does, for messages.
std::string what_of(const Edit& edit);

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

}  // namespace transformables::segmentation_inner
