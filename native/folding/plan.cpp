// The order of the moves: the paper's greedy choice, and a search that starts from it.
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <optional>

#include "folding/costs.h"
#include "folding/folding.h"
#include "folding/plan.h"
#include "folding/stopwatch.h"

namespace transformables {
namespace folding {
namespace {

constexpr double kDetourPrice = 3;  // samples that an extra move must save, so that no joint waves about for nothing

struct Plan {
  std::vector<Step> steps;
  double cost = 0;  // with the price of extra moves
};

class Planner {
 public:
  Planner(const Design& design, const FoldingOptions& options, const Progress& progress, const FoldPath* start)
      : design_(design), options_(options), progress_(progress), start_(start), costs_(design, options) {
    for (const Unit& unit : costs_.units()) least_moves_ += unit.must_open;
  }

  Plan greedy();
  Plan searched();
  FoldPath path_of(const Plan& plan) const;
  bool cut_short() const { return cut_short_; }

 private:
  State folded() const { return State(costs_.units().size(), std::uint8_t(Unit::kFolded)); }
  std::vector<Step> openings(const State& state) const;
  Plan beam(const Plan& bound);
  std::optional<Plan> started();
  std::optional<Plan> improved(const Plan& plan);
  bool arrives(const std::vector<Step>& steps) const;
  std::vector<std::vector<Step>> neighbours(const Plan& plan, std::size_t k) const;
  std::vector<double> step_costs(const std::vector<Step>& steps);
  Plan priced(std::vector<Step> steps);
  bool spent() { return costs_.expansions() >= options_.expansions || late(); }
  bool late();
  void tell(double fraction, const char* note) const { progress_(fraction, note); }

