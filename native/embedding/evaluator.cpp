#include "embedding/evaluator.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "embedding/flood.h"
#include "embedding/seeds.h"

namespace transformables {
namespace {

constexpr int kAround = 6;              // protrusion samples on a ring
constexpr double kSampleSpacing = 0.01; // along a capsule: the paper's step
constexpr double kAboutJoint = 4;       // steps: how far about a joint there are seeds

/// Two units that are at right angles to a unit vector and to each other.
void across(const Eigen::Vector3d& d, Eigen::Vector3d& u, Eigen::Vector3d& v) {
  int smallest;
  d.cwiseAbs().minCoeff(&smallest);
  u = d.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  v = d.cross(u);
}

/// Cosine and sine of where the samples of a ring are: those of every second ring stand between those of the first.
std::array<std::pair<double, double>, 2 * kAround> ring() {
  std::array<std::pair<double, double>, 2 * kAround> places;
  for (std::size_t k = 0; k < places.size(); ++k) places[k] = {std::cos(double(k) * M_PI / kAround), std::sin(double(k) * M_PI / kAround)};
  return places;
}

double positive(double x) { return x > 0 ? x : 0; }

}  // namespace

Evaluator::Evaluator(const Character& character, const Target& target, std::shared_ptr<const Voxels> voxels,
                     const ObjectiveWeights& weights)
    : target_(target), voxels_(std::move(voxels)), weights_(weights), skeleton_(character),
      boundary_(character, *voxels_), interfaces_(*voxels_), unfolding_(character, voxels_) {
  field_.assign(std::size_t(voxels_->cells), kUnreached);
  rows_.reserve(std::size_t(voxels_->size.y() + 2) * std::size_t(voxels_->size.z() + 2));
  protrusions_.assign(character.bones.size(), 0);
  for (const Bone& bone : character.bones) {
    const std::size_t count = std::max<std::size_t>(1, bone.segments.size());
    for (std::size_t s = 0; s < count; ++s) {
      const double length = bone.segments.empty() ? 0 : (bone.segments[s].b - bone.segments[s].a).norm();
      stations_.push_back(1 + std::max(1, int(std::ceil(length / kSampleSpacing))));
      sample_count_ += std::size_t(stations_.back() * kAround + 2);
    }
  }
}

Evaluation Evaluator::without_flood(const Pose& pose, const Morphology& morphology) {
  Evaluation result;
  skeleton_.set(pose, morphology);
  add_limits(pose, result.terms);
  for (const double scale : morphology) result.terms.morphology += std::log(scale) * std::log(scale);
  const CapsuleCollisions collisions = skeleton_.collisions();
  result.terms.skeleton = collisions.sum_of_squares;
  result.deepest_collision = collisions.deepest;
  result.violation = collisions.sum;
  add_protrusion(result);
  return result;
}

Evaluation Evaluator::operator()(const Pose& pose, const Morphology& morphology) {
  Evaluation result = without_flood(pose, morphology);
  add_flood(pose, result);
  return result;
}

void Evaluator::add_flood(const Pose& pose, Evaluation& evaluation, double most) {
  ObjectiveTerms& terms = evaluation.terms;
  const bool planted = plant_seeds();
  if (planted) {
    flood(*voxels_, field_.data(), rows_);
    boundary_.find(*voxels_, field_.data());
    terms.compact = compact();
  } else {
    terms.compact = compact_without_seeds();
    terms.unfold = weights_.unfold > 0;  // nothing is there to be moved
  }
  terms.total = weights_.compact * terms.compact + weights_.skeleton * terms.skeleton + weights_.protrude * terms.protrude +
                weights_.limits * terms.limits + weights_.morphology * terms.morphology;
  if (planted && terms.total < most) {
    terms.skin = skin(pose);
    if (weights_.unfold > 0) terms.unfold = unfolding_(skeleton_, pose, field_);
  }
  terms.total += weights_.skin * terms.skin + weights_.unfold * terms.unfold;
}

void Evaluator::add_limits(const Pose& pose, ObjectiveTerms& terms) const {
  for (const Bone& bone : skeleton_.character.bones)
    for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
      const double angle = pose.angles[bone.first_angle + Eigen::Index(k)];
      const double out = positive(bone.hinges[k].min_rad - angle) + positive(angle - bone.hinges[k].max_rad);
      terms.limits += out * out;
    }
}

