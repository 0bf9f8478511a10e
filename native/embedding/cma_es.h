// Covariance matrix adaptation: a minimiser that needs values only (Hansen, "The CMA Evolution Strategy: A
// Tutorial", arXiv 1604.00772, with its active update), in ask/tell form, so that whoever calls it may
// evaluate in parallel, stop, look, and go on.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "embedding/random.h"

namespace transformables {

/// Maps all of R onto [low, high], smoothly and one to one where |y| <= 1; beyond it runs back and forth. So a search
/// may step anywhere and every value it meets is a true one: a penalty could fake convergence.
struct BoundTransform {
  double low = -1, high = 1;

  double operator()(double y) const;           ///< y = -1, 0, 1: low, middle, high
  double inverse(double value) const;          ///< in [-1, 1]; a value outside the bounds is taken to the nearest
};

class CmaEs {
 public:
  struct Options {
    int population = 0;                        ///< samples a generation; 0: 4 + floor(3 ln n)
    std::uint64_t seed = 0;
    bool active = true;                        ///< let bad samples shrink the covariance (negative weights)
    bool diagonal = false;                     ///< adapt the unknowns' variances alone, about n times faster than how they vary together (Ros and Hansen 2008)
    double tol_fun = 1e-11;                    ///< stop when values of the last generations differ by less
    double tol_x = 1e-11;                      ///< stop when every step is shorter, times the first sigma
    double largest_condition = 1e14;           ///< of the covariance
  };
  enum class Stop { kNone, kTolFun, kTolX, kCondition, kStagnation, kDiverged };

  /// @param mean   start, n >= 1 finite numbers
  /// @param sigma  first step size, positive; the optimum should lie within about three of it
  /// @throws InvalidInput on an empty or non-finite start, a sigma that is not positive, or a population of 1 to 3
  CmaEs(const Eigen::VectorXd& mean, double sigma, const Options& options);

  /// A new generation, one sample a column; asking again before `tell` gives the same one.
  const Eigen::MatrixXd& ask();
  /// The value of each column of the last `ask` (the smaller the better; NaN counts as the worst).
  /// @throws InvalidInput when their number is not the population, or nothing was asked for
  void tell(const Eigen::VectorXd& values);

  Stop stop() const { return stop_; }          ///< why the search should end, kNone while it should go on
  int dimension() const { return int(mean_.size()); }
  int population() const { return population_; }
  static int default_population(int dimension);            ///< 4 + floor(3 ln n)
  long generation() const { return generation_; }
  long evaluations() const { return generation_ * population_; }
  double sigma() const { return sigma_; }
  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::VectorXd& best() const { return best_; }   ///< best sample so far; the start before any
  double best_value() const { return best_value_; }       ///< infinity before any

  /// The whole state as numbers, and back: the search goes on exactly as it would have.
  std::vector<double> save() const;
  /// @throws InvalidInput when the numbers are not what `save` gave
  static CmaEs restored(const std::vector<double>& saved);

 private:
  CmaEs() = default;
  void set_constants();
  void update_covariance(const Eigen::MatrixXd& steps, double h_sigma);
  void decompose();
  void remember(const Eigen::VectorXd& sorted_values);
  Stop check(const Eigen::VectorXd& sorted_values) const;
  template <class Archive>
  void visit(Archive& archive);

  Options options_;
  int population_ = 0;
  // constants that follow from n and the population
  Eigen::VectorXd weights_;
  int parents_ = 0;
  double mu_eff_ = 0, c_sigma_ = 0, d_sigma_ = 0, c_c_ = 0, c_1_ = 0, c_mu_ = 0, expected_norm_ = 0;
  // the distribution
  Eigen::VectorXd mean_, path_sigma_, path_c_, axis_lengths_;
  Eigen::MatrixXd covariance_, axes_;          // C = B D^2 B^T
  double sigma_ = 0, first_sigma_ = 0;
  long generation_ = 0, decomposed_at_ = 0;
  Random random_;
  // the generation that was asked for
  Eigen::MatrixXd samples_, steps_;
  bool asked_ = false;
  // what was found
  Eigen::VectorXd best_;
  double best_value_ = 0;
  std::deque<double> best_history_, median_history_;
  Stop stop_ = Stop::kNone;
};

}  // namespace transformables
