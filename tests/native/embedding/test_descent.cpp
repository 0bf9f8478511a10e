// Room embedding: downhill steps of a pose.
#include "cases.h"

#include <Eigen/Eigenvalues>

#include "embedding/descent.h"

namespace transformables {
namespace {

constexpr double kSteep = 1e4;

/// A character in a box, a random pose of it, and what a descent sees of its height.
struct Hill {
  explicit Hill(std::uint64_t seed, std::vector<Descent::Wish> wishes_ = {})
      : wishes(std::move(wishes_)), unknowns(character, target, {}, false), evaluator(evaluator_of(character, target)),
        descent(character, target, unknowns, {}, kSteep, wishes), pose(pose_at(character, {0, 0, 0})), scales(unscaled(character)) {
    Random random(seed);
    y.resize(unknowns.count());
    for (double& number : y) number = random.uniform(-0.9, 0.9);
  }

  double height(const VectorXd& at) {
    unknowns.read(at, {}, pose, scales);
    evaluation = evaluator(pose, scales);
    double sum = evaluation.terms.compact + 0.01 * evaluation.terms.morphology + kSteep * evaluation.violation;
    for (const Descent::Wish& wish : wishes) sum += wish.weight * std::abs(wish.value(evaluator.skeleton()));
    return sum;
  }

  /// Downhill for some steps, damped as much as it takes; the last height.
  double go(int steps) {
    double here = height(y), damping = 0.1;
    for (int k = 0; k < steps; ++k) {
      height(y);
      descent.look(evaluator, y, {});
      const VectorXd next = y + descent.step(damping);
      const double there = height(next);
      damping *= there < here ? 0.3 : 5;
      if (!(there < here)) continue;
      here = there;
      y = next;
    }
    height(y);
    return here;
  }

  const Target target = box_target({0.25, 0.2, 0.15}, 32);
  const Character character = armed();
  std::vector<Descent::Wish> wishes;
  Unknowns unknowns;
  Evaluator evaluator;
  Descent descent;
  Pose pose;
  Morphology scales;
  Evaluation evaluation;
  VectorXd y;
};

TEST(Descent, LeadsDownhillFromAnyPose) {
  int down = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Hill hill(seed);
    const double here = hill.height(hill.y);
    hill.descent.look(hill.evaluator, hill.y, {});
    down += hill.height(hill.y + 0.1 * hill.descent.step(0.1)) < here;
  }
  EXPECT_GE(down, 38) << "but for where a voxel changes its bone";
}

TEST(Descent, BringsMostPosesThatStickOutInsideAndFreeOfCollisionsInTwentySteps) {
  int outside = 0, sound = 0;
  double before = 0, after = 0, out_before = 0, out_after = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Hill hill(seed);
    hill.height(hill.y);
    outside += hill.evaluation.violation > 0.01;
    before += hill.evaluation.terms.compact;
    out_before += hill.evaluation.violation;
    hill.go(20);
    sound += hill.evaluation.violation < 0.005;  // a third of a voxel, of all bones together
    after += hill.evaluation.terms.compact;
    out_after += hill.evaluation.violation;
  }
  EXPECT_GE(outside, 35) << "else there is nothing to show";
  EXPECT_GE(sound, 28);
  EXPECT_LT(out_after, 0.05 * out_before);
  EXPECT_LT(after, 0.7 * before) << "and they are more compact";
}

TEST(Descent, HeedsWishesOfItsCaller) {
  const Vector3d wanted(0.1, 0.05, -0.05);
  std::vector<Descent::Wish> at_place;
  for (int d = 0; d < 3; ++d) at_place.push_back({[&, d](const Skeleton& skeleton) { return skeleton.heads[1][d] - wanted[d]; }, 1e5});
  double before = 0, after = 0;
  int there = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Hill hill(seed, at_place);
    const auto way = [&] { return (hill.evaluator.skeleton().heads[1] - wanted).norm(); };
    hill.height(hill.y);
    before += way();
    hill.go(30);
    after += way();
    there += way() < kLongestSide / 32;
  }
  EXPECT_GE(there, 14) << "within a voxel";
  EXPECT_LT(after, 0.1 * before);
}

TEST(Descent, TakesShorterStepsTheMoreItIsDamped) {
  Hill hill(3);
  hill.height(hill.y);
  hill.descent.look(hill.evaluator, hill.y, {});
  double last = std::numeric_limits<double>::infinity();
  for (const double damping : {1.0, 10.0, 100.0, 1000.0}) {
    const VectorXd step = hill.descent.step(damping);
    EXPECT_TRUE(step.allFinite());
    EXPECT_LT(step.norm(), last);
    EXPECT_LE(step.cwiseAbs().maxCoeff(), 0.4 + 1e-12);
    last = step.norm();
  }
}

TEST(Descent, HasNoNegativeCurvature) {
  Hill hill(4);
  hill.height(hill.y);
  hill.descent.look(hill.evaluator, hill.y, {});
  const Eigen::MatrixXd& curvature = hill.descent.curvature();
  EXPECT_LT((curvature - curvature.transpose()).norm(), 1e-9 * curvature.norm());
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(curvature).eigenvalues().minCoeff(), -1e-9 * curvature.norm());
}

}  // namespace
}  // namespace transformables
