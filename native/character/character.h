// The character: a tree of rigid bones joined by hinges, and where a pose puts them (paper, section 3).
//
// Frames. "Bone frame": origin at the bone's head, axes those of Blender's rest bone (Y runs along the bone).
// "Character frame": that in which the armature's bones were given. "Target frame": see target/target.h; all
// lengths of a character that was fitted (`fitted`) are in its units.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "common/capsule.h"
#include "common/mesh.h"

namespace transformables {

/// One axis about which a bone may turn, at its head.
struct Hinge {
  int axis = 0;        ///< 0, 1, 2: X, Y, Z of the bone's own rest frame
  double min_rad = 0;  ///< least angle, rest being 0
  double max_rad = 0;  ///< largest angle
};

/// A bone as an armature has it.
struct ArmatureBone {
  std::string name;
  int parent = -1;                                        ///< index into the same list, -1 for a root
  Eigen::Vector3d head = Eigen::Vector3d::Zero();         ///< character frame
  Eigen::Vector3d tail = Eigen::Vector3d::Zero();         ///< character frame
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();     ///< columns: the bone's X, Y, Z at rest, character frame
  std::vector<Hinge> hinges;                              ///< none (rigid with its parent) to three, in X, Y, Z order
};

/// One rigid body of the character: an armature bone with all that are fixed to it.
struct Bone {
  std::string name;                                            ///< of the armature bone that leads it
  int parent = -1;                                             ///< index of its parent, which comes before it; -1: the root
  std::vector<int> members;                                    ///< armature bones it is made of; the first leads
  Eigen::Vector3d head_in_parent = Eigen::Vector3d::Zero();    ///< parent's bone frame, when the parent's scale is 1
  Eigen::Quaterniond rest_in_parent = Eigen::Quaterniond::Identity();
  std::vector<Hinge> hinges;                                   ///< one to three (the root: none), they act in X, Y, Z order
  int first_angle = 0;                                         ///< where this bone's hinges start in Pose::angles
  std::vector<Segment> segments;                               ///< its skeleton, bone frame, scale 1: from the head to its child's head, or to the tail; with several
                                                               ///< children a spine along the bone and a rib to each child's head
  double radius = 0;                                           ///< of its capsules and joint housing; not changed by the morphology
  int mirror = -1;                                             ///< the bone on the other side; itself when it lies in the mirror plane; -1: none
};

struct Character {
  std::vector<Bone> bones;                                     ///< parents before children; bones[0] is the root
  Eigen::Isometry3d root_rest = Eigen::Isometry3d::Identity(); ///< root's bone frame at rest, in the character frame
  int angle_count = 0;                                         ///< hinges in all
  bool mirrored = false;                                       ///< every bone has a mirror bone (across X = `mirror_x` of the character frame)
  double mirror_x = 0;                                         ///< where that plane is
  double scale = 1;                                            ///< factor by which `fitted` scaled the armature's lengths
  std::vector<int> mirror_angle;                               ///< for each angle, the angle that takes its place in a mirror; empty unless `mirrored`
  std::vector<double> mirror_sign;                             ///< and its sign (1 or -1)
};

/// S of the paper: where the root is, and an angle for each hinge.
struct Pose {
  Eigen::Isometry3d root = Eigen::Isometry3d::Identity();  ///< root's bone frame, in the target's frame
  Eigen::VectorXd angles;                                  ///< radians, angle_count of them
};

/// M of the paper: a scale factor for each bone of the Character.
using Morphology = Eigen::VectorXd;

/// The character of an armature: fixed bones joined to their parents, skeleton segments laid, mirror map found
/// (from `.L/.R`, `_l/_r`, `left/right` names when they agree with the geometry, else from the geometry alone).
/// @throws InvalidInput without bones, with several roots, a parent index out of range or a cycle, non-finite or
///         all-equal positions, axes that are no rotation, a hinge whose range is empty or does not hold finite numbers,
///         or when no bone has a hinge.
Character make_character(const std::vector<ArmatureBone>& bones);

/// The same character scaled as a whole for a target, with the radii of its capsules set: the uniform fit of
/// DESIGN section 2. With `scale` 0 the scale is chosen: mean skeleton length per bone = 1.3 (V / n)^(1/3) for
/// n bones in volume V, but no bone longer than 0.6 of the target's longest side.
/// The radius is 0.1 (V / n)^(1/3), not under `least_radius`.
/// @param target_volume  cubic target units, positive
/// @param longest_side   of the target, target units, positive
/// Everything that is a length is scaled alike: `root_rest`'s origin and `mirror_x` too.
/// @throws InvalidInput when a number is not positive (scale: negative) or not finite.
Character fitted(const Character& character, double target_volume, double longest_side, double least_radius, double scale = 0);

/// Frames of all bones in the target's frame: element i takes points of bone i's frame there.
/// Lengths within bone i (its segments, its children's heads) are multiplied by morphology[i].
/// Angles of a bone with several hinges act in X, Y, Z order about its head (Blender's XYZ Euler).
/// @throws InvalidInput when the pose has not `angle_count` angles, or the morphology not a factor for each bone.
std::vector<Eigen::Isometry3d> forward_kinematics(const Character& character, const Pose& pose, const Morphology& morphology);

/// The same into `frames`, which is made to fit; nothing is allocated when it fits already.
void forward_kinematics(const Character& character, const Pose& pose, const Morphology& morphology,
                        std::vector<Eigen::Isometry3d>& frames);

/// The rotation of a bone against its rest, from its own angles (`angles` is the whole vector of a pose).
Eigen::Quaterniond joint_rotation(const Bone& bone, const Eigen::VectorXd& angles);

/// S_R: every hinge at 0, the root as given.
Pose rest_pose(const Character& character, const Eigen::Isometry3d& root);

/// Skeleton segments of bone i in its own frame, with the morphology applied.
std::vector<Segment> skeleton_of(const Bone& bone, double scale);

/// The pose's mirror image: angles of mirrored bones swapped (with the sign that the mirrored axes ask for); the
/// root is left alone.
/// @throws InvalidInput unless `character.mirrored`, or when there are not `angle_count` angles.
Eigen::VectorXd mirrored_angles(const Character& character, const Eigen::VectorXd& angles);

/// Bones that turn with bone `i`: itself and all its descendants, as flags.
/// @throws InvalidInput when there is no bone `i`.
std::vector<char> subtree(const Character& character, int i);

/// Signed distance (negative inside) from a point in bone i's frame to its skeletal mesh: the hulls of its own joint
/// housing with each of its children's (balls of `radius`, so each hull is a capsule), minus the room in which the
/// children's housings turn (balls of radius + gap about their heads). `room` are those heads in the bone's frame.
struct SkeletalShape {
  std::vector<Segment> capsules;        ///< bone frame, morphology applied
  double radius = 0;
  std::vector<Eigen::Vector3d> rooms;   ///< children's heads, bone frame, morphology applied
  double room_radius = 0;               ///< child's housing radius + gap

  double distance(const Eigen::Vector3d& p_in_bone) const;
};

/// The skeletal shape of every bone; `gap` is the clearance between housings, target units.
/// A child's room is cut only when a fifth of the bone's own radius stays clear about its head (so not for joints that
/// share a point, or almost): a shape always contains its bone's head.
/// @throws InvalidInput when the gap is negative or not finite, or the morphology has not a factor for each bone.
std::vector<SkeletalShape> skeletal_shapes(const Character& character, const Morphology& morphology, double gap);

/// The skeletal mesh of a bone as a closed triangle mesh in its own frame, for display: the hulls of housing balls,
/// each triangulated (CGAL's convex hull); the children's rooms are not cut. Each hull is closed; they overlap at the head.
/// @throws InvalidInput when there is no such bone, the morphology does not fit, or the bone has no radius (see `fitted`).
TriangleMesh skeletal_mesh(const Character& character, const Morphology& morphology, int bone);

}  // namespace transformables
