#include "embedding/unknowns.h"

#include <algorithm>
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

Unknowns::Unknowns(const Character& character, const Target& target, const EmbeddingOptions& options, bool symmetric)
    : character_(character), symmetric_(symmetric), normal_(target.mirror_axis.value_or(0)), root_count_(symmetric ? 3 : 6) {
  find_locks(options);
  find_angles();
  find_scales(options);
  find_anchor(options.pinned);
  find_bones();
}

void Unknowns::find_locks(const EmbeddingOptions& options) {
  for (const Bone& bone : character_.bones)
    for (const Hinge& hinge : bone.hinges) {
      low_.push_back(hinge.min_rad);
      high_.push_back(hinge.max_rad);
      kept_.push_back(std::clamp(0.0, hinge.min_rad, hinge.max_rad));
    }
  locked_.assign(low_.size(), 0);
  for (const LockedAngle& lock : options.locked) {
    kept_[std::size_t(lock.angle)] = lock.radians;
    locked_[std::size_t(lock.angle)] = 1;
    if (!symmetric_) continue;
    const auto other = std::size_t(character_.mirror_angle[std::size_t(lock.angle)]);
    if (other == std::size_t(lock.angle)) continue;
    kept_[other] = character_.mirror_sign[other] * lock.radians;
    locked_[other] = 1;
  }
}

void Unknowns::find_angles() {
  for (int k = 0; k < character_.angle_count; ++k) {
    if (locked_[std::size_t(k)]) continue;
    if (!symmetric_) {
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

void Unknowns::find_scales(const EmbeddingOptions& options) {
  const std::size_t n = character_.bones.size();
  const BoneProportion all{-1, options.proportions ? options.least_scale : 1, options.proportions ? options.largest_scale : 1};
  std::vector<BoneProportion> bounds(n, all);
  for (const BoneProportion& own : options.proportion_of) {
    bounds[std::size_t(own.bone)] = own;
    const int mirror = character_.bones[std::size_t(own.bone)].mirror;
    const auto is_mirror = [&](const BoneProportion& other) { return other.bone == mirror; };
    // The other side follows, unless it has bounds of its own: then the last one counts for both.
    if (symmetric_ && mirror >= 0 && std::none_of(options.proportion_of.begin(), options.proportion_of.end(), is_mirror))
      bounds[std::size_t(mirror)] = own;
  }
  kept_scales_ = Morphology::Ones(Eigen::Index(n));
  for (int i = 0; i < int(n); ++i) {
    const int mirror = symmetric_ ? character_.bones[std::size_t(i)].mirror : -1;
    const BoneProportion& own = bounds[std::size_t(mirror > i ? mirror : i)];
    kept_scales_[i] = own.least;
    if ((mirror >= 0 && mirror < i) || own.least == own.largest) continue;
    scales_.push_back({i, mirror, std::log(own.least), std::log(own.largest)});
  }
  for (int i = 0; symmetric_ && i < int(n); ++i) {
    const int mirror = character_.bones[std::size_t(i)].mirror;
    if (mirror > i) kept_scales_[mirror] = kept_scales_[i];
  }
}

void Unknowns::find_bones() {
  std::vector<int> of_angle(std::size_t(character_.angle_count));
  for (std::size_t b = 0; b < character_.bones.size(); ++b)
    for (std::size_t k = 0; k < character_.bones[b].hinges.size(); ++k) of_angle[std::size_t(character_.bones[b].first_angle) + k] = int(b);
  bones_.assign(std::size_t(root_count_), 0);
  for (const Angle& angle : angles_) bones_.push_back(of_angle[std::size_t(angle.index)]);
  for (const Scale& scale : scales_) bones_.push_back(scale.bone);
}

void Unknowns::find_anchor(const std::vector<PinnedBone>& pinned) {
  if (pinned.empty()) return;
  anchored_ = true;
  anchor_ = pinned.front().frame;
  root_count_ = 0;
  for (int b = pinned.front().bone; b > 0; b = character_.bones[std::size_t(b)].parent) anchor_path_.push_back(b);
  std::reverse(anchor_path_.begin(), anchor_path_.end());
}

/// The pinned bone's frame in the root's.
Eigen::Isometry3d Unknowns::in_root(const Pose& pose, const Morphology& morphology) const {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (const int b : anchor_path_) {
    const Bone& bone = character_.bones[std::size_t(b)];
    frame.translate(morphology[bone.parent] * bone.head_in_parent);
    frame.rotate(bone.rest_in_parent * joint_rotation(bone, pose.angles));
  }
  return frame;
}

void Unknowns::read_root(const Eigen::VectorXd& y, const StartPlace& start, Pose& pose) const {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d head;
  if (symmetric_) {
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
}

void Unknowns::read(const Eigen::VectorXd& y, const StartPlace& start, Pose& pose, Morphology& morphology) const {
  for (std::size_t k = 0; k < kept_.size(); ++k) pose.angles[Eigen::Index(k)] = kept_[k];
  Eigen::Index at = root_count_;
  for (const Angle& angle : angles_) {
    const double value = BoundTransform{angle.low, angle.high}(y[at++]);
    pose.angles[angle.index] = value;
    if (angle.mirror >= 0) pose.angles[angle.mirror] = angle.sign * value;
  }
  morphology = kept_scales_;
  for (const Scale& scale : scales_) {
    const double value = std::exp(BoundTransform{scale.low, scale.high}(y[at++]));
    morphology[scale.bone] = value;
    if (scale.mirror >= 0) morphology[scale.mirror] = value;
  }
  if (anchored_)
    pose.root = anchor_ * in_root(pose, morphology).inverse();
  else
    read_root(y, start, pose);
}

Eigen::VectorXd Unknowns::write(const Pose& pose, const Morphology& morphology, StartPlace& start) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(count());
  start.rotation = pose.root.linear() * character_.root_rest.linear().transpose();
  start.head = pose.root.translation();
  if (symmetric_) {  // the least turn that brings the planes' normals together
    const Eigen::Vector3d x = start.rotation.col(0), n = Eigen::Vector3d::Unit(normal_) * (x[normal_] < 0 ? -1 : 1);
    start.rotation = Eigen::Quaterniond::FromTwoVectors(x, n).toRotationMatrix() * start.rotation;
  }
  Eigen::Index at = root_count_;
  for (const Angle& angle : angles_) {
    double value = pose.angles[angle.index];
    if (angle.mirror >= 0) value = 0.5 * (value + angle.sign * pose.angles[angle.mirror]);
    y[at++] = BoundTransform{angle.low, angle.high}.inverse(value);
  }
  for (const Scale& scale : scales_) {
    double value = std::log(morphology[scale.bone]);
    if (scale.mirror >= 0) value = 0.5 * (value + std::log(morphology[scale.mirror]));
    y[at++] = BoundTransform{scale.low, scale.high}.inverse(value);
  }
  return y;
}

std::vector<Eigen::Matrix3d> Unknowns::start_rotations() const {
  if (anchored_) return {Eigen::Matrix3d::Identity()};
  std::vector<Eigen::Matrix3d> result;
  if (symmetric_) {
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
