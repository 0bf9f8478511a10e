#include "embedding/cma_es.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/error.h"

namespace transformables {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHalfPi = 1.57079632679489661923;

double median(std::vector<double> v) {
  const auto middle = v.begin() + std::ptrdiff_t(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// Whether the median of the last 30 % of a history is no better than that of its first 30 %.
bool no_better(const std::deque<double>& history) {
  const auto part = std::ptrdiff_t(0.3 * double(history.size()));
  return median({history.end() - part, history.end()}) >= median({history.begin(), history.begin() + part});
}

std::size_t history_length(int n, int population, long generation) {
  const double least = 120 + 30.0 * n / population;
  return std::size_t(std::clamp(0.2 * double(generation), least, 20000.0));
}

}  // namespace

double BoundTransform::operator()(double y) const {
  return 0.5 * (low + high) + 0.5 * (high - low) * std::sin(kHalfPi * y);
}

double BoundTransform::inverse(double value) const {
  if (!(high > low)) return 0;
  return std::asin(std::clamp((2 * value - low - high) / (high - low), -1.0, 1.0)) / kHalfPi;
}

CmaEs::CmaEs(const Eigen::VectorXd& mean, double sigma, const Options& options) : options_(options), mean_(mean) {
  if (mean.size() == 0 || !mean.allFinite()) throw InvalidInput("optimiser: the start must hold one or more finite numbers");
  if (!(sigma > 0) || !std::isfinite(sigma)) throw InvalidInput("optimiser: sigma must be positive and finite");
  const int n = int(mean.size());
  population_ = options.population > 0 ? options.population : default_population(n);
  if (options.population < 0 || population_ < 4) throw InvalidInput("optimiser: the population must be at least 4");
  set_constants();
  sigma_ = first_sigma_ = sigma;
  path_sigma_ = path_c_ = Eigen::VectorXd::Zero(n);
  axis_lengths_ = Eigen::VectorXd::Ones(n);
  covariance_ = axes_ = Eigen::MatrixXd::Identity(n, n);
  random_ = Random(options.seed);
  samples_ = steps_ = Eigen::MatrixXd::Zero(n, population_);
  best_ = mean;
  best_value_ = kInfinity;
}

int CmaEs::default_population(int dimension) { return 4 + int(3 * std::log(double(dimension))); }

void CmaEs::set_constants() {  // tutorial, Table 1
  const double n = double(mean_.size());
  const int lambda = population_;
  parents_ = lambda / 2;
  Eigen::VectorXd w(lambda);
  for (int i = 0; i < lambda; ++i) w[i] = std::log((lambda + 1) / 2.0) - std::log(i + 1.0);
  const auto positive = w.head(parents_);
  const auto negative = w.tail(lambda - parents_);
  mu_eff_ = positive.sum() * positive.sum() / positive.squaredNorm();
  const double mu_eff_negative = negative.sum() * negative.sum() / negative.squaredNorm();
  c_sigma_ = (mu_eff_ + 2) / (n + mu_eff_ + 5);
  d_sigma_ = 1 + 2 * std::max(0.0, std::sqrt((mu_eff_ - 1) / (n + 1)) - 1) + c_sigma_;
  c_c_ = (4 + mu_eff_ / n) / (n + 4 + 2 * mu_eff_ / n);
  c_1_ = 2 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(1 - c_1_, 2 * (0.25 + mu_eff_ - 2 + 1 / mu_eff_) / ((n + 2) * (n + 2) + mu_eff_));
  if (options_.diagonal) {  // rates as pycma has them: n numbers to learn, not n squared
    const double root = std::sqrt(n);
    c_c_ = (1 + 1 / n + mu_eff_ / n) / (root + 1 / n + 2 * mu_eff_ / n);
    c_1_ = 1 / (n + 2 * root + mu_eff_ / n);
    c_mu_ = std::min(1 - c_1_, (0.25 + mu_eff_ - 2 + 1 / mu_eff_) / (n + 4 * root + mu_eff_ / 2));
  }
  const double scale = std::min({1 + c_1_ / c_mu_, 1 + 2 * mu_eff_negative / (mu_eff_ + 2), (1 - c_1_ - c_mu_) / (n * c_mu_)});
  weights_ = w;
  weights_.head(parents_) = positive / positive.sum();
  weights_.tail(lambda - parents_) = options_.active ? Eigen::VectorXd(negative * (scale / -negative.sum()))
                                                     : Eigen::VectorXd(Eigen::VectorXd::Zero(lambda - parents_));
  expected_norm_ = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
}

const Eigen::MatrixXd& CmaEs::ask() {
  if (asked_) return samples_;
  for (Eigen::Index k = 0; k < steps_.cols(); ++k)
    for (Eigen::Index i = 0; i < steps_.rows(); ++i) samples_(i, k) = axis_lengths_[i] * random_.normal();
  steps_.noalias() = axes_ * samples_;
  samples_ = (sigma_ * steps_).colwise() + mean_;
  asked_ = true;
  return samples_;
}

void CmaEs::tell(const Eigen::VectorXd& values) {
  if (!asked_ || values.size() != population_) throw InvalidInput("optimiser: tell needs one value for each sample asked for");
  asked_ = false;
  std::vector<int> order(static_cast<std::size_t>(population_));
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](int k) { return std::isnan(values[k]) ? kInfinity : values[k]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return value(a) < value(b); });
  Eigen::MatrixXd ranked(steps_.rows(), steps_.cols());
  Eigen::VectorXd sorted(population_);
  for (int k = 0; k < population_; ++k) {
    ranked.col(k) = steps_.col(order[std::size_t(k)]);
    sorted[k] = value(order[std::size_t(k)]);
  }
  if (sorted[0] < best_value_) {
    best_value_ = sorted[0];
    best_ = samples_.col(order[0]);
  }
  ++generation_;
  const Eigen::VectorXd mean_step = ranked.leftCols(parents_) * weights_.head(parents_);
  mean_ += sigma_ * mean_step;
  const Eigen::VectorXd whitened = axes_ * (axes_.transpose() * mean_step).cwiseQuotient(axis_lengths_);
  path_sigma_ = (1 - c_sigma_) * path_sigma_ + std::sqrt(c_sigma_ * (2 - c_sigma_) * mu_eff_) * whitened;
  const double n = double(mean_.size()), norm = path_sigma_.norm();
  const double start_up = std::sqrt(1 - std::pow(1 - c_sigma_, 2.0 * double(generation_)));
  const double h_sigma = norm / start_up < (1.4 + 2 / (n + 1)) * expected_norm_ ? 1 : 0;
  path_c_ = (1 - c_c_) * path_c_ + h_sigma * std::sqrt(c_c_ * (2 - c_c_) * mu_eff_) * mean_step;
  update_covariance(ranked, h_sigma);
  sigma_ *= std::exp(std::min(1.0, c_sigma_ / d_sigma_ * (norm / expected_norm_ - 1)));
  if (options_.diagonal || double(generation_ - decomposed_at_) > 1 / (10 * n * (c_1_ + c_mu_))) decompose();
  remember(sorted);
  stop_ = check(sorted);
}

