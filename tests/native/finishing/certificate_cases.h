// What tests of the certificate share: parts made by hand that turn about hinges.
#pragma once

#include <numbers>
#include <utility>
#include <vector>

#include "cases.h"
#include "finishing/certificate.h"

namespace transformables {

inline ArmatureBone bone(const char* name, int parent, const Eigen::Vector3d& head, std::vector<int> axes) {
  ArmatureBone b{name, parent, head, head + Eigen::Vector3d(0, 0.1, 0), Eigen::Matrix3d::Identity(), {}};
  for (const int axis : axes) b.hinges.push_back({axis, -std::numbers::pi, std::numbers::pi});
  return b;
}

struct Case {
  Character character;
  Embedding embedding;
  std::vector<Part> parts;
  FoldPath path;
  CertificateOptions options;

  explicit Case(const std::vector<ArmatureBone>& bones) : character(make_character(bones)) {
    embedding.pose = rest_pose(character, Eigen::Isometry3d::Identity());
    embedding.morphology = Morphology::Ones(Eigen::Index(bones.size()));
    options.enough = 1;  // the true gap is asked for
    options.tolerance = 0.05;
  }
  void add(int owner, TriangleMesh mesh) {
    Part& part = parts.emplace_back();
    part.bone = owner;
    part.mesh = std::move(mesh);
  }
  Certificate certified() const { return certify(parts, character, embedding, path, options, {}); }
};

inline constexpr double kVoxel = kLongestSide / 64;

/// An arm about Z through the origin carries a fin along X from 0.1 to `reach`; a wall of the root's stands at X 0.2 to 0.21.
/// A fin as thin as the wall that turns by 2 radians passes it in a hundredth of the time.
inline Case fin_and_wall(double reach, double wall_from) {
  Case c({bone("root", -1, {0, -0.1, 0}, {}), bone("arm", 0, {0, 0, 0}, {2})});
  c.add(0, box_mesh({wall_from, 0.1 - 0.0005, -0.05}, {0.24, 0.1 + 0.0005, 0.05}));
  c.add(1, box_mesh({0.1, -0.0005, -0.05}, {reach, 0.0005, 0.05}));
  // The wall is in the root's frame, whose head is 0.1 under the hinge.
  c.path.moves.push_back({{{0, -1.0, 1.0}}});
  c.embedding.pose.angles[0] = -1.0;
  return c;
}

}  // namespace transformables
