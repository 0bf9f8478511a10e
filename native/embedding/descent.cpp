#include "embedding/descent.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace transformables {
namespace {

constexpr double kDifference = 1e-4;   // of an unknown
constexpr double kSoft = 2e-3;         // target units: what must become 0 is worth its depth, but below this its square
constexpr double kLongest = 0.4;       // of an unknown, in a step
constexpr double kLeastDamped = 0.1;   // of the mean curvature: so that directions which nothing depends on stay
constexpr double kSpacing = 0.01;      // along a capsule: the paper's step

}  // namespace

Descent::Descent(const Character& character, const Target& target, const Unknowns& unknowns, const ObjectiveWeights& weights, double steepness,
                 std::vector<Wish> wishes)
    : target_(target), unknowns_(unknowns), weights_(weights), steepness_(steepness), wishes_(std::move(wishes)), skeleton_(character), moved_(character),
      pose_{Eigen::Isometry3d::Identity(), Eigen::VectorXd::Zero(character.angle_count)},
      morphology_(Morphology::Ones(Eigen::Index(character.bones.size()))) {
  const auto segments = Eigen::Index(skeleton_.segments.size()), n = Eigen::Index(unknowns.count());
  by_ends_.resize(6 * segments, n);
  weighed_.resize(6 * segments, n);
  by_logs_.resize(morphology_.size(), n);
  squares_.resize(std::size_t(segments));
  pulls_.resize(std::size_t(segments));
}

void Descent::look(const Evaluator& evaluator, const Eigen::VectorXd& y, const StartPlace& start) {
  differentiate(y, start);
  curvature_.setZero(y.size(), y.size());
  slope_.setZero(y.size());
  for (auto& square : squares_) square.setZero();
  for (auto& pull : pulls_) pull.setZero();
  add_morphology();
  add_wishes();
  add_compact(evaluator);
  add_protrusion(evaluator);
  gather();
}

Eigen::VectorXd Descent::step(double damping) const {
  Eigen::MatrixXd damped = curvature_;
  const double mean = curvature_.diagonal().mean() + std::numeric_limits<double>::min();
  damped.diagonal() += damping * (curvature_.diagonal().array() + kLeastDamped * mean).matrix();
  const Eigen::VectorXd step = -damped.ldlt().solve(slope_);
  return step * std::min(1.0, kLongest / std::max(kLongest, step.cwiseAbs().maxCoeff()));
}

/// By differences: whatever an unknown moves, be it a mirrored limb or a character that hangs from a pinned bone, is moved.
void Descent::differentiate(const Eigen::VectorXd& y, const StartPlace& start) {
  unknowns_.read(y, start, pose_, morphology_);
  skeleton_.set(pose_, morphology_);
  logs_ = morphology_.array().log();
  colliding_.clear();
  for (std::size_t k = 0; k < skeleton_.pair_count(); ++k)
    if (skeleton_.depth(k) > 0) colliding_.push_back(k);
  wished_.resize(Eigen::Index(colliding_.size() + wishes_.size()));
  by_wishes_.resize(wished_.size(), y.size());
  read_wishes(skeleton_, wished_);
  Eigen::VectorXd at = y;
  for (Eigen::Index u = 0; u < y.size(); ++u) {
    at[u] = y[u] + kDifference;
    unknowns_.read(at, start, pose_, morphology_);
    at[u] = y[u];
    moved_.set(pose_, morphology_);
    by_logs_.col(u) = (morphology_.array().log().matrix() - logs_) / kDifference;
    read_wishes(moved_, by_wishes_.col(u));
    by_wishes_.col(u) = (by_wishes_.col(u) - wished_) / kDifference;
    for (std::size_t s = 0; s < moved_.segments.size(); ++s) {
      const Skeleton::PosedSegment &now = moved_.segments[s], &was = skeleton_.segments[s];
      by_ends_.block<3, 1>(Eigen::Index(6 * s), u) = (now.a - was.a) / kDifference;
      by_ends_.block<3, 1>(Eigen::Index(6 * s) + 3, u) = (now.a + now.length * now.direction - was.a - was.length * was.direction) / kDifference;
    }
  }
}

void Descent::read_wishes(const Skeleton& skeleton, Eigen::Ref<Eigen::VectorXd> values) const {
  Eigen::Index at = 0;
  for (const std::size_t pair : colliding_) values[at++] = skeleton.depth(pair);
  for (const Wish& wish : wishes_) values[at++] = wish.value(skeleton);
}

void Descent::add_morphology() {
  curvature_.noalias() += weights_.morphology * by_logs_.transpose() * by_logs_;
  slope_.noalias() += weights_.morphology * by_logs_.transpose() * logs_;
}

