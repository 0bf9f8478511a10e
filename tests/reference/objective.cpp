#include "reference/objective.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "reference/laid_out.h"

namespace transformables::reference {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Where a child's voxel touches its parent's part.
struct Objective::Interface {
  int child = -1;                            ///< -1: none here
  Vector3d point = Vector3d::Zero();
  Vector3d to_parent = Vector3d::Zero();     ///< roughly
};

namespace {

constexpr double kPaperStep = 0.01;
constexpr double kJointRadii = 2.5;
constexpr double kNeighbourhood = 2.5;  // voxels: interface points so near to one another make its plane
constexpr double kPlain = 1e-6;         // so much of the squared spread of points: less, and they make no plane, but a line, a point or a ball
constexpr double kOneSided = 1e-9;      // voxels: less, and points have the parent on both sides alike
constexpr int kAround = 6;

double positive(double x) { return std::max(x, 0.0); }

double to_bone(const std::vector<Segment>& segments, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Segment& s : segments) least = std::min(least, distance(s, p));
  return least;
}

/// A segment without the first `cut` of it; false when nothing is left.
bool shortened(const Segment& s, double cut, Segment& left) {
  const Vector3d along = s.b - s.a;
  const double length = along.norm();
  if (cut > 0 && length <= cut) return false;
  left = cut > 0 ? Segment{s.a + cut / length * along, s.b} : s;
  return true;
}

double distance_of(const std::vector<Segment>& first, double first_cut, const std::vector<Segment>& second, double second_cut) {
  double least = std::numeric_limits<double>::infinity();
  Segment a, b;
  for (const Segment& s : first)
    for (const Segment& t : second)
      if (shortened(s, first_cut, a) && shortened(t, second_cut, b)) least = std::min(least, distance(a, b));
  return least;
}

int ancestor_depth(const Character& character, int bone) {
  int depth = 0;
  for (int b = bone; b >= 0; b = character.bones[std::size_t(b)].parent) ++depth;
  return depth;
}

/// Length of skeleton between two bones' nearest joints, and whether one descends from the other.
struct Way {
  double length = 0;
  bool direct = false;
};

Way way_between(const Character& character, const std::vector<Vector3d>& heads, int i, int j) {
  const auto parent = [&](int b) { return character.bones[std::size_t(b)].parent; };
  const auto gap = [&](int a, int b) { return (heads[std::size_t(a)] - heads[std::size_t(b)]).norm(); };
  Way way;
  int a = i, b = j;
  while (parent(a) != parent(b)) {
    int& deeper = ancestor_depth(character, a) > ancestor_depth(character, b) ? a : b;
    if (parent(deeper) == (&deeper == &a ? b : a)) {
      way.direct = true;
      return way;
    }
    way.length += gap(deeper, parent(deeper));
    deeper = parent(deeper);
  }
  way.length += gap(a, b);
  return way;
}

/// Points all over a capsule: rings of six, each second one turned, and its two poles.
void for_capsule_samples(const Segment& s, int stations, double radius, const std::function<void(const Vector3d&)>& visit) {
  const Vector3d along = s.b - s.a;
  const Vector3d d = along.norm() > 0 ? Vector3d(along.normalized()) : Vector3d::UnitX();
  int smallest;
  d.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = d.cross(Vector3d::Unit(smallest)).normalized(), v = d.cross(u);
  for (int k = 0; k < stations; ++k)
    for (int r = 0; r < kAround; ++r) {
      const double turn = (r + 0.5 * (k % 2)) * 2 * M_PI / kAround;
      visit(s.a + along * k / (stations - 1) + radius * (std::cos(turn) * u + std::sin(turn) * v));
    }
  visit(s.a - radius * d);
  visit(s.b + radius * d);
}

}  // namespace

Objective::Objective(const Character& character, const Target& target, const ObjectiveWeights& weights, const ObjectiveOptions& options)
    : character_(character), target_(target), weights_(weights), options_(options) {
  const GridShape& fine = target.distance.shape;
  shape_ = fine;
  shape_.step *= options.stride;
  shape_.size = (fine.size.array() + options.stride - 1) / options.stride;
  inside_.assign(shape_.count(), 0);
  low_ = shape_.size;
  high_.setZero();
  for (const std::size_t i : target.inside) {
    const Vector3i c = fine.cell(i);
    if (((c.array() - c.array() / options.stride * options.stride) != 0).any()) continue;
    const Vector3i voxel = c / options.stride;
    inside_[shape_.index(voxel)] = 1;
    voxels_.push_back(shape_.index(voxel));
    low_ = low_.cwiseMin(voxel);
    high_ = high_.cwiseMax(voxel);
  }
}