void Evaluator::add_protrusion(Evaluation& evaluation) {
  double sum = 0;
  const auto& bones = skeleton_.character.bones;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    double deepest = 0;
    for (int s = skeleton_.first_segment[i]; s < skeleton_.first_segment[i + 1]; ++s)
      deepest = std::max(deepest, protrusion(skeleton_.segments[std::size_t(s)], stations_[std::size_t(s)], bones[i].radius, sum));
    protrusions_[i] = deepest;
    evaluation.violation += deepest;
    evaluation.deepest_protrusion = std::max(evaluation.deepest_protrusion, deepest);
  }
  evaluation.terms.protrude = sum / double(sample_count_);
}

double Evaluator::protrusion(const Skeleton::PosedSegment& segment, int stations, double radius, double& sum) const {
  const Eigen::Vector3d d = segment.length > 0 ? segment.direction : Eigen::Vector3d::UnitX();
  Eigen::Vector3d u, v;
  across(d, u, v);
  const double spacing = segment.length / (stations - 1);
  double deepest = 0;
  static const auto kRing = ring();
  const auto add = [&](const Eigen::Vector3d& p) {
    const double out = positive(distance_at(target_, p));
    sum += out * out;
    deepest = std::max(deepest, out);
  };
  for (int k = 0; k < stations; ++k) {
    const Eigen::Vector3d c = segment.a + spacing * k * d;
    const double room = -radius - distance_at(target_, c);
    if (room >= 0) {  // a distance changes no faster than one goes: all of it is inside, and so are stations no farther than that
      if (spacing > 0) k += int(std::min(room / spacing, double(stations)));
      continue;
    }
    for (int r = 0; r < kAround; ++r) {
      const auto& [cosine, sine] = kRing[std::size_t(2 * r + k % 2)];
      add(c + radius * (cosine * u + sine * v));
    }
    if (k == 0) add(c - radius * d);
    if (k == stations - 1) add(c + radius * d);
  }
  return deepest;
}

bool Evaluator::plant_seeds() {
  for (const Voxels::Row& row : voxels_->rows) std::fill_n(field_.begin() + row.begin, row.count, kUnreached);
  bool any = false;
  const auto& bones = skeleton_.character.bones;
  const auto for_each_segment = [&](int bone, const auto& plant) {
    const double radius = bones[std::size_t(bone)].radius;
    for (int s = skeleton_.first_segment[std::size_t(bone)]; s < skeleton_.first_segment[std::size_t(bone) + 1]; ++s)
      any |= plant(Seeded{skeleton_.segments[std::size_t(s)], bone, radius, skeleton_.largest_radius - radius});
  };
  for (int i = 0; i < int(bones.size()); ++i) {
    for_each_segment(i, [&](const Seeded& seeded) { return plant_capsule(*voxels_, seeded, field_.data()); });
    const Eigen::Vector3d& joint = skeleton_.heads[std::size_t(i)];
    const double reach = std::min(kAboutJoint * voxels_->step, -distance_at(target_, joint));
    if (bones[std::size_t(i)].parent < 0 || !(reach > 0)) continue;
    for (const int bone : {i, bones[std::size_t(i)].parent})
      for_each_segment(bone, [&](const Seeded& seeded) { return plant_about_joint(*voxels_, seeded, joint, reach, field_.data()); });
  }
  return any;
}

int Evaluator::nearest_bone(const Eigen::Vector3d& p) const {
  int best = 0, at = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int b = 0; b < int(skeleton_.character.bones.size()); ++b) {
    const double square = skeleton_.distance2(b, p, at);
    if (square < least) {
      least = square;
      best = b;
    }
  }
  return best;
}

/// Eq. 2 over the voxels on the boundary of parts: those next to the outside or to another bone's.
double Evaluator::compact() const {
  const Voxels& vox = *voxels_;
  double sum = 0;
  for (std::size_t k = 0; k < boundary_.sample_count(); ++k) {
    const Boundary::Sample& at = boundary_.samples()[k];
    sum += compact_sample(vox.position(vox.rows[std::size_t(at.row)], at.cell), boundary_.label(at.cell));
  }
  return vox.samples_weight * sum;
}

