#include "reference/objective.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace transformables::reference {

using Eigen::Vector3d;
using Eigen::Vector3i;

// A pose laid out: each bone's segments in the target's frame.
struct Objective::Posed {
  std::vector<std::vector<Segment>> segments;
  std::vector<Vector3d> heads;
  std::vector<Vector3d> axes;   ///< of each hinge, unit
};

// Where a child's voxel touches its parent's part.
struct Objective::Interface {
  int child = -1;                            ///< -1: none here
  Vector3d point = Vector3d::Zero();
  Vector3d to_parent = Vector3d::Zero();     ///< roughly
};

namespace {

constexpr double kPaperStep = 0.01;
constexpr double kThinnest = 0.87;      // voxels: the least radius that a capsule is drawn with
constexpr double kBisector = 0.1;       // of how far a point lies past a bone's end: breaks ties about a joint
constexpr double kJointRadii = 2.5;
constexpr double kNeighbourhood = 2.5;  // voxels: interface points so near to one another make its plane
constexpr double kPlain = 1e-6;         // so much of the squared spread of points: less, and they make no plane, but a line, a point or a ball
constexpr double kOneSided = 1e-9;      // voxels: less, and points have the parent on both sides alike
constexpr int kAround = 6;

double positive(double x) { return std::max(x, 0.0); }

/// Distance to a segment plus a little of how far the point lies past its end.
double with_overshoot(const Segment& s, const Vector3d& p) {
  const Vector3d along = s.b - s.a;
  const double length = along.norm(), t = length > 0 ? (p - s.a).dot(along) / length : 0;
  return distance(s, p) + kBisector * std::abs(t - std::clamp(t, 0.0, length));
}

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

template <class Visit>
void for_around(const GridShape& shape, std::size_t voxel, int reach, const Visit& visit) {
  const Vector3i c = shape.cell(voxel);
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const Vector3i n = c + Vector3i(x, y, z);
        if ((x || y || z) && shape.contains(n)) visit(shape.index(n), std::abs(x) + std::abs(y) + std::abs(z));
      }
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

// Voxels whose centre is within a capsule. Of two bones, that whose axis is nearer keeps the voxel.
std::vector<Flooded> Objective::seeds(const Posed& posed) const {
  std::vector<Flooded> flooded(shape_.count());
  double largest = 0;
  for (const Bone& bone : character_.bones) largest = std::max(largest, bone.radius);
  for (std::size_t b = 0; b < character_.bones.size(); ++b) {
    const double radius = std::max(character_.bones[b].radius, kThinnest * shape_.step);
    for (const Segment& s : posed.segments[b]) {
      const Vector3d reach = Vector3d::Constant(radius + shape_.step);
      const Vector3i low = shape_.nearest(s.a.cwiseMin(s.b) - reach).cwiseMax(0);
      const Vector3i high = shape_.nearest(s.a.cwiseMax(s.b) + reach).cwiseMin((shape_.size.array() - 1).matrix());
      for (int z = low.z(); z <= high.z(); ++z)
        for (int y = low.y(); y <= high.y(); ++y)
          for (int x = low.x(); x <= high.x(); ++x) {
            const std::size_t v = shape_.index(x, y, z);
            const Vector3d p = shape_.position(v);
            if (!inside_[v] || distance(s, p) > radius) continue;
            const double start = (with_overshoot(s, p) + largest - character_.bones[b].radius) / shape_.step;
            const auto units = std::int32_t(32 * start + 0.5);
            if (flooded[v].bone < 0 || units < flooded[v].distance) flooded[v] = {std::int16_t(b), units};
          }
    }
  }
  return flooded;
}

std::vector<Flooded> Objective::flood(const Pose& pose, const Morphology& morphology) const {
  std::vector<Flooded> flooded = seeds(posed(pose, morphology));
  if (options_.flood == FloodKind::kBreadthFirst) by_fronts(flooded);
  else by_shortest_way(flooded);
  return flooded;
}

// The paper's: the front moves on by one voxel at a time, to all neighbours, and takes the bone along.
void Objective::by_fronts(std::vector<Flooded>& flooded) const {
  std::vector<std::size_t> front, next;
  for (const std::size_t v : voxels_)
    if (flooded[v].bone >= 0) {
      flooded[v].distance = 0;
      front.push_back(v);
    }
  while (!front.empty()) {
    next.clear();
    for (const std::size_t v : front)
      for_around(shape_, v, 1, [&](std::size_t n, int) {
        if (!inside_[n] || flooded[n].bone >= 0) return;
        flooded[n] = {flooded[v].bone, flooded[v].distance + 1};
        next.push_back(n);
      });
    front.swap(next);
  }
}

// Dijkstra: the bone with the least start + way; of equal ones the lower bone.
void Objective::by_shortest_way(std::vector<Flooded>& flooded) const {
  constexpr std::int32_t kCost[4] = {0, 32, 45, 55};
  using Entry = std::pair<std::pair<std::int32_t, std::int16_t>, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::vector<char> done(shape_.count(), 0);
  for (const std::size_t v : voxels_)
    if (flooded[v].bone >= 0) open.push({{flooded[v].distance, flooded[v].bone}, v});
  while (!open.empty()) {
    const auto [key, v] = open.top();
    open.pop();
    if (done[v]) continue;
    done[v] = 1;
    for_around(shape_, v, 1, [&, at = key](std::size_t n, int axes) {
      if (!inside_[n] || done[n]) return;
      const auto offer = std::pair(at.first + kCost[axes], at.second);
      if (flooded[n].bone >= 0 && std::pair(flooded[n].distance, flooded[n].bone) <= offer) return;
      flooded[n] = {offer.second, offer.first};
      open.push({offer, n});
    });
  }
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

// Not in the paper: what share of the voxels is in the way of the joints when they all open at once, or those nearer the root ahead.
double Objective::unfold(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded) const {
  return std::min(in_the_way(pose, morphology, flooded, false), in_the_way(pose, morphology, flooded, true));
}

std::vector<std::size_t> Objective::unfolded() const {
  if (options_.unfolded == 0) return voxels_;
  std::vector<std::size_t> chosen;
  const Vector3i size = high_ - low_ + Vector3i::Ones();
  for (long k = 1; int(chosen.size()) < options_.unfolded; ++k) {
    Vector3i c;
    for (int d = 0; d < 3; ++d) {
      const double place = double(k) * std::pow(1.2207440846057596, -1 - d);  // the root of x^4 = x + 1
      c[d] = low_[d] + int((place - std::floor(place)) * size[d]);
    }
    if (inside_[shape_.index(c)]) chosen.push_back(shape_.index(c));
  }
  return chosen;
}

// A voxel goes along with the bone it belongs to, and is in the way once it is where another bone's voxel has gone, that bone having more.
double Objective::in_the_way(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded, bool staggered) const {
  const auto folded = forward_kinematics(character_, pose, morphology);
  const int n = int(folded.size()), steps = staggered ? 6 : 5;
  std::vector<int> depth;
  for (const Bone& bone : character_.bones) depth.push_back(bone.parent < 0 ? 0 : depth[std::size_t(bone.parent)] + 1);
  const int deepest = *std::max_element(depth.begin(), depth.end());
  const std::vector<std::size_t> moved = unfolded();
  std::vector<int> has(std::size_t(n), 0);
  for (const std::size_t v : moved)
    if (flooded[v].bone >= 0) ++has[std::size_t(flooded[v].bone)];
  std::vector<char> hit(moved.size(), 0);
  for (int k = 1; k <= steps; ++k) {
    Pose now = pose;
    for (int b = 0; b < n; ++b)
      for (std::size_t h = 0; h < character_.bones[std::size_t(b)].hinges.size(); ++h) {
        const double done = double(k) / steps;
        const double opened = staggered ? std::clamp(2 * done - double(depth[std::size_t(b)] - 1) / deepest, 0.0, 1.0) : done;
        now.angles[character_.bones[std::size_t(b)].first_angle + Eigen::Index(h)] *= 1 - opened;
      }
    const auto frames = forward_kinematics(character_, now, morphology);
    for (std::size_t i = 0; i < moved.size(); ++i)
      for (int a = flooded[moved[i]].bone, b = 0; a >= 0 && b < n; ++b) {
        const auto mine = std::pair(has[std::size_t(a)], -a), other = std::pair(has[std::size_t(b)], -b);
        if (a == b || hit[i] || mine > other) continue;
        const Eigen::Isometry3d into = folded[std::size_t(b)] * frames[std::size_t(b)].inverse() * frames[std::size_t(a)] * folded[std::size_t(a)].inverse();
        const Vector3i cell = shape_.nearest(into * shape_.position(moved[i]));
        hit[i] = shape_.contains(cell) && flooded[shape_.index(cell)].bone == b;
      }
  }
  return double(std::count(hit.begin(), hit.end(), 1)) / double(moved.size());
}

}  // namespace transformables::reference