ObjectiveTerms Objective::operator()(const Pose& pose, const Morphology& morphology) const {
  return terms(pose, morphology, flood(pose, morphology));
}

Objective::Posed Objective::posed(const Pose& pose, const Morphology& morphology) const {
  Posed result;
  const auto frames = forward_kinematics(character_, pose, morphology);
  result.axes.resize(std::size_t(character_.angle_count));
  for (std::size_t b = 0; b < frames.size(); ++b) {
    const Bone& bone = character_.bones[b];
    std::vector<Segment> segments = skeleton_of(bone, morphology[Eigen::Index(b)]);
    if (segments.empty()) segments.push_back({});
    for (Segment& s : segments) s = transformed(frames[b], s);
    result.segments.push_back(segments);
    result.heads.push_back(frames[b].translation());
    // The first hinge's axis is turned by those after it: R = Rz Ry Rx, so undo from the right.
    Eigen::Matrix3d turned = frames[b].linear();
    for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
      const auto angle = std::size_t(bone.first_angle) + k;
      turned = turned * Eigen::AngleAxisd(-pose.angles[Eigen::Index(angle)], Vector3d::Unit(bone.hinges[k].axis)).toRotationMatrix();
      result.axes[angle] = turned.col(bone.hinges[k].axis);
    }
  }
  return result;
}

ObjectiveTerms Objective::terms(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded) const {
  const Posed at = posed(pose, morphology);
  ObjectiveTerms terms;
  terms.compact = compact(at, flooded);
  terms.skin = skin(pose, at, flooded);
  terms.skeleton = skeleton(at);
  terms.protrude = protrude(at);
  for (const Bone& bone : character_.bones)
    for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
      const double angle = pose.angles[bone.first_angle + Eigen::Index(k)];
      const double allowed = std::clamp(angle, bone.hinges[k].min_rad, bone.hinges[k].max_rad);
      terms.limits += (angle - allowed) * (angle - allowed);
    }
  terms.morphology = morphology.array().log().square().sum();
  if (weights_.unfold > 0) terms.unfold = unfold(pose, morphology, flooded);
  terms.total = weights_.unfold * terms.unfold + weights_.compact * terms.compact + weights_.skin * terms.skin + weights_.skeleton * terms.skeleton +
                weights_.protrude * terms.protrude + weights_.limits * terms.limits + weights_.morphology * terms.morphology;
  return terms;
}

bool Objective::is_sample(std::size_t voxel) const {
  const Vector3i c = shape_.cell(voxel) - low_;
  return (c.x() + 2 * c.y() + 4 * c.z()) % options_.spacing == 0;
}

bool Objective::on_boundary(const std::vector<Flooded>& flooded, std::size_t voxel) const {
  bool differs = false;
  for_around(shape_, voxel, 1, [&](std::size_t n, int axes) { differs |= axes == 1 && flooded[n].bone != flooded[voxel].bone; });
  return differs;
}

// Eq. 2. The paper's sum has one term a sample; a boundary voxel stands for a square of its step.
double Objective::compact(const Posed& posed, const std::vector<Flooded>& flooded) const {
  double sum = 0;
  for (const std::size_t v : voxels_) {
    const int bone = flooded[v].bone;
    if (bone < 0 || !is_sample(v) || !on_boundary(flooded, v)) continue;
    const double out = positive(to_bone(posed.segments[std::size_t(bone)], shape_.position(v)) - character_.bones[std::size_t(bone)].radius);
    sum += out * out;
  }
  return sum * options_.spacing * std::pow(shape_.step / kPaperStep, 2);
}

// The mean of the midpoints towards neighbours of the parent's.
Objective::Interface Objective::interface_at(const std::vector<Flooded>& flooded, std::size_t voxel) const {
  Interface result;
  const int bone = flooded[voxel].bone, parent = bone < 0 ? -1 : character_.bones[std::size_t(bone)].parent;
  if (parent < 0) return result;
  const Vector3d p = shape_.position(voxel);
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for_around(shape_, voxel, 1, [&](std::size_t n, int axes) {
    if (axes != 1 || flooded[n].bone != parent) return;
    sum += 0.5 * (shape_.position(n) + p);
    ++count;
  });
  if (count == 0) return result;
  result.child = bone;
  result.point = sum / count;
  result.to_parent = result.point - p;
  return result;
}

