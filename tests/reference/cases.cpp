#include "reference/cases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace transformables::reference {
namespace {

using Eigen::Vector3d;

double box_distance(const Vector3d& p, const Vector3d& low, const Vector3d& high) {
  const Vector3d q = (p - 0.5 * (low + high)).cwiseAbs() - 0.5 * (high - low);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

/// Bones are added one after another; each turns about the axis across it that is nearest to `hinge`.
struct Builder {
  std::vector<ArmatureBone> bones;

  int add(const std::string& name, int parent, const Vector3d& head, const Vector3d& tail, const Vector3d& hinge, double low, double high) {
    ArmatureBone bone{name, parent, head, tail, Eigen::Matrix3d::Identity(), {}};
    bone.axes.col(1) = (tail - head).normalized();
    bone.axes.col(0) = (hinge - hinge.dot(bone.axes.col(1)) * bone.axes.col(1)).normalized();
    bone.axes.col(2) = bone.axes.col(0).cross(bone.axes.col(1));
    if (parent >= 0) bone.hinges.push_back({0, low, high});
    bones.push_back(std::move(bone));
    return int(bones.size()) - 1;
  }

  Character fit(const Target& target) const {
    return fitted(make_character(bones), target.volume, kLongestSide, 0.9 * target.distance.shape.step);
  }
};

/// An octahedron whose triangles are cut in four, again and again, and drawn to the ellipsoid.
TriangleMesh ellipsoid_mesh(const Vector3d& half, int cuts) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3i t(n & 1, 2 + (n >> 1 & 1), 4 + (n >> 2));
    mesh.triangles.push_back((n ^ n >> 1 ^ n >> 2) & 1 ? Eigen::Vector3i(t[0], t[2], t[1]) : t);
  }
  for (int cut = 0; cut < cuts; ++cut) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), int(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Eigen::Vector3i m(middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0]));
      finer.insert(finer.end(), {m, {t[0], m[0], m[2]}, {t[1], m[1], m[0]}, {t[2], m[2], m[1]}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vector3d& v : mesh.vertices) v = v.cwiseProduct(half);
  return mesh;
}

}  // namespace

Target target_of(const Vector3d& half, double step, const std::function<double(const Vector3d&)>& distance) {
  Target target;
  GridShape shape;
  shape.step = step;
  shape.size = (2 * half / step).array().round().matrix().cast<int>() + Eigen::Vector3i::Constant(8);
  shape.origin = -0.5 * step * (shape.size - Eigen::Vector3i::Ones()).cast<double>();
  target.distance = Grid<float>(shape, 0);
  for (std::size_t i = 0; i < shape.count(); ++i) {
    target.distance[i] = float(distance(shape.position(i)));
    if (target.distance[i] < 0) target.inside.push_back(i);
  }
  target.volume = double(target.inside.size()) * step * step * step;
  target.mirror_axis = 0;
  return target;
}

Target box(const Vector3d& half, int resolution) {
  return target_of(half, kLongestSide / resolution, [&](const Vector3d& p) { return box_distance(p, -half, half); });
}

Target ball(int resolution) {
  return target_of(Vector3d::Constant(0.25), kLongestSide / resolution, [](const Vector3d& p) { return p.norm() - 0.25; });
}

Target u_shape(int resolution) {
  return target_of({0.25, 0.1, 0.25}, kLongestSide / resolution, [](const Vector3d& p) {
    return std::min({box_distance(p, {-0.25, -0.1, -0.25}, {-0.04, 0.1, 0.25}), box_distance(p, {0.04, -0.1, -0.25}, {0.25, 0.1, 0.25}),
                     box_distance(p, {-0.25, -0.1, -0.25}, {0.25, 0.1, -0.1})});
  });
}

double ellipsoid_distance(const Vector3d& half, Vector3d p) {
  p = p.cwiseAbs().cwiseMax(1e-9);
  const Vector3d squares = half.cwiseAbs2();
  const auto excess = [&](double t) { return (half.cwiseProduct(p).array() / (squares.array() + t)).square().sum() - 1; };
  double low = -squares.minCoeff(), high = half.norm() * p.norm();
  for (int k = 0; k < 80; ++k) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  const Vector3d foot = squares.cwiseProduct(p).array() / (squares.array() + high);
  return std::copysign((p - foot).norm(), high);
}

Target ellipsoid(const Eigen::Vector3i& voxels) {
  const double step = kLongestSide / voxels.maxCoeff();
  const Vector3d half = 0.5 * step * voxels.cast<double>();
  Target target = target_of(half, step, [&](const Vector3d& p) { return ellipsoid_distance(half, p); });
  target.mesh = ellipsoid_mesh(half, 5);
  return target;
}