/// A depth d weighs as d does: its square is weighted by 1 / d (iteratively reweighted least squares).
void Descent::add_wishes() {
  for (Eigen::Index k = 0; k < wished_.size(); ++k) {
    const auto own = std::size_t(k) - colliding_.size();
    const double steepness = std::size_t(k) < colliding_.size() ? steepness_ : wishes_[own].weight;
    const double weight = steepness / (std::abs(wished_[k]) + kSoft);
    curvature_.noalias() += weight * by_wishes_.row(k).transpose() * by_wishes_.row(k);
    slope_.noalias() += weight * wished_[k] * by_wishes_.row(k).transpose();
  }
}

/// What depends on a segment alone: a residual that changes by `rise` times the move of the place at this share of the way from a to b.
void Descent::add(int segment, double share, const Eigen::Vector3d& rise, double residual, double weight) {
  Ends row;
  row << (1 - share) * rise, share * rise;
  squares_[std::size_t(segment)].noalias() += weight * row * row.transpose();
  pulls_[std::size_t(segment)] += weight * residual * row;
}

void Descent::add_compact(const Evaluator& evaluator) {
  const Voxels& vox = evaluator.voxels();
  const Boundary& boundary = evaluator.boundary();
  for (std::size_t k = 0; k < boundary.sample_count(); ++k) {
    const Boundary::Sample& sample = boundary.samples()[k];
    const int bone = boundary.label(sample.cell);
    if (bone >= int(skeleton_.character.bones.size())) continue;  // the flood did not come there
    const Eigen::Vector3d p = vox.position(vox.rows[std::size_t(sample.row)], sample.cell);
    int at = 0;
    const double distance = std::sqrt(skeleton_.distance2(bone, p, at)), out = distance - skeleton_.character.bones[std::size_t(bone)].radius;
    if (!(out > 0)) continue;
    const Skeleton::PosedSegment& segment = skeleton_.segments[std::size_t(at)];
    const double along = std::clamp((p - segment.a).dot(segment.direction), 0.0, segment.length);
    const Eigen::Vector3d rise = (segment.a + along * segment.direction - p) / distance;
    add(at, segment.length > 0 ? along / segment.length : 0, rise, out, weights_.compact * vox.samples_weight);
  }
}

void Descent::add_protrusion(const Evaluator& evaluator) {
  for (std::size_t bone = 0; bone < skeleton_.character.bones.size(); ++bone)
    if (evaluator.protrusions()[bone] > 0) add_protrusion(bone);
}

/// Balls along a bone that are not all inside; together they weigh as the one that is farthest out does.
void Descent::add_protrusion(std::size_t bone) {
  const double radius = skeleton_.character.bones[bone].radius, h = 0.5 * target_.distance.shape.step;
  double sum = 0, most = 0;
  const auto for_each_out = [&](const auto& visit) {
    for (int s = skeleton_.first_segment[bone]; s < skeleton_.first_segment[bone + 1]; ++s) {
      const Skeleton::PosedSegment& segment = skeleton_.segments[std::size_t(s)];
      const int steps = std::max(1, int(std::ceil(segment.length / kSpacing)));
      for (int k = 0; k <= steps; ++k) {
        const Eigen::Vector3d c = segment.a + double(k) / steps * segment.length * segment.direction;
        if (const double out = distance_at(target_, c) + radius; out > 0) visit(s, double(k) / steps, c, out);
      }
    }
  };
  for_each_out([&](int, double, const Eigen::Vector3d&, double out) {
    sum += out;
    most = std::max(most, out);
  });
  for_each_out([&](int segment, double share, const Eigen::Vector3d& c, double out) {
    Eigen::Vector3d rise;
    for (int d = 0; d < 3; ++d) {
      const Eigen::Vector3d aside = h * Eigen::Vector3d::Unit(d);
      rise[d] = (distance_at(target_, c + aside) - distance_at(target_, c - aside)) / (2 * h);
    }
    add(segment, share, rise, out, steepness_ / (most + kSoft) * out / sum);
  });
}

void Descent::gather() {
  for (std::size_t s = 0; s < squares_.size(); ++s) {
    const auto rows = by_ends_.middleRows<6>(Eigen::Index(6 * s));
    weighed_.middleRows<6>(Eigen::Index(6 * s)).noalias() = squares_[s].lazyProduct(rows);
    slope_.noalias() += rows.transpose() * pulls_[s];
  }
  curvature_.noalias() += by_ends_.transpose() * weighed_;
}

}  // namespace transformables
