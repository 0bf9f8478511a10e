#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "segmentation/joint.h"
#include "segmentation/lattice.h"
#include "segmentation/layers.h"
#include "segmentation/rounding.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"
#include "segmentation/surfaces.h"
#include "segmentation/tiling.h"

namespace transformables {
namespace {

using namespace segmentation_inner;

constexpr double kNoCollision = 5e-5;   // of the target's volume
constexpr double kLeft = 0.8e-4;        // the same, what may be left after rounding
constexpr double kWorth = 40;           // volume that may be moved to be rid of one unit of mean overlap
constexpr double kWorthAtLast = 400;    // the same of what rounding leaves: small joints that meet head-on, with whole parts behind them
constexpr int kRough = 2;               // passes before rounding: a joint's transfer may touch one that was settled before
constexpr int kPasses = 6;              // those after rounding mend what it could not

struct Candidate {
  std::vector<std::int16_t> owner;
  bool child_to_parent = true, exact = false;
  double radius = 0;          // 0: exact alternative
  double moved = 0, left = 0; // cubic target units
  double score = 0;
};

class Transfer {
 public:
  Transfer(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
           const TransferOptions& options)
      : result_(segmentation), target_(target), skeleton_(skeleton_of_edited(character, target, embedding, segmentation)), surfaces_(target),
        options_(options), touched_(character.bones.size(), 1), bones_(int(character.bones.size())), voxel_(std::pow(segmentation.shape.step, 3)) {}

  void round_off(const std::vector<Joint>& joints) { known_ = round_joints(result_, target_, skeleton_, surfaces_, joints, options_.threads); }
  void part(const std::vector<Joint>& joints) { known_ = part_layers(result_, target_, skeleton_, surfaces_, joints, options_.threads); }

  void round_outside_and_part(const std::vector<Joint>& joints) {
    known_.clear();
    round_outside(result_, target_, skeleton_, surfaces_, joints, options_.threads);
    part(joints);
  }

  double overlap(const Joint& joint) const { return found(joint).mean; }

  // Mends one joint when that is worth while; tells what was done. Only samples well inside the other part count as worth it.
  void mend(const Joint& joint, TransferResult& report) {
    const Collisions found = collisions(result_, target_, joint, false);
    if (found.mean <= tolerance()) return;
    std::vector<Candidate> best = candidates(joint, found);
    if (best.empty() || best[0].score >= kWorth * (collisions_by_owner(result_.owner, target_, joint) - tolerance())) return;
    tell(best[0], report);
    take(joint, std::move(best[0]));
  }

  // The same for what rounding could not mend: what a transfer is worth shows when its parts are rounded, too.
  void mend_rounded(const Joint& joint, TransferResult& report) {
    const Collisions now = found(joint);
    if (now.mean <= kLeft * target_.volume) return;
    for (Candidate& candidate : candidates(joint, now)) {
      if (candidate.score >= kWorthAtLast * (now.mean - tolerance())) return;
      const Candidate tried = candidate;
      const Segmentation before = result_;
      const std::vector<char> touched = touched_;
      take(joint, std::move(candidate));
      round_off({joint});
      if (tried.moved < kWorthAtLast * (now.mean - overlap(joint))) return tell(tried, report);
      result_ = before, touched_ = touched;
      known_.clear();
    }
  }

  /// Bones whose parts were changed since this was last asked; at first all.
  std::vector<char> touched() { return std::exchange(touched_, std::vector<char>(touched_.size(), 0)); }

  Segmentation result() { return std::move(result_); }

 private:
  Collisions found(const Joint& joint) const {
    const auto known = known_.find(joint.child);
    return known != known_.end() ? known->second : collisions(result_, target_, joint, true);
  }
  double tolerance() const { return kNoCollision * target_.volume; }
  bool wanted(const Joint& joint, bool exact) const {
    if (exact) return joint.single && options_.method != TransferMethod::kCylinder;
    return options_.method != TransferMethod::kExact || !joint.single;
  }
  void tell(const Candidate& taken, TransferResult& report) const {
    if (taken.moved > report.moved_volume) report.radius = taken.radius, report.child_to_parent = taken.child_to_parent;
    report.moved_volume += taken.moved;
  }
  std::vector<Candidate> candidates(const Joint& joint, const Collisions& found) const;
  double bisected_radius(const Joint& joint, const Collisions& found) const;
  Candidate make(const Joint& joint, const Collisions& found, bool child_to_parent, bool exact) const;
  std::vector<std::int16_t> cylinder_transfer(const Joint& joint, bool child_to_parent, double radius) const;
  void take(const Joint& joint, Candidate candidate);
  void cut_cylinder(const Joint& joint, const Candidate& candidate);

