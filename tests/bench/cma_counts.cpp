// Evaluations that CmaEs needs to reach a value, as JSON, for cma_vs_pycma.py.
// Usage: cma_counts FUNCTION DIMENSION START SIGMA POPULATION TARGET MOST_EVALUATIONS SEEDS
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>

#include "common/error.h"
#include "embedding/cma_es.h"

namespace {

using transformables::CmaEs;

double value_of(const std::string& function, const Eigen::VectorXd& x) {
  const Eigen::Index n = x.size();
  double sum = 0;
  if (function == "sphere") return x.squaredNorm();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (function == "ellipsoid") sum += std::pow(1e6, double(i) / double(n - 1)) * x[i] * x[i];
    if (function == "rosenbrock" && i + 1 < n) sum += 100 * std::pow(x[i + 1] - x[i] * x[i], 2) + std::pow(1 - x[i], 2);
    if (function == "rastrigin") sum += 10 + x[i] * x[i] - 10 * std::cos(2 * M_PI * x[i]);
  }
  return sum;
}

struct Count {
  long evaluations = 0;
  bool reached = false;
};

Count count(const std::string& function, const Eigen::VectorXd& start, double sigma, int population, double target, long most, std::uint64_t seed) {
  CmaEs::Options options;
  options.population = population;
  options.seed = seed;
  CmaEs search(start, sigma, options);
  while (search.best_value() > target && search.stop() == CmaEs::Stop::kNone && search.evaluations() < most) {
    const Eigen::MatrixXd& samples = search.ask();
    Eigen::VectorXd values(samples.cols());
    for (Eigen::Index k = 0; k < samples.cols(); ++k) values[k] = value_of(function, samples.col(k));
    search.tell(values);
  }
  return {search.evaluations(), search.best_value() <= target};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 9) {
    std::cerr << "usage: cma_counts FUNCTION DIMENSION START SIGMA POPULATION TARGET MOST_EVALUATIONS SEEDS\n";
    return 2;
  }
  try {
    const Eigen::VectorXd start = Eigen::VectorXd::Constant(std::atoi(argv[2]), std::atof(argv[3]));
    std::cout << "[";
    for (int seed = 1; seed <= std::atoi(argv[8]); ++seed) {
      const Count c = count(argv[1], start, std::atof(argv[4]), std::atoi(argv[5]), std::atof(argv[6]), std::atol(argv[7]), std::uint64_t(seed));
      std::cout << (seed > 1 ? ", " : "") << "[" << c.evaluations << ", " << (c.reached ? "true" : "false") << "]";
    }
    std::cout << "]\n";
  } catch (const transformables::InvalidInput& error) {
    std::cerr << "cma_counts: " << error.what() << "\n";
    return 1;
  }
}