  const Design& design_;
  const FoldingOptions& options_;
  const Progress& progress_;
  const FoldPath* start_;
  Costs costs_;
  std::size_t least_moves_ = 0;
  const Stopwatch watch_{options_.threads};
  bool cut_short_ = false;
};

/// Moves are counted, not seconds, so that the result is the same on any machine; only one that is too slow for that is stopped by the clock.
bool Planner::late() {
  cut_short_ = cut_short_ || (options_.seconds > 0 && watch_.seconds() > options_.seconds);
  return cut_short_;
}

std::vector<Step> Planner::openings(const State& state) const {
  std::vector<Step> steps;
  for (std::size_t u = 0; u < state.size(); ++u)
    if (costs_.units()[u].must_open && state[u] != Unit::kOpen) steps.push_back({int(u), Unit::kOpen});
  return steps;
}

Plan Planner::greedy() {
  Plan plan;
  State state = folded();
  for (std::vector<Step> choices = openings(state); !choices.empty(); choices = openings(state)) {
    tell(0.3 * double(plan.steps.size()) / double(least_moves_), "folding order");
    std::vector<Edge> edges;
    for (const Step& step : choices) edges.push_back({state, step});
    const std::vector<double> costs = costs_.of(edges);
    const std::size_t best = std::size_t(std::min_element(costs.begin(), costs.end()) - costs.begin());
    plan.steps.push_back(choices[best]);
    plan.cost += costs[best];
    state[choices[best].unit] = Unit::kOpen;
  }
  return plan;
}

/// The path that was given to start from, when each of its moves takes a unit from one of its levels to another.
std::optional<Plan> Planner::started() {
  if (!start_) return {};
  std::vector<Step> steps;
  for (const Move& move : start_->moves) {
    const std::optional<Step> step = costs_.step_of(move);
    if (!step) return {};
    steps.push_back(*step);
  }
  State state = folded();
  for (const Step& step : steps) state[step.unit] = std::uint8_t(step.level);
  return openings(state).empty() ? std::optional(priced(std::move(steps))) : std::nullopt;
}

/// Keeps the best few ways to every number of open joints; orders that reach the same state are one.
Plan Planner::beam(const Plan& bound) {
  // As wide as two thirds of the budget allow: a way to the end tries about n^2 / 2 moves.
  const double affordable = options_.expansions * (2.0 / 3) / (0.5 * double(least_moves_ * (least_moves_ + 1)));
  const std::size_t width = std::size_t(std::clamp(affordable, 1.0, double(options_.beam_width)));
  std::vector<std::pair<State, Plan>> kept{{folded(), {}}};
  for (std::size_t open = 0; open < least_moves_; ++open) {
    tell(0.3 + 0.3 * double(open) / double(least_moves_), "folding order");
    if (spent()) kept.resize(1);  // the budget is for width, not for reaching the end
    std::vector<Edge> edges;
    std::vector<std::size_t> parent;
    for (std::size_t k = 0; k < kept.size(); ++k)
      for (const Step& step : openings(kept[k].first)) edges.push_back({kept[k].first, step}), parent.push_back(k);
    const std::vector<double> costs = costs_.of(edges);
    std::map<State, Plan> reached;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      Plan plan = kept[parent[e]].second;
      plan.cost += costs[e];
      if (plan.cost >= bound.cost) continue;
      plan.steps.push_back(edges[e].step);
      State state = edges[e].from;
      state[edges[e].step.unit] = std::uint8_t(edges[e].step.level);
      const auto [place, fresh] = reached.try_emplace(std::move(state), plan);
      if (!fresh && plan.cost < place->second.cost) place->second = plan;
    }
    kept.assign(reached.begin(), reached.end());
    std::stable_sort(kept.begin(), kept.end(), [](const auto& x, const auto& y) { return x.second.cost < y.second.cost; });
    if (kept.empty()) return bound;
    if (kept.size() > width) kept.resize(width);
  }
  return kept.front().second;
}

std::vector<double> Planner::step_costs(const std::vector<Step>& steps) {
  State state = folded();
  std::vector<Edge> edges;
  for (const Step& step : steps) {
    edges.push_back({state, step});
    state[step.unit] = std::uint8_t(step.level);
  }
  return costs_.of(edges);
}

Plan Planner::priced(std::vector<Step> steps) {
  Plan plan{std::move(steps), 0};
  for (const double c : step_costs(plan.steps)) plan.cost += c;
  plan.cost += kDetourPrice * (double(plan.steps.size()) - double(least_moves_));
  return plan;
}

/// Drops steps that go nowhere, and joins two steps of one unit that follow each other.
std::vector<Step> tidied(const std::vector<Step>& steps, std::size_t units) {
  std::vector<Step> result;
  std::vector<int> level(units, Unit::kFolded);
  for (const Step& step : steps) {
    if (!result.empty() && result.back().unit == step.unit) result.pop_back();
    level.assign(units, Unit::kFolded);
    for (const Step& done : result) level[done.unit] = done.level;
    if (level[step.unit] != step.level) result.push_back(step);
  }
  return result;
}

/// Whether the steps end in character mode: moving steps about can leave a joint where it only meant to stop on the way.
bool Planner::arrives(const std::vector<Step>& steps) const {
  State state = folded();
  for (const Step& step : steps) state[step.unit] = std::uint8_t(step.level);
  for (std::size_t u = 0; u < state.size(); ++u) {
    if (costs_.units()[u].must_open ? state[u] != Unit::kOpen : state[u] != Unit::kFolded && state[u] != Unit::kOpen) return false;
  }
  return true;
}

/// Plans that differ in what happens about step k: it comes elsewhere; another comes just before or after it; another joint stands aside
/// while it passes; it stops half-way until the end, or until after some other.
std::vector<std::vector<Step>> Planner::neighbours(const Plan& plan, std::size_t k) const {
  std::vector<std::vector<Step>> result;
  const auto& steps = plan.steps;
  const auto keep = [&](const std::vector<Step>& changed) {
    std::vector<Step> tidy = tidied(changed, costs_.units().size());
    if (arrives(tidy)) result.push_back(std::move(tidy));
  };
  const auto relocated = [&](std::size_t from, std::size_t to) {
    std::vector<Step> changed = steps;
    changed.erase(changed.begin() + long(from));
    changed.insert(changed.begin() + long(to), steps[from]);
    keep(changed);
  };
  for (std::size_t p = 0; p < steps.size(); ++p)
    if (p != k) relocated(k, p), relocated(p, k);
  State state = folded();
  for (std::size_t p = 0; p < k; ++p) state[steps[p].unit] = std::uint8_t(steps[p].level);
  for (std::size_t u = 0; u < costs_.units().size(); ++u)
    for (int level = 0; level < int(costs_.units()[u].levels.size()); ++level) {
      if (int(u) == steps[k].unit || level == state[u]) continue;
      std::vector<Step> changed = steps;
      changed.insert(changed.begin() + long(k), {int(u), level});
      const bool moves_later = std::any_of(steps.begin() + long(k), steps.end(), [&](const Step& s) { return s.unit == int(u); });
      if (moves_later) keep(changed);
      changed.insert(changed.begin() + long(k) + 2, {int(u), int(state[u])});
      keep(changed);
    }
  for (int level = 2; level < int(costs_.units()[steps[k].unit].levels.size()); ++level)
    for (std::size_t p = k + 1; p <= steps.size(); ++p) {
      std::vector<Step> changed = steps;
      changed[k].level = level;
      changed.insert(changed.begin() + long(p), steps[k]);
      keep(changed);
    }
  return result;
}

std::optional<Plan> Planner::improved(const Plan& plan) {
  const std::vector<double> costs = step_costs(plan.steps);
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < costs.size(); ++k)
    if (costs[k] > 0) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return costs[x] > costs[y]; });
  for (const std::size_t k : order) {
    Plan best = plan;
    for (auto& steps : neighbours(plan, k)) {
      if (spent()) break;
      tell(0.6 + 0.35 * double(costs_.expansions()) / double(options_.expansions), "folding order");
      Plan other = priced(std::move(steps));
      if (other.cost < best.cost) best = std::move(other);
    }
    if (best.cost < plan.cost) return best;
    if (spent()) break;
  }
  return {};
}

