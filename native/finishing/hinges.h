// Real hinges: at each joint of one axis a pin, a clevis and a tongue in place of a ball in a socket (hinge_shape.h).
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "finishing/carve.h"
#include "finishing/part.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// What a joint's hinge takes from its child's part and gives to its parent's, target frame, object mode.
struct HingeSolids {
  Eigen::Vector3d centre;
  double inside = 0;      ///< radius within which there is nothing but the hinge
  double radius = 0;      ///< and that at which the parent's body begins
  TriangleMesh taken, given;
};

/// Fits hinges to finished parts, and again to those that changed; a joint for which that fails keeps its ball and socket.
class Hinges {
 public:
  /// Refers to the scene while it lives.
  explicit Hinges(const Scene& scene);

  /// The parts with their hinges.
  /// @param plain    parts without, one at most a bone
  /// @param changed  a flag for each bone whose part or field differs from the last call's; those whose hinges change are added
  const std::vector<Part>& fit(const std::vector<Part>& plain, const std::vector<PartField>& fields, std::vector<char>& changed);

  /// Goes back to ball and socket at the joint of two bones when the place, in object mode, is in their hinge; the bones' flags are set then.
  /// @param patient  not yet for places beside it, which may be mended otherwise
  bool give_up(int bone_a, int bone_b, const Eigen::Vector3d& place, bool patient, std::vector<char>& changed);

  /// Bones whose joint with their parent has a pin.
  std::vector<int> pinned() const;

  /// Which joints have no pin, and why; a sentence a reason.
  std::vector<std::string> warnings() const;

 private:
  enum class State : char { kNone, kPinned, kManyAxes, kWeak, kNoRoom, kNoCut, kGivenUp };

  void plan(const std::vector<PartField>& fields, std::vector<char>& changed);
  State plan_joint(int child, const std::vector<PartField>& fields, std::optional<HingeSolids>& solids) const;
  bool crowded(int child, const HingeSolids& solids) const;
  std::vector<int> joints_of(int bone) const;
  std::optional<Part> fitted(const Part& plain, const std::vector<int>& joints) const;
  std::vector<int> culprits(const Part& plain) const;
  void drop(int joint, State why, std::vector<char>& changed);

  const Scene& scene_;
  std::vector<std::pair<double, double>> range_;           // a bone each: angles that the path turns its hinge through, folded being 0
  std::vector<State> state_;                               // of the joint of each bone with its parent
  std::vector<std::optional<HingeSolids>> solids_;         // the same
  std::vector<Part> all_, kept_;
};

}  // namespace transformables::finishing
