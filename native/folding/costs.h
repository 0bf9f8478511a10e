// What each move costs from each state, remembered: the graph that planning searches.
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "folding/motion.h"
#include "folding/overlap.h"

namespace transformables::folding {

/// Hinges that turn together: one, or the two of a mirrored pair. A level is a set of their angles.
struct Unit {
  static constexpr int kFolded = 0, kOpen = 1;
  std::vector<int> angles;
  std::vector<std::vector<double>> levels;  ///< folded, open (0), then places on the way and aside, within the limits
  bool must_open = false;                   ///< it is not at 0 already
};
std::vector<Unit> units_of(const Design& design, const FoldingOptions& options);

/// The level of every unit.
using State = std::vector<std::uint8_t>;
/// A unit that goes to a level.
struct Step {
  int unit = 0, level = 0;
};
struct Edge {
  State from;
  Step step;
};

/// Costs of moves in samples (on fine grids in every second or third along each axis), computed once for each pair of parts and each
/// relative motion: the motion of A against B depends on the joints between them in the tree alone.
class Costs {
 public:
  Costs(const Design& design, const FoldingOptions& options);

  const std::vector<Unit>& units() const { return units_; }
  std::vector<double> of(const std::vector<Edge>& edges);
  Eigen::VectorXd angles(const State& state) const;
  Move move(const Edge& edge) const;
  /// The unit and level that a move leads to, when there are such.
  std::optional<Step> step_of(const Move& move) const;
  /// Edges whose cost was not known before, in all.
  long expansions() const { return expansions_; }

 private:
  struct Task;
  std::string pair_key(const Edge& edge, int a, int b) const;
  std::vector<Task> unknown_pairs(const std::vector<Edge>& edges, const std::vector<int>& wanted);
  double pair_cost(const SampledMove& move, int a, int b) const;
  double sum(const Edge& edge) const;

  const Design& design_;
  const FoldingOptions& options_;
  std::vector<Unit> units_;
  Parts parts_;
  std::vector<std::vector<std::pair<int, int>>> pairs_;       // [unit]: bones that it moves against each other
  std::vector<std::vector<std::vector<int>>> units_between_;  // [bone][bone]: units on the way from one to the other
  std::unordered_map<std::string, double> pair_costs_, edge_costs_;
  long expansions_ = 0;
};

}  // namespace transformables::folding