Plan Planner::searched() {
  Plan best = greedy();
  if (best.cost == 0) return best;
  if (!late()) best = beam(best);
  if (const std::optional<Plan> given = started(); given && given->cost < best.cost) best = *given;
  while (best.cost > 0 && !spent()) {
    std::optional<Plan> next = improved(best);
    if (!next) break;
    best = std::move(*next);
  }
  return best;
}

FoldPath Planner::path_of(const Plan& plan) const {
  FoldPath path;
  State state = folded();
  for (const Step& step : plan.steps) {
    path.moves.push_back(costs_.move({state, step}));
    state[step.unit] = std::uint8_t(step.level);
  }
  return path;
}

FoldPath planned(const Design& design, const FoldingOptions& options, const Progress& progress, const FoldPath* start,
                 Plan (Planner::*search)()) {
  check(design, options);
  if (start) check(*start, design.embedding.pose.angles);
  FoldPath path;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    Planner planner(design, options, progress, start);
    path = planner.path_of((planner.*search)());
    path.cut_short = planner.cut_short();
  });
  return path;
}

FoldPath measured_on(const FoldPath& path, const Design& design, const FoldingOptions& options) {
  return measured(path, design.segmentation, design.character, design.target, design.embedding, options);
}

}  // namespace

FoldPath unmeasured_plan(const Design& design, const FoldingOptions& options, const Progress& progress, const FoldPath* start) {
  return planned(design, options, progress, start, &Planner::searched);
}

FoldPath unmeasured_greedy(const Design& design, const FoldingOptions& options, const Progress& progress) {
  return planned(design, options, progress, nullptr, &Planner::greedy);
}

}  // namespace folding

FoldPath plan_greedy(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                     const FoldingOptions& options, const Progress& progress) {
  const folding::Design design{character, segmentation, target, embedding};
  return folding::measured_on(folding::unmeasured_greedy(design, options, progress), design, options);
}

FoldPath plan(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
              const FoldingOptions& options, const Progress& progress, const FoldPath* start) {
  const folding::Design design{character, segmentation, target, embedding};
  return folding::measured_on(folding::unmeasured_plan(design, options, progress, start), design, options);
}

}  // namespace transformables
