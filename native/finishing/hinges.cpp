#include "finishing/hinges.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "finishing/exact_cut.h"
#include "finishing/finishing.h"
#include "finishing/joint_plan.h"
#include "finishing/motion.h"
#include "finishing/openness.h"

namespace transformables::finishing {
namespace {

// In steps of the lattice, on which surfaces stand to a tenth.
constexpr double kSurface = 0.1;       ///< between what is added and the target's surface
constexpr double kFurtherStep = 0.3;   ///< steps by which the body is looked for further out: carving sets some back
constexpr int kFurther = 4;
constexpr double kCrumb = 0.004;       ///< of a part's volume: pieces that a hinge may cut off
constexpr double kBeside = 2;          ///< how far from a hinge a place counts as at it
constexpr double kSlit = kLongestSide / 192;   ///< target units, 0.8 mm of 150 mm: through a narrower opening nothing comes out
constexpr double kAround = 2;          ///< of a hinge's radius: how far about it hollows are looked for
constexpr int kAngles = 9;             ///< at which they are, over a joint's range

Eigen::Isometry3d joint_frame(const Eigen::Isometry3d& bone, int axis) {
  Eigen::Isometry3d frame = bone;
  frame.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), bone.linear().col(axis)).toRotationMatrix();
  return frame;
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles) mesh.triangles.push_back(t.array() + first);
}

GridShape cube_around(const Eigen::Vector3d& centre, double radius) {
  const int half = int(std::ceil(radius / kSlit)) + 1;
  GridShape shape;
  shape.step = kSlit;
  shape.size.setConstant(2 * half + 1);
  shape.origin = centre - Eigen::Vector3d::Constant(half * kSlit);
  return shape;
}

/// Angles that the path turns each one-hinge bone through, folded being 0.
std::vector<std::pair<double, double>> ranges_of(const Scene& scene) {
  const Eigen::VectorXd& folded = scene.embedding.pose.angles;
  std::vector<std::pair<double, double>> ranges(scene.character.bones.size(), {0, 0});
  for (const Eigen::VectorXd& angles : states_of(scene.path, folded))
    for (std::size_t n = 0; n < ranges.size(); ++n) {
      const Bone& bone = scene.character.bones[n];
      if (bone.hinges.size() != 1) continue;
      const double turned = angles[bone.first_angle] - folded[bone.first_angle];
      ranges[n] = {std::min(ranges[n].first, turned), std::max(ranges[n].second, turned)};
    }
  return ranges;
}

}  // namespace

Hinges::Hinges(const Scene& scene, std::vector<Part> plain, const std::vector<PartField>& fields)
    : scene_(scene), plain_(std::move(plain)), state_(fields.size(), State::kNone), solids_(fields.size()), parts_(plain_) {
  const Ranges ranges = ranges_of(scene_);
  plan(fields, ranges);
  std::vector<char> all(fields.size(), 1);
  fit(all);
  open_up(ranges);
}

void Hinges::plan(const std::vector<PartField>& fields, const Ranges& ranges) {
  std::vector<std::optional<HingeSolids>> solids(state_.size());
  tbb::parallel_for(std::size_t(0), state_.size(), [&](std::size_t child) {
    if (scene_.character.bones[child].parent >= 0) state_[child] = plan_joint(int(child), fields, ranges[child], solids[child]);
  });
  for (std::size_t child = 0; child < state_.size(); ++child) {
    if (state_[child] != State::kPinned) continue;
    if (crowded(int(child), *solids[child])) state_[child] = State::kNoRoom;
    else solids_[child] = std::move(solids[child]);
  }
}

Hinges::State Hinges::plan_joint(int child, const std::vector<PartField>& fields, std::pair<double, double> range,
                                 std::optional<HingeSolids>& solids) const {
  const Bone& bone = scene_.character.bones[std::size_t(child)];
  const PartField &own = fields[std::size_t(child)], &parent = fields[std::size_t(bone.parent)];
  if (inside_count(own.psi) == 0 || inside_count(parent.psi) == 0) return State::kNone;
  if (bone.hinges.size() != 1) return State::kManyAxes;
  const Eigen::Isometry3d frame = joint_frame(scene_.segmentation.frames[std::size_t(child)], bone.hinges[0].axis);
  const Lattice& lattice = scene_.lattice;
  const double depth = -double(sample(lattice.outer, frame.translation())) - kSurface * lattice.step();
  HingeSize size;
  if (!hinge_size(bone.radius, lattice.gap, bone.radius, size)) return State::kWeak;
  if (!hinge_size(bone.radius, lattice.gap, depth, size)) return State::kNoRoom;
  for (int further = 0; further <= kFurther && !solids; ++further) {
    solids = plan_hinge(lattice, own, parent, frame, size, range, further * kFurtherStep * lattice.step());
  }
  return solids ? State::kPinned : State::kNoRoom;
}

