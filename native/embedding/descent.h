// Downhill steps of a pose, by its own geometry: they bring any pose near to one that is compact, inside and free of collisions.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <utility>
#include <vector>

#include "embedding/evaluator.h"
#include "embedding/skeleton.h"
#include "embedding/unknowns.h"

namespace transformables {

/// Gauss and Newton's method with damping (Levenberg, Marquardt), the division of the target standing still during a step: of the objective it sees L_compact
/// (Eq. 2), the proportions' regulariser and what a pose must not do; L_skin and the unfolding, which the division decides, it does not see. One object a
/// thread; it reads what it is made of while it lives.
class Descent {
 public:
  /// A number that should become 0, smooth in the pose, and what a unit of it costs.
  struct Wish {
    std::function<double(const Skeleton&)> value;
    double weight = 1;
  };

  /// @param steepness  what a unit of depth of a collision or protrusion costs
  Descent(const Character& character, const Target& target, const Unknowns& unknowns, const ObjectiveWeights& weights, double steepness,
          std::vector<Wish> wishes);

  /// Looks at a pose.
  /// @param evaluator  what has just evaluated that pose, with its flood
  void look(const Evaluator& evaluator, const Eigen::VectorXd& y, const StartPlace& start);
  /// What to add to `y` of the last look: less, and more downhill, the more it is damped; no unknown changes by more than kLongest.
  Eigen::VectorXd step(double damping) const;
  /// The second derivatives of the last look, nearly (n x n, positive semidefinite).
  const Eigen::MatrixXd& curvature() const { return curvature_; }

 private:
  using Ends = Eigen::Matrix<double, 6, 1>;                    ///< of a segment: a, then b
  void differentiate(const Eigen::VectorXd& y, const StartPlace& start);
  void read_wishes(const Skeleton& skeleton, Eigen::Ref<Eigen::VectorXd> values) const;
  void add_morphology();
  void add_wishes();
  void add_compact(const Evaluator& evaluator);
  void add_protrusion(const Evaluator& evaluator);
  void add_protrusion(std::size_t bone);
  void add(int segment, double share, const Eigen::Vector3d& rise, double residual, double weight);
  void gather();

  const Target& target_;
  const Unknowns& unknowns_;
  ObjectiveWeights weights_;
  double steepness_;
  std::vector<Wish> wishes_;
  Skeleton skeleton_, moved_;
  Pose pose_;
  Morphology morphology_;
  std::vector<std::size_t> colliding_;                         ///< pairs of the skeleton
  Eigen::VectorXd wished_, logs_;                              ///< depths of collisions and wishes; logarithms of the proportions
  Eigen::MatrixXd by_ends_, by_wishes_, by_logs_;              ///< how those, and the ends of segments, change: a column an unknown
  Eigen::MatrixXd weighed_;                                    ///< `by_ends_`, each segment's rows times its square
  std::vector<Eigen::Matrix<double, 6, 6>> squares_;           ///< of each segment: curvature, and ...
  std::vector<Ends> pulls_;                                    ///< ... slope by its ends
  Eigen::MatrixXd curvature_;
  Eigen::VectorXd slope_;
};

}  // namespace transformables