// Moving least squares: the plane through the joint's interface points near this one, nearer ones counting more. The weight runs out
// to nothing at the reach, so that a point which comes or goes there makes no jump. Where there is no plane: towards the parent.
Vector3d Objective::fitted_normal(const std::vector<Interface>& interfaces, std::size_t voxel) const {
  const Interface& here = interfaces[voxel];
  const double reach = kNeighbourhood * shape_.step;
  std::vector<std::pair<const Interface*, double>> near{{&here, 1.0}};
  Vector3d mean = here.point, side = here.to_parent;
  double weights = 1;
  for_around(shape_, voxel, 3, [&](std::size_t n, int) {
    const Interface& other = interfaces[n];
    if (other.child != here.child) return;
    const double weight = std::pow(positive(1 - (other.point - here.point).squaredNorm() / (reach * reach)), 3);
    near.emplace_back(&other, weight);
    mean += weight * other.point;
    side += weight * other.to_parent;
    weights += weight;
  });
  mean /= weights;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& [other, weight] : near) covariance += weight * (other->point - mean) * (other->point - mean).transpose();
  const double one_sided = kOneSided * weights * shape_.step;
  if (side.norm() <= one_sided) return Vector3d::Zero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Vector3d spread = solver.eigenvalues();
  if ((spread[1] - spread[0]) * (spread[2] - spread[0]) <= kPlain * spread.sum() * spread.sum()) return side.normalized();
  const Vector3d normal = solver.eigenvectors().col(0);
  if (std::abs(normal.dot(side)) <= one_sided) return Vector3d::Zero();
  return normal.dot(side) < 0 ? Vector3d(-normal) : normal;
}

// Eq. 3: p from the joint, the range from the embedding's angle.
double Objective::skin(const Pose& pose, const Posed& posed, const std::vector<Flooded>& flooded) const {
  std::vector<Interface> interfaces(shape_.count());
  for (const std::size_t v : voxels_) interfaces[v] = interface_at(flooded, v);
  double sum = 0;
  for (const std::size_t v : voxels_) {
    const Interface& at = interfaces[v];
    if (at.child < 0 || !is_sample(v)) continue;
    const Vector3d normal = fitted_normal(interfaces, v);
    const Bone& bone = character_.bones[std::size_t(at.child)];
    for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
      const auto angle = std::size_t(bone.first_angle) + k;
      const double alpha = pose.angles[Eigen::Index(angle)];
      const Vector3d velocity = posed.axes[angle].cross(at.point - posed.heads[std::size_t(at.child)]);
      sum += positive(((bone.hinges[k].min_rad - alpha) * velocity).dot(normal)) + positive(((bone.hinges[k].max_rad - alpha) * velocity).dot(normal));
    }
  }
  return sum * options_.spacing * std::pow(shape_.step / kPaperStep, 2);
}

// Eq. 4.
double Objective::skeleton(const Posed& posed) const {
  double sum = 0;
  const auto& bones = character_.bones;
  for (std::size_t j = 0; j < bones.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      double first_cut = 0, second_cut = 0;
      if (options_.collisions == CollisionKind::kNotJoined) {
        if (bones[j].parent == int(i)) continue;
      } else {
        const Way way = way_between(character_, posed.heads, int(i), int(j));
        second_cut = positive(kJointRadii * 0.5 * (bones[i].radius + bones[j].radius) - way.length);
        if (!way.direct) first_cut = second_cut;
      }
      const double deep = positive(bones[i].radius + bones[j].radius - distance_of(posed.segments[i], first_cut, posed.segments[j], second_cut));
      sum += deep * deep;
    }
  return sum;
}

// Eq. 5. A capsule has so many samples as its length at scale 1 asks for, so that M never changes.
double Objective::protrude(const Posed& posed) const {
  double sum = 0;
  long count = 0;
  for (std::size_t b = 0; b < character_.bones.size(); ++b) {
    const Bone& bone = character_.bones[b];
    for (std::size_t s = 0; s < posed.segments[b].size(); ++s) {
      const double length = bone.segments.empty() ? 0 : (bone.segments[s].b - bone.segments[s].a).norm();
      const int stations = 1 + std::max(1, int(std::ceil(length / kPaperStep)));
      for_capsule_samples(posed.segments[b][s], stations, bone.radius, [&](const Vector3d& p) {
        const double out = positive(distance_at(target_, p));
        sum += out * out;
        ++count;
      });
    }
  }
  return sum / double(count);
}

}  // namespace transformables::reference
