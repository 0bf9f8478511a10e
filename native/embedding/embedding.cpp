#include "embedding/embedding.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "embedding/evaluator.h"
#include "embedding/search.h"

namespace transformables {
namespace {

/// Throws unless every index lies in [0, count) and comes once.
template <class Item, class Index>
void check_indices(const std::vector<Item>& items, Index index, int count, const std::string& what) {
  std::vector<char> seen(std::size_t(count), 0);
  for (const Item& item : items) {
    const int i = item.*index;
    if (i < 0 || i >= count) throw InvalidInput(what + " " + std::to_string(i) + " does not exist: the character has " + std::to_string(count));
    if (seen[std::size_t(i)]++) throw InvalidInput(what + " " + std::to_string(i) + " is given twice");
  }
}

bool is_rigid(const Eigen::Isometry3d& frame) {
  return frame.matrix().allFinite() && frame.linear().isUnitary(1e-6) && frame.linear().determinant() > 0;
}

void check_painted(const std::vector<PaintedRegion>& painted, int bones) {
  for (const PaintedRegion& region : painted) {
    if (region.bone < -1 || region.bone >= bones)
      throw InvalidInput("painted region: bone " + std::to_string(region.bone) + " does not exist: the character has " + std::to_string(bones));
    for (const auto& triangle : region.triangles)
      for (const Eigen::Vector3d& p : triangle)
        if (!p.allFinite()) throw InvalidInput("a painted region holds points that are no numbers; repair the target's mesh");
  }
}

void check_steering(const Character& character, const EmbeddingOptions& options) {
  const int bones = int(character.bones.size());
  check_indices(options.locked, &LockedAngle::angle, character.angle_count, "locked angle");
  check_indices(options.pinned, &PinnedBone::bone, bones, "pinned bone");
  check_indices(options.proportion_of, &BoneProportion::bone, bones, "proportion of bone");
  check_painted(options.painted, bones);
  for (const LockedAngle& lock : options.locked)
    if (!std::isfinite(lock.radians)) throw InvalidInput("a locked angle must be a finite number");
  for (const PinnedBone& pin : options.pinned)
    if (!is_rigid(pin.frame)) throw InvalidInput("the frame of a pinned bone must be a rotation and a move");
  for (const BoneProportion& own : options.proportion_of)
    if (!(own.least > 0) || !(own.largest >= own.least) || !(own.largest <= 100))
      throw InvalidInput("bounds of a bone's scale must be: 0 < least <= largest <= 100");
}

void check(const Character& character, const Target& target, const EmbeddingOptions& options) {
  if (character.bones.empty() || character.bones.size() > std::size_t(kMostBones))
    throw InvalidInput("the character has " + std::to_string(character.bones.size()) + " rigid bones: 1 to " +
                       std::to_string(kMostBones) + " can be embedded; simplify it");
  if (target.inside.empty()) throw InvalidInput("the target has no voxels inside: raise the resolution");
  if (options.runs < 1 || options.runs > 1000) throw InvalidInput("runs must lie between 1 and 1000");
  if (options.starts < 1 || options.starts > 1000) throw InvalidInput("starts must lie between 1 and 1000");
  if (options.evaluations < 1) throw InvalidInput("evaluations must be at least 1");
  if (options.threads < 0 || options.threads > 1024) throw InvalidInput("threads must lie between 0 (all cores) and 1024");
  if (!(options.least_scale > 0) || !(options.least_scale <= 1) || !(options.largest_scale >= 1) || !(options.largest_scale <= 100))
    throw InvalidInput("bounds of the bones' scales must be: 0 < least <= 1 <= largest <= 100");
  const ObjectiveWeights& w = options.weights;
  for (const double weight : {w.compact, w.skin, w.skeleton, w.protrude, w.limits, w.morphology, w.unfold})
    if (!(weight >= 0) || !std::isfinite(weight)) throw InvalidInput("weights of the objective must be finite and not negative");
  check_steering(character, options);
  if (options.symmetry != Symmetry::kOn) return;
  if (!options.pinned.empty()) throw InvalidInput("symmetry is on, but bones are pinned: turn symmetry off, or take the pins away");
  if (!character.mirrored) throw InvalidInput("symmetry is on, but the character is not its own mirror image: turn symmetry off");
  if (!target.mirror_axis) throw InvalidInput("symmetry is on, but the target is not its own mirror image: turn symmetry off");
}

void check_start(const Character& character, const Embedding& start) {
  if (start.pose.angles.size() != character.angle_count || start.morphology.size() != Eigen::Index(character.bones.size()))
    throw InvalidInput("the start pose is of another character: its numbers of angles or bones differ");
  if (!start.pose.angles.allFinite() || !start.pose.root.matrix().allFinite() || !start.morphology.allFinite() ||
      !(start.morphology.minCoeff() > 0))
    throw InvalidInput("the start pose must hold finite numbers, and scales above 0");
}

bool is_symmetric(const Character& character, const Target& target, const EmbeddingOptions& options,
                  const std::optional<Embedding>& start) {
  if (options.symmetry == Symmetry::kOff || !character.mirrored || !target.mirror_axis || !options.pinned.empty()) return false;
  return options.symmetry == Symmetry::kOn || !start || start->symmetric;
}

/// Solutions with one more at their end, in the last one's place when there are enough already; unless it is like one before it.
std::vector<Embedding> with_last(const Character& character, const Target& target, std::vector<Embedding> solutions, const Embedding& last,
                                 const ExploreOptions& wanted) {
  if (wanted.count == 1) return solutions;
  if (int(solutions.size()) == wanted.count) solutions.pop_back();
  const auto voxels = std::make_shared<const Voxels>(target);
  const PartitionDifference difference(character, target, *voxels);
  Evaluator evaluator(character, target, voxels, {});
  const auto partition_of = [&](const Embedding& e) {
    Partition partition;
    evaluator(e.pose, e.morphology);
    evaluator.read_partition(partition);
    return partition;
  };
  const Partition own = partition_of(last);
  const bool differs = std::all_of(solutions.begin(), solutions.end(), [&](const Embedding& e) {
    return difference(own, partition_of(e)) >= wanted.least_difference;
  });
  if (differs) solutions.push_back(last);
  return solutions;
}

/// A search from nothing. Symmetry that nobody demanded gives way when no symmetric pose is sound: a plane of symmetry may lie
/// across the target's length. The best symmetric one stays among several all the same: it may well unfold better.
std::vector<Embedding> searched(const Character& character, const Target& target, const EmbeddingOptions& options,
                                const ExploreOptions& wanted, const Progress& progress, const Search::Hear& found,
                                const Search::Hear& best_so_far) {
  const auto search = [&](bool alike, const Progress& tell, const Search::Hear& show) {
    return Search(character, target, options, alike, tell, show).wide(wanted.count, wanted.least_difference, found);
  };
  const bool symmetric = is_symmetric(character, target, options, {});
  if (!symmetric || options.symmetry == Symmetry::kOn) return search(symmetric, progress, best_so_far);
  const Progress first{[&](double done, std::string_view note) { progress(0.5 * done, note); return true; }};
  const Progress second{[&](double done, std::string_view note) { progress(0.5 + 0.5 * done, note); return true; }};
  const std::vector<Embedding> both = search(true, first, best_so_far);
  if (is_sound(both.front(), target.distance.shape.step)) return both;
  const std::vector<Embedding> free = search(false, second, [&](const Embedding& e) {
    if (best_so_far && e.value < both.front().value) best_so_far(e);
  });
  if (both.front().value <= free.front().value) return both;
  return with_last(character, target, free, both.front(), wanted);
}

}  // namespace

Embedding embed(const Character& character, const Target& target, const EmbeddingOptions& options, const Progress& progress,
                const std::optional<Embedding>& start, const std::function<void(const Embedding&)>& best_so_far) {
  check(character, target, options);
  if (start) check_start(character, *start);
  if (start) return Search(character, target, options, is_symmetric(character, target, options, start), progress, best_so_far).careful(*start);
  ExploreOptions one;
  one.count = 1;
  return searched(character, target, options, one, progress, {}, best_so_far).front();
}

std::vector<Embedding> explore(const Character& character, const Target& target, const EmbeddingOptions& options,
                               const ExploreOptions& wanted, const Progress& progress,
                               const std::function<void(const Embedding&)>& found,
                               const std::function<void(const Embedding&)>& best_so_far) {
  check(character, target, options);
  if (wanted.count < 1 || wanted.count > 100) throw InvalidInput("count of solutions must lie between 1 and 100");
  if (!(wanted.least_difference >= 0) || !(wanted.least_difference <= 1))
    throw InvalidInput("least difference of solutions must lie between 0 and 1");
  return searched(character, target, options, wanted, progress, found, best_so_far);
}

}  // namespace transformables
