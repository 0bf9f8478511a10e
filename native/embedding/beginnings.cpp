// Where the search's runs begin: random poses that went downhill, of which the best were changed limb by limb.
#include <algorithm>
#include <array>
#include <cmath>

#include "embedding/search.h"

namespace transformables {
namespace {

constexpr std::size_t kPosesTried = 16;  // random poses for each that goes downhill
constexpr double kWithin = 0.6;          // of the range of each unknown
// A random pose that sticks out or collides by more than this (the sum of all depths, target units) is not flooded, and so is looked at in a sixth of the
// time. Most are so far out; what its other terms would be hardly changes its rank. Instead of them it has kUnseen.
constexpr double kFarOut = 0.05, kUnseen = 250;
constexpr int kSteps = 20;               // downhill, at most
constexpr double kDamping = 0.1, kLeastDamping = 1e-3, kMostDamping = 1e3, kEased = 0.3, kStiffened = 5;
constexpr double kSettled = 1e-3;        // a step that gains less, of the value, is the last
// The best few are changed again and again: each change goes some steps downhill, and stays where that made the pose better. Few that are
// changed often come farther than many that are changed seldom.
constexpr int kHops = 100, kStepsAfter = 8;
// Times the value of the pose that was changed: what is worse after no step, one, two, ... (the last: any more) is given up. Of changes that would have made a
// pose better one in eleven is lost so, and nearly half of the steps are saved.
constexpr std::array kHopeless{20.0, 6.0, 2.5, 1.5, 1.0};
constexpr double kNewLimb = 0.4, kTakenLimb = 0.3;  // how often; else all unknowns are shaken
constexpr double kWithinLimb = 0.8, kShaken = 0.15;

}  // namespace

/// The most promising of random poses; start rotations take turns.
std::vector<Search::Candidate> Search::screened(std::size_t count) {
  const std::vector<Eigen::Matrix3d> rotations = unknowns_.start_rotations();
  Random random(options_.seed);
  std::vector<Candidate> tried;
  for (std::size_t k = 0; k < count * kPosesTried; ++k) {
    Candidate candidate{Eigen::VectorXd::Zero(unknowns_.count()), {rotations[k / kPosesTried % rotations.size()], start_head_}};
    for (Eigen::Index i = unknowns_.root_count(); i < candidate.y.size(); ++i) candidate.y[i] = random.uniform(-kWithin, kWithin);
    tried.push_back(std::move(candidate));
  }
  for_each_in_pieces(tried, 1, true, [&](std::size_t k) { tried[k].value = glance(workers_.local(), tried[k]); });
  std::vector<Candidate> best;
  for (auto begin = tried.begin(); begin != tried.end(); begin += kPosesTried)
    best.push_back(*std::min_element(begin, begin + kPosesTried, [](const Candidate& a, const Candidate& b) { return a.value < b.value; }));
  return best;
}

double Search::glance(Worker& worker, const Candidate& candidate) const {
  Evaluator& evaluator = worker.coarse.front();
  unknowns_.read(candidate.y, candidate.start, worker.pose, worker.morphology);
  Evaluation evaluation = evaluator.without_flood(worker.pose, worker.morphology);
  if (evaluation.violation > kFarOut)
    evaluation.terms.total = kUnseen;
  else
    evaluator.add_flood(worker.pose, evaluation);
  return value_of(evaluation, evaluator.skeleton());
}

/// Downhill as Descent sees it. Of the poses on the way that one is kept which is best on the whole and better than the candidate's value says; where none
/// is, the last one, and the value stays.
void Search::descend(Candidate& candidate, int steps) {
  Worker& worker = workers_.local();
  Evaluator& evaluator = worker.coarse.front();
  Eigen::VectorXd y = candidate.y;
  bool better = false;
  const double limit = candidate.value;
  const auto height = [&](const Eigen::VectorXd& at, double most) {
    unknowns_.read(at, candidate.start, worker.pose, worker.morphology);
    Evaluation evaluation = evaluator.without_flood(worker.pose, worker.morphology);
    const double beside = value_of(evaluation, evaluator.skeleton());
    if (beside >= most) return beside;
    evaluator.add_flood(worker.pose, evaluation, candidate.value - beside);
    const ObjectiveTerms& terms = evaluation.terms;
    if (const double value = beside + terms.total; value < candidate.value) {
      candidate.value = value;
      candidate.y = at;
      better = true;
    }
    return beside + terms.total - options_.weights.skin * terms.skin - options_.weights.unfold * terms.unfold;
  };
  const auto hopeless = [&](std::size_t step) { return kHopeless[std::min(step, kHopeless.size() - 1)] * limit; };
  double damping = kDamping, here = height(y, hopeless(0));
  if (here < hopeless(0)) worker.descent.look(evaluator, y, candidate.start);
  for (int k = 0; k < steps && here < hopeless(std::size_t(k)) && damping <= kMostDamping; ++k) {
    const Eigen::VectorXd next = y + worker.descent.step(damping);
    const double there = height(next, std::max(here, limit));  // what is no step down and can't be better on the whole need not be flooded
    if (!(there < here)) {
      damping *= kStiffened;
      continue;
    }
    const bool settled = here - there < kSettled * here;
    y = next;
    here = there;
    if (settled) break;
    damping = std::max(kLeastDamping, kEased * damping);
    if (k + 1 < steps) worker.descent.look(evaluator, y, candidate.start);
  }
  if (!better) candidate.y = y;
}

void Search::descend(std::vector<Candidate>& candidates, int steps) {
  for_each_in_pieces(candidates, steps, true, [&](std::size_t k) { descend(candidates[k], steps); });
}

/// A limb anew, or another's, or a little of everything.
void Search::change(Candidate& candidate, const std::vector<Candidate>& all, Random& random) const {
  const std::vector<int>& bones = unknowns_.bones();
  const Eigen::Index root = unknowns_.root_count(), own = candidate.y.size() - root;
  const double kind = random.uniform();
  if (own == 0 || kind >= kNewLimb + kTakenLimb) {
    for (double& number : candidate.y) number += kShaken * random.normal();
    return;
  }
  const int limb = bones[std::size_t(root) + std::size_t(random.uniform() * double(own))];
  const Candidate& other = all[std::size_t(random.uniform() * double(all.size()))];
  for (Eigen::Index u = root; u < candidate.y.size(); ++u)
    if (is_below(bones[std::size_t(u)], limb)) candidate.y[u] = kind < kNewLimb ? random.uniform(-kWithinLimb, kWithinLimb) : other.y[u];
}

bool Search::is_below(int bone, int ancestor) const {
  while (bone > ancestor) bone = character_.bones[std::size_t(bone)].parent;
  return bone == ancestor;
}

void Search::hop(std::vector<Candidate>& candidates) {
  for (int hop = 0; hop < kHops; ++hop) {
    std::vector<Candidate> changed = candidates;
    for (std::size_t k = 0; k < changed.size(); ++k) {
      Random random(options_.seed * 7919 + 104729 * std::uint64_t(hop) + k);
      change(changed[k], candidates, random);
    }
    descend(changed, kStepsAfter);
    for (std::size_t k = 0; k < changed.size(); ++k)
      if (changed[k].value < candidates[k].value) candidates[k] = std::move(changed[k]);
  }
}

long Search::planned_for_beginnings(std::size_t starts, std::size_t kept) {
  return long(starts) * (long(kPosesTried) + kSteps) + long(std::min(starts, kept)) * kHops * kStepsAfter;
}

/// @param kept  of so many starts
std::vector<Search::Candidate> Search::beginnings(std::size_t starts, std::size_t kept) {
  std::vector<Candidate> candidates = screened(starts);
  for (Candidate& candidate : candidates) candidate.value = std::numeric_limits<double>::infinity();  // what was not flooded has but a guess
  descend(candidates, kSteps);
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.value < b.value; });
  candidates.resize(std::min(starts, kept));
  hop(candidates);
  return candidates;
}

}  // namespace transformables