Character humanoid(const Target& target) {
  Builder b;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  const int pelvis = b.add("pelvis", -1, {0, 0, 1}, {0, 0, 1.15}, x, 0, 0);
  const int spine = b.add("spine", pelvis, {0, 0, 1.15}, {0, 0, 1.3}, x, -1.2, 1.2);
  const int chest = b.add("chest", spine, {0, 0, 1.3}, {0, 0, 1.5}, x, -1.2, 1.2);
  const int neck = b.add("neck", chest, {0, 0, 1.5}, {0, 0, 1.6}, x, -1, 1);
  b.add("head", neck, {0, 0, 1.6}, {0, 0, 1.85}, x, -1, 1);
  for (const double s : {1.0, -1.0}) {
    const std::string end = s > 0 ? ".L" : ".R";
    const int shoulder = b.add("shoulder" + end, chest, {0.05 * s, 0, 1.45}, {0.2 * s, 0, 1.45}, y, -1, 1);
    const int upper = b.add("upper_arm" + end, shoulder, {0.2 * s, 0, 1.45}, {0.5 * s, 0, 1.45}, y, -2, 2);
    const int lower = b.add("forearm" + end, upper, {0.5 * s, 0, 1.45}, {0.75 * s, 0, 1.45}, s * x + Vector3d::UnitZ(), -2.4, 2.4);
    b.add("hand" + end, lower, {0.75 * s, 0, 1.45}, {0.95 * s, 0, 1.45}, y, -1.5, 1.5);
    const int thigh = b.add("thigh" + end, pelvis, {0.12 * s, 0, 1}, {0.12 * s, 0, 0.6}, x, -2.2, 2.2);
    const int shin = b.add("shin" + end, thigh, {0.12 * s, 0, 0.6}, {0.12 * s, 0, 0.15}, x, -2.4, 2.4);
    const int foot = b.add("foot" + end, shin, {0.12 * s, 0, 0.15}, {0.12 * s, -0.15, 0.05}, x, -1.5, 1.5);
    b.add("toe" + end, foot, {0.12 * s, -0.15, 0.05}, {0.12 * s, -0.28, 0.05}, x, -1, 1);
  }
  return b.fit(target);
}

Character spider(const Target& target) {
  Builder b;
  const int body = b.add("body", -1, {0, -0.3, 0}, {0, 0.3, 0}, Vector3d::UnitX(), 0, 0);
  for (const double s : {1.0, -1.0})
    for (int k = 0; k < 4; ++k) {
      const std::string name = std::to_string(k) + (s > 0 ? ".L" : ".R");
      const double y = -0.3 + 0.2 * k;
      const int upper = b.add("upper" + name, body, {0.1 * s, y, 0}, {0.5 * s, y, 0.1}, Vector3d::UnitZ(), -1.5, 1.5);
      b.add("lower" + name, upper, {0.5 * s, y, 0.1}, {0.9 * s, y, -0.2}, Vector3d::UnitY(), -2.4, 2.4);
    }
  return b.fit(target);
}

Character snake(const Target& target) {
  Builder b;
  for (int k = 0; k < 7; ++k)
    b.add("b" + std::to_string(k), k - 1, {0, 0.1 * k, 0}, {0, 0.1 * (k + 1), 0}, k % 2 ? Vector3d::UnitX() : Vector3d::UnitZ(), -2.2, 2.2);
  return b.fit(target);
}

std::vector<Case> made_cases(int resolution) {
  std::vector<Case> made{{"spider in a ball", ball(resolution), {}}, {"humanoid in a box", box({0.15, 0.12, 0.25}, resolution), {}},
                         {"snake in a U", u_shape(resolution), {}}};
  made[0].character = spider(made[0].target);
  made[1].character = humanoid(made[1].target);
  made[2].character = snake(made[2].target);
  return made;
}

Pose random_pose(const Character& character, Random& random, double spread) {
  Pose pose{Eigen::Isometry3d::Identity(), Eigen::VectorXd(character.angle_count)};
  for (int a = 0; a < 3; ++a) pose.root.translation()[a] = random.uniform(-spread, spread);
  pose.root.linear() = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix();
  for (const Bone& bone : character.bones)
    for (std::size_t k = 0; k < bone.hinges.size(); ++k)
      pose.angles[bone.first_angle + Eigen::Index(k)] = random.uniform(bone.hinges[k].min_rad - 0.2, bone.hinges[k].max_rad + 0.2);
  return pose;
}

Morphology random_morphology(const Character& character, Random& random) {
  Morphology morphology(Eigen::Index(character.bones.size()));
  for (double& scale : morphology) scale = random.uniform(0.6, 1.6);
  return morphology;
}

Embedding folded(const Character& character, const Target& target, unsigned seed, int evaluations) {
  EmbeddingOptions options;
  options.seed = seed;
  options.runs = 1;
  options.starts = 8;
  options.evaluations = evaluations;
  options.symmetry = Symmetry::kOff;
  options.weights.unfold = 0;   // the paper's own objective
  return embed(character, target, options, {});
}

}  // namespace transformables::reference
