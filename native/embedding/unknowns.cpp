#include "embedding/unknowns.h"

#include <cmath>

#include "embedding/cma_es.h"

namespace transformables {
namespace {

// One unit of an unknown: about a fifth of the target's longest side, half a radian, half of a range.
constexpr double kMove = 0.1, kTurn = 0.5;

Eigen::Matrix3d turn(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

}  // namespace

Unknowns::Unknowns(const Character& character, const Target& target, const Options& options)
    : character_(character), options_(options), normal_(target.mirror_axis.value_or(0)), root_count_(options.symmetric ? 3 : 6) {
  find_angles();
  if (options.proportions) find_scales();
}

void Unknowns::find_angles() {
  for (const Bone& bone : character_.bones)
    for (const Hinge& hinge : bone.hinges) {
      low_.push_back(hinge.min_rad);
      high_.push_back(hinge.max_rad);
    }
  for (int k = 0; k < character_.angle_count; ++k) {
    if (!options_.symmetric) {
      add_angle(k, -1, 1);
      continue;
    }
    const Eigen::VectorXd image = mirrored_angles(character_, Eigen::VectorXd::Unit(character_.angle_count, k));
    Eigen::Index other;
    image.cwiseAbs().maxCoeff(&other);
    if (other == k && image[k] > 0) add_angle(k, -1, 1);
    if (other > k) add_angle(k, int(other), image[other]);
    // Else it is the mirror of one before it, or a hinge that leads out of the mirror plane and stays at rest.
  }
}

void Unknowns::add_angle(int index, int mirror, double sign) {
  Angle angle{index, mirror, sign, low_[std::size_t(index)], high_[std::size_t(index)]};
  if (mirror >= 0) {
    const double a = sign * low_[std::size_t(mirror)], b = sign * high_[std::size_t(mirror)];
    angle.low = std::max(angle.low, std::min(a, b));
    angle.high = std::max(angle.low, std::min(angle.high, std::max(a, b)));
  }
  angles_.push_back(angle);
}

void Unknowns::find_scales() {
  for (int i = 0; i < int(character_.bones.size()); ++i) {
    const int mirror = options_.symmetric ? character_.bones[std::size_t(i)].mirror : -1;
    if (mirror >= 0 && mirror < i) continue;
    scales_.push_back({i, mirror});
  }
}

void Unknowns::read(const Eigen::VectorXd& y, const StartPlace& start, Pose& pose, Morphology& morphology) const {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d head;
  if (options_.symmetric) {
    const int u = (normal_ + 1) % 3, v = (normal_ + 2) % 3;
    rotation = turn(kTurn * y[2] * Eigen::Vector3d::Unit(normal_)) * start.rotation;
    head = start.head;
    head[u] += kMove * y[0];
    head[v] += kMove * y[1];
    // The character's plane X = mirror_x falls on the target's; the head of a root in that plane with it.
    head[normal_] = start.rotation(normal_, 0) * (character_.root_rest.translation().x() - character_.mirror_x);
  } else {
    rotation = turn(kTurn * y.segment<3>(3)) * start.rotation;
    head = start.head + kMove * y.head<3>();
  }
  pose.root = Eigen::Isometry3d::Identity();
  pose.root.linear() = rotation * character_.root_rest.linear();
  pose.root.translation() = head;
  for (std::size_t k = 0; k < low_.size(); ++k) pose.angles[Eigen::Index(k)] = std::clamp(0.0, low_[k], high_[k]);
  Eigen::Index at = root_count_;
  for (const Angle& angle : angles_) {
    const double value = BoundTransform{angle.low, angle.high}(y[at++]);
    pose.angles[angle.index] = value;
    if (angle.mirror >= 0) pose.angles[angle.mirror] = angle.sign * value;
  }
  morphology.setOnes();
  const BoundTransform bounds{std::log(options_.least_scale), std::log(options_.largest_scale)};
  for (const Scale& scale : scales_) {
    const double value = std::exp(bounds(y[at++]));
    morphology[scale.bone] = value;
    if (scale.mirror >= 0) morphology[scale.mirror] = value;
  }
}

Eigen::VectorXd Unknowns::write(const Pose& pose, const Morphology& morphology, StartPlace& start) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(count());
  start.rotation = pose.root.linear() * character_.root_rest.linear().transpose();
  start.head = pose.root.translation();
  if (options_.symmetric) {  // the least turn that brings the planes' normals together
    const Eigen::Vector3d x = start.rotation.col(0), n = Eigen::Vector3d::Unit(normal_) * (x[normal_] < 0 ? -1 : 1);
    start.rotation = Eigen::Quaterniond::FromTwoVectors(x, n).toRotationMatrix() * start.rotation;
  }
  Eigen::Index at = root_count_;
  for (const Angle& angle : angles_) {
    double value = pose.angles[angle.index];
    if (angle.mirror >= 0) value = 0.5 * (value + angle.sign * pose.angles[angle.mirror]);
    y[at++] = BoundTransform{angle.low, angle.high}.inverse(value);
  }
  const BoundTransform bounds{std::log(options_.least_scale), std::log(options_.largest_scale)};
  for (const Scale& scale : scales_) {
    double value = std::log(morphology[scale.bone]);
    if (scale.mirror >= 0) value = 0.5 * (value + std::log(morphology[scale.mirror]));
    y[at++] = bounds.inverse(value);
  }
  return y;
}

std::vector<Eigen::Matrix3d> Unknowns::start_rotations() const {
  std::vector<Eigen::Matrix3d> result;
  if (options_.symmetric) {
    for (const int sign : {1, -1}) {
      const Eigen::Vector3d x = sign * Eigen::Vector3d::Unit(normal_);
      for (int k = 0; k < 12; ++k) {
        const Eigen::Vector3d y = turn(k * M_PI / 6 * x) * Eigen::Vector3d::Unit((normal_ + 1) % 3);
        Eigen::Matrix3d& r = result.emplace_back();
        r.col(0) = x;
        r.col(1) = y;
        r.col(2) = x.cross(y);
      }
    }
    return result;
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int signs = 0; i != j && signs < 4; ++signs) {
        Eigen::Matrix3d& r = result.emplace_back();
        r.col(0) = Eigen::Vector3d::Unit(i) * (signs & 1 ? -1 : 1);
        r.col(1) = Eigen::Vector3d::Unit(j) * (signs & 2 ? -1 : 1);
        r.col(2) = r.col(0).cross(r.col(1));
      }
  return result;
}

}  // namespace transformables