/// Eq. 3 over those of them that lie next to their parent's.
double Evaluator::skin(const Pose& pose) {
  const Voxels& vox = *voxels_;
  interfaces_.clear();
  for (std::size_t k = 0; k < boundary_.interface_count(); ++k) {
    const Boundary::Interface& at = boundary_.interfaces()[k];
    const Voxels::Row& row = vox.rows[std::size_t(at.row)];
    interfaces_.add(boundary_.label(at.cell), vox.place(row, at.cell), at.faces, at.sampled);
  }
  double sum = 0;
  interfaces_.for_each_sample([&](int child, const Eigen::Vector3d& place, const Eigen::Vector3d& normal) {
    sum += joint_sample(pose, vox.position(place.x(), place.y(), place.z()), normal, child);
  });
  return vox.samples_weight * sum;
}

/// A term of Eq. 2.
double Evaluator::compact_sample(const Eigen::Vector3d& p, int bone) const {
  int at = 0;
  const double out = positive(std::sqrt(skeleton_.distance2(bone, p, at)) - skeleton_.character.bones[std::size_t(bone)].radius);
  return out * out;
}

/// A term of Eq. 3.
double Evaluator::joint_sample(const Pose& pose, const Eigen::Vector3d& p, const Eigen::Vector3d& normal, int child) const {
  const Bone& bone = skeleton_.character.bones[std::size_t(child)];
  const Eigen::Vector3d arm = p - skeleton_.heads[std::size_t(child)];
  double sum = 0;
  for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
    const auto angle = std::size_t(bone.first_angle) + k;
    const double along = skeleton_.hinge_axes[angle].cross(arm).dot(normal), alpha = pose.angles[Eigen::Index(angle)];
    sum += positive((bone.hinges[k].min_rad - alpha) * along) + positive((bone.hinges[k].max_rad - alpha) * along);
  }
  return sum;
}

// A skeleton that misses the target altogether: its outer voxels belong to the nearest bone as the crow flies.
double Evaluator::compact_without_seeds() {
  const Voxels& vox = *voxels_;
  double sum = 0;
  boundary_.find(vox, vox.wall.data());
  for (std::size_t k = 0; k < boundary_.sample_count(); ++k) {
    const Boundary::Sample& at = boundary_.samples()[k];
    const Eigen::Vector3d p = vox.position(vox.rows[std::size_t(at.row)], at.cell);
    sum += compact_sample(p, nearest_bone(p));
  }
  return vox.samples_weight * sum;
}

void Evaluator::read_labels(std::vector<std::int16_t>& labels) const {
  const Voxels& vox = *voxels_;
  const GridShape& shape = target_.distance.shape;
  labels.assign(shape.count(), -1);
  for (const std::size_t i : target_.inside) {
    const Eigen::Vector3i voxel = ((shape.cell(i) - vox.first_sample).cast<double>() / vox.stride).array().round().matrix().cast<int>();
    const Eigen::Vector3i c = voxel.cwiseMax(0).cwiseMin(vox.size - Eigen::Vector3i::Ones());
    const std::int32_t bone = field_[std::size_t(vox.cell(c.x(), c.y(), c.z()))] & kNoLabel;
    labels[i] = std::int16_t(bone == kNoLabel ? nearest_bone(shape.position(i)) : bone);
  }
}

void Evaluator::read_partition(std::vector<std::int16_t>& bones) const {
  const Voxels& vox = *voxels_;
  bones.clear();
  for (const Voxels::Row& row : vox.rows) {
    const std::int32_t start = vox.cell(0, row.y, row.z);
    for (int r = row.first_run; r < row.end_run; ++r)
      for (std::int32_t c = vox.runs[std::size_t(r)].begin; c < vox.runs[std::size_t(r)].end; ++c) {
        const std::int32_t bone = field_[std::size_t(c)] & kNoLabel;
        bones.push_back(std::int16_t(bone == kNoLabel ? nearest_bone(vox.position(c - start, row.y, row.z)) : bone));
      }
  }
}

}  // namespace transformables