/// Whether another hinge of one of the two bones is too near.
bool Hinges::crowded(int child, const HingeSolids& solids) const {
  const auto& bones = scene_.character.bones;
  const int parent = bones[std::size_t(child)].parent;
  for (int other = 0; other < child; ++other) {
    const auto& theirs = solids_[std::size_t(other)];
    const int up = bones[std::size_t(other)].parent;
    if (!theirs || (other != parent && up != parent && up != child)) continue;
    if ((theirs->centre - solids.centre).norm() < theirs->radius + solids.radius + scene_.lattice.step()) return true;
  }
  return false;
}

std::vector<int> Hinges::joints_of(int bone) const {
  std::vector<int> joints;
  for (int joint = 0; joint < int(solids_.size()); ++joint)
    if (solids_[std::size_t(joint)] && (joint == bone || scene_.character.bones[std::size_t(joint)].parent == bone)) joints.push_back(joint);
  return joints;
}

/// A part with the hinges of some of its joints.
std::optional<Part> Hinges::fitted(const Part& plain, const std::vector<int>& joints) const {
  const Eigen::Isometry3d into = scene_.segmentation.frames[std::size_t(plain.bone)].inverse(Eigen::Isometry);
  const double crumb = kCrumb * plain.volume;
  TriangleMesh given;
  std::optional<SourcedMesh> solid = SourcedMesh{plain.mesh, plain.source};
  for (const int joint : joints) {
    const HingeSolids& hinge = *solids_[std::size_t(joint)];
    if (joint != plain.bone) append(given, moved(hinge.given, into));
    else if (solid = combined(*solid, moved(hinge.taken, into), Combination::kDifference, crumb); !solid) return std::nullopt;
  }
  if (!given.empty()) solid = combined(*solid, given, Combination::kUnion, crumb);
  if (!solid || !round_and_tidy(*solid, Eigen::Isometry3d::Identity(), scene_.lattice.scale) || !check(solid->mesh, true).good()) return std::nullopt;
  const double volume = signed_volume(solid->mesh);
  return Part{plain.bone, std::move(solid->mesh), std::move(solid->source), volume};
}

/// Joints for which a part can't be cut: those that fail alone, or when none does, all.
std::vector<int> Hinges::culprits(const Part& plain) const {
  const std::vector<int> joints = joints_of(plain.bone);
  std::vector<int> failing;
  for (const int joint : joints)
    if (!fitted(plain, {joint})) failing.push_back(joint);
  return failing.empty() ? joints : failing;
}

/// Makes parts anew; where that fails, drops hinges, and flags the bones of both sides.
void Hinges::fit(std::vector<char>& changed) {
  std::vector<char> wanted = changed;
  while (std::count(wanted.begin(), wanted.end(), 1) > 0) {
    std::vector<std::vector<int>> failed(plain_.size());
    tbb::parallel_for(std::size_t(0), plain_.size(), [&](std::size_t n) {
      const Part& plain = plain_[n];
      if (!wanted[std::size_t(plain.bone)]) return;
      const std::vector<int> joints = joints_of(plain.bone);
      auto part = joints.empty() ? std::optional(plain) : fitted(plain, joints);
      if (part) parts_[n] = std::move(*part);
      else failed[n] = culprits(plain);
    });
    std::fill(wanted.begin(), wanted.end(), 0);
    for (const auto& joints : failed)
      for (const int joint : joints) drop(joint, State::kNoCut, wanted);
    for (std::size_t n = 0; n < wanted.size(); ++n) changed[n] |= wanted[n];
  }
}

void Hinges::drop(int joint, State why, std::vector<char>& changed) {
  state_[std::size_t(joint)] = why;
  solids_[std::size_t(joint)].reset();
  changed[std::size_t(joint)] = changed[std::size_t(scene_.character.bones[std::size_t(joint)].parent)] = 1;
}

const Part& Hinges::part_of(int bone) const {
  return *std::find_if(parts_.begin(), parts_.end(), [bone](const Part& part) { return part.bone == bone; });
}