  Segmentation result_;
  const Target& target_;
  Skeleton skeleton_;
  Surfaces surfaces_;
  const TransferOptions& options_;
  Found known_;                 // between points, of the segmentation as it is
  std::vector<char> touched_;   // bones whose part was changed since the pass before
  int bones_;
  double voxel_;
};

// R* of Eq. 11 by halving. Turning keeps a sample's distance from the axis, so what collides outside the cylinder is what collided there before.
double Transfer::bisected_radius(const Joint& joint, const Collisions& found) const {
  double low = 0, high = 0, total = 0;
  std::vector<double> radius;
  for (const Eigen::Vector3d& p : found.points) radius.push_back(joint.radius_of(p));
  for (std::size_t k = 0; k < radius.size(); ++k) high = std::max(high, radius[k] + 0.5 * result_.shape.step), total += found.times[k];
  while (high - low > 0.1 * result_.shape.step) {
    const double middle = 0.5 * (low + high);
    double outside = 0;
    for (std::size_t k = 0; k < radius.size(); ++k)
      if (radius[k] >= middle) outside += found.times[k];
    (found.mean * outside / total <= tolerance() ? high : low) = middle;
  }
  return high;
}

std::vector<std::int16_t> Transfer::cylinder_transfer(const Joint& joint, bool child_to_parent, double radius) const {
  const int giver = child_to_parent ? joint.child : joint.parent, taker = child_to_parent ? joint.parent : joint.child;
  std::vector<std::int16_t> owner = result_.owner;
  for (std::size_t i : target_.inside)
    if (owner[i] == giver && joint.radius_of(result_.shape.position(i)) < radius && !is_protected(skeleton_, result_.shape, giver, i))
      owner[i] = std::int16_t(taker);
  return owner;
}

Candidate Transfer::make(const Joint& joint, const Collisions& found, bool child_to_parent, bool exact) const {
  Candidate c;
  c.child_to_parent = child_to_parent, c.exact = exact;
  c.radius = exact ? 0 : bisected_radius(joint, found);
  c.owner = exact ? exact_transfer(result_.owner, target_, skeleton_, joint, child_to_parent)
                  : cylinder_transfer(joint, child_to_parent, c.radius);
  make_tiling(target_, skeleton_.core, bones_, c.owner);
  std::size_t changed = 0;
  for (std::size_t i : target_.inside) changed += c.owner[i] != result_.owner[i];
  c.moved = voxel_ * double(changed);
  c.left = collisions_by_owner(c.owner, target_, joint);
  c.score = c.moved + kWorth * std::max(0.0, c.left - tolerance());
  return c;
}

// All ways that were asked for and change anything, the best first.
std::vector<Candidate> Transfer::candidates(const Joint& joint, const Collisions& found) const {
  std::vector<Candidate> all;
  const auto given = options_.direction_of.find(joint.child);
  const TransferDirection direction = given == options_.direction_of.end() ? options_.direction : given->second;
  for (bool child_to_parent : {true, false}) {
    if (direction == (child_to_parent ? TransferDirection::kParentToChild : TransferDirection::kChildToParent)) continue;
    if (!result_.may_grow(child_to_parent ? joint.parent : joint.child)) continue;
    for (bool exact : {false, true})
      if (wanted(joint, exact)) all.emplace_back().child_to_parent = child_to_parent, all.back().exact = exact;
  }
  tbb::parallel_for(std::size_t(0), all.size(), [&](std::size_t k) { all[k] = make(joint, found, all[k].child_to_parent, all[k].exact); });
  std::erase_if(all, [](const Candidate& c) { return c.moved == 0; });
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
  return all;
}

// Eqs. 8 to 10 on the level sets, the giver's own skeleton kept out of the cylinder.
void Transfer::cut_cylinder(const Joint& joint, const Candidate& candidate) {
  const int giver = candidate.child_to_parent ? joint.child : joint.parent, taker = candidate.child_to_parent ? joint.parent : joint.child;
  Grid<float>& from = result_.phi[giver];
  const Grid<float> before = from;
  const auto transferred = [&](const Eigen::Vector3d& p) {
    const double kept = 0.1 * skeleton_.shapes[giver].radius + distance_to_bone(skeleton_, giver, p);
    return std::max({joint.radius_of(p) - candidate.radius, double(value_at(before, p)), -kept});
  };
  for (std::size_t i = 0; i < from.values.size(); ++i)
    from[i] = std::max(from[i], float(-transferred(from.shape.position(i))));
  Grid<float>& to = result_.phi[taker];
  for (std::size_t i = 0; i < to.values.size(); ++i) to[i] = std::min(to[i], float(transferred(to.shape.position(i))));
}

void Transfer::take(const Joint& joint, Candidate candidate) {
  known_.clear();
  if (candidate.radius > 0) cut_cylinder(joint, candidate);
  const std::vector<std::int16_t> before = result_.owner;
  result_.owner = std::move(candidate.owner);
  surfaces_.retile(result_, skeleton_.core, options_.threads);
  for (std::size_t i : target_.inside)
    if (before[i] != result_.owner[i]) touched_[before[i]] = touched_[result_.owner[i]] = 1;
}

void check(const TransferOptions& options, int bones) {
  if (options.samples < 2 || options.samples > 10000) throw InvalidInput("transfer: the number of samples must be 2 to 10000");
  if (options.threads < 0) throw InvalidInput("transfer: the number of threads must be 0 (all cores) or more");
  for (const auto& [bone, direction] : options.direction_of)
    if (bone < 1 || bone >= bones) throw InvalidInput("transfer: a direction names a bone that does not exist or has no parent");
}

}  // namespace

// Leaves first: what a joint hands to its parent is then there when the parent's own joint is looked at.
Segmentation transfer(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                      const std::vector<JointRange>& ranges, const TransferOptions& options, const Progress& progress,
                      std::vector<TransferResult>* results) {
  check(options, int(character.bones.size()));
  if (!(segmentation.shape == target.distance.shape) || segmentation.phi.size() != character.bones.size())
    throw InvalidInput("transfer: the segmentation belongs to another character, target or resolution; segment again");
  Transfer work(segmentation, character, target, embedding, options);
  const std::vector<Joint> joints = joints_of(character, embedding, ranges, options.samples);
  std::vector<TransferResult> reports(joints.size());
  tbb::task_arena arena(arena_size(options.threads));
  const auto with = [&](const std::vector<char>& bones) {
    std::vector<Joint> some;
    std::copy_if(joints.begin(), joints.end(), std::back_inserter(some), [&](const Joint& j) { return bones[j.child] || bones[j.parent]; });
    return some;
  };
  std::vector<char> touched = work.touched();   // at first all
  const int passes = options.round_off ? kPasses : kRough;
  for (int pass = 0; pass < passes; ++pass) {
    const bool is_rounded = pass >= kRough;
    if (pass == kRough) work.round_off(joints);
    else if (is_rounded) work.part(with(touched));
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (pass != kRough && !touched[joints[k].child] && !touched[joints[k].parent]) continue;
      progress((pass + double(k) / double(joints.size())) / passes, "transferring between parts");
      reports[k].bone = joints[k].child;
      arena.execute([&] { is_rounded ? work.mend_rounded(joints[k], reports[k]) : work.mend(joints[k], reports[k]); });
    }
    touched = work.touched();
  }
  if (options.round_off) work.round_outside_and_part(joints);
  if (results) {
    arena.execute([&] {
      for (std::size_t k = 0; k < joints.size(); ++k) reports[k].left_overlap = work.overlap(joints[k]);
    });
    *results = std::move(reports);
  }
  return work.result();
}

}  // namespace transformables