void CmaEs::update_covariance(const Eigen::MatrixXd& steps, double h_sigma) {
  const double n = double(mean_.size());
  Eigen::VectorXd w = weights_;
  for (Eigen::Index k = parents_; k < w.size(); ++k) {  // so that a negative weight can't make the matrix indefinite
    if (w[k] == 0) continue;
    const double length2 = (axes_.transpose() * steps.col(k)).cwiseQuotient(axis_lengths_).squaredNorm();
    w[k] *= n / std::max(length2, 1e-300);
  }
  const double lost = (1 - h_sigma) * c_c_ * (2 - c_c_);
  covariance_ *= 1 + c_1_ * lost - c_1_ - c_mu_ * weights_.sum();
  covariance_.noalias() += c_1_ * path_c_ * path_c_.transpose();
  covariance_.noalias() += c_mu_ * steps * w.asDiagonal() * steps.transpose();
}

void CmaEs::decompose() {
  decomposed_at_ = generation_;
  if (options_.diagonal) {
    covariance_ = Eigen::MatrixXd(covariance_.diagonal().asDiagonal());
    axis_lengths_ = covariance_.diagonal().cwiseSqrt();  // not a number where it is not positive: `check` reports it
    return;
  }
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance_);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[0] > 0)) {
    axis_lengths_.setConstant(std::numeric_limits<double>::quiet_NaN());  // `check` reports it
    return;
  }
  axes_ = solver.eigenvectors();
  axis_lengths_ = solver.eigenvalues().cwiseSqrt();
}

void CmaEs::remember(const Eigen::VectorXd& sorted_values) {
  best_history_.push_back(sorted_values[0]);
  median_history_.push_back(sorted_values[population_ / 2]);
  const std::size_t length = history_length(dimension(), population_, generation_);
  while (best_history_.size() > length) best_history_.pop_front();
  while (median_history_.size() > length) median_history_.pop_front();
}

CmaEs::Stop CmaEs::check(const Eigen::VectorXd& sorted_values) const {
  if (!axis_lengths_.allFinite() || !std::isfinite(sigma_) || sigma_ * axis_lengths_.maxCoeff() > 1e8 * first_sigma_)
    return Stop::kDiverged;
  const double ratio = axis_lengths_.maxCoeff() / axis_lengths_.minCoeff();
  if (ratio * ratio > options_.largest_condition) return Stop::kCondition;
  const double steps = std::max(path_c_.cwiseAbs().maxCoeff(), std::sqrt(covariance_.diagonal().maxCoeff()));
  if (sigma_ * steps < options_.tol_x * first_sigma_) return Stop::kTolX;
  const auto window = std::size_t(10 + std::ceil(30.0 * dimension() / population_));
  if (best_history_.size() >= window && std::isfinite(sorted_values[population_ - 1])) {
    const auto [low, high] = std::minmax_element(best_history_.end() - std::ptrdiff_t(window), best_history_.end());
    const double least = std::min(*low, sorted_values[0]), most = std::max(*high, sorted_values[population_ - 1]);
    if (most - least < options_.tol_fun) return Stop::kTolFun;
  }
  const bool full = double(best_history_.size()) >= 120 + 30.0 * dimension() / population_ - 1;
  if (full && no_better(best_history_) && no_better(median_history_)) return Stop::kStagnation;
  return Stop::kNone;
}

}  // namespace transformables