/// Whether one part of a joint turns in a hollow of the other that is closed all round.
bool Hinges::shut_in(int joint, std::pair<double, double> range) const {
  const Bone& bone = scene_.character.bones[std::size_t(joint)];
  const auto& frames = scene_.segmentation.frames;
  const HingeSolids& hinge = *solids_[std::size_t(joint)];
  const Eigen::Isometry3d frame = joint_frame(frames[std::size_t(joint)], bone.hinges[0].axis);
  const auto distance = [&](int b) {
    return signed_distance(part_of(b).mesh, cube_around(frames[std::size_t(b)].inverse(Eigen::Isometry) * hinge.centre, kAround * hinge.radius));
  };
  const Grid<float> child = distance(joint), parent = distance(bone.parent);
  const auto enters = [&](const Grid<float>& other, int its, const Grid<float>& solid, int bone_of_solid, double sense) {
    const Eigen::Isometry3d into = frames[std::size_t(its)].inverse(Eigen::Isometry), from = frames[std::size_t(bone_of_solid)];
    const std::vector<Eigen::Vector3d> hollows = shut_hollows(solid);
    for (int n = 0; n < kAngles; ++n) {
      const double angle = sense * (range.first + (range.second - range.first) * n / (kAngles - 1));
      const Eigen::Isometry3d turned = into * frame * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * frame.inverse(Eigen::Isometry) * from;
      if (std::any_of(hollows.begin(), hollows.end(), [&](const Eigen::Vector3d& p) { return sample(other, turned * p) < 0; })) return true;
    }
    return false;
  };
  return enters(parent, bone.parent, child, joint, 1) || enters(child, joint, parent, bone.parent, -1);
}

void Hinges::open_up(const Ranges& ranges) {
  std::vector<char> shut(state_.size(), 0), changed(state_.size(), 0);
  tbb::parallel_for(std::size_t(0), shut.size(), [&](std::size_t n) { shut[n] = solids_[n] && shut_in(int(n), ranges[n]); });
  for (std::size_t n = 0; n < shut.size(); ++n)
    if (shut[n]) drop(int(n), State::kShutIn, changed);
  fit(changed);
}

std::vector<int> Hinges::joints_at(const Uncertified& place) const {
  std::vector<int> joints = joints_of(place.bone_a), at;
  for (const int joint : joints_of(place.bone_b)) joints.push_back(joint);
  const Eigen::Vector3d p = scene_.segmentation.frames[std::size_t(place.bone_a)] * place.on_a;
  const double near = kBeside * scene_.lattice.step();
  std::copy_if(joints.begin(), joints.end(), std::back_inserter(at), [&](int joint) {
    const HingeSolids& hinge = *solids_[std::size_t(joint)];
    return place.reason == Uncertified::Reason::kTouching && (hinge.centre - p).norm() < hinge.radius + near;
  });
  return at.empty() ? joints : at;
}

std::vector<char> Hinges::give_up(const std::vector<Uncertified>& open) {
  std::vector<char> changed(state_.size(), 0), given_up(state_.size(), 0);
  for (const Uncertified& place : open)
    for (const int joint : joints_at(place)) given_up[std::size_t(joint)] = 1;
  for (int joint = 0; joint < int(given_up.size()); ++joint)
    if (given_up[std::size_t(joint)]) drop(joint, State::kGivenUp, changed);
  fit(changed);
  return changed;
}

std::vector<int> Hinges::pinned() const {
  std::vector<int> bones;
  for (int joint = 0; joint < int(solids_.size()); ++joint)
    if (solids_[std::size_t(joint)]) bones.push_back(joint);
  return bones;
}

std::vector<std::string> Hinges::warnings() const {
  const std::array<std::pair<State, const char*>, 6> reasons{{
      {State::kManyAxes, "they turn about several axes. A ball sits in a socket there, which you have to make hold it"},
      {State::kWeak, "a pin would be too weak there, since the clearance is wide for bones this thin. Print larger"},
      {State::kNoRoom, "there is no room for ears beside it, or nothing to carry them"},
      {State::kShutIn, "it would turn in a hollow that is closed all round"},
      {State::kNoCut, "cutting one gave no simple solid"},
      {State::kGivenUp, "with one the parts would touch"}}};
  std::vector<std::string> result;
  for (const auto& [state, why] : reasons) {
    std::string names;
    for (std::size_t n = 0; n < state_.size(); ++n)
      if (state_[n] == state) names += (names.empty() ? "'" : ", '") + scene_.character.bones[n].name + "'";
    if (!names.empty()) result.push_back("No pin holds the joint of " + names + ": " + why + ".");
  }
  return result;
}

}  // namespace transformables::finishing
