// Real hinges: at each joint of one axis a pin, a clevis and a tongue in place of a ball in a socket (hinge_shape.h).
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "finishing/carve.h"
#include "finishing/certificate.h"
#include "finishing/joint_plan.h"
#include "finishing/part.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// Finished parts with hinges. A joint for which there can't be one keeps its ball and socket.
class Hinges {
 public:
  /// Fits a hinge to every joint that can have one. Refers to the scene while it lives.
  /// @param plain   the parts without hinges, one at most a bone, which move along the scene's path without meeting
  /// @param fields  the same as fields
  Hinges(const Scene& scene, std::vector<Part> plain, const std::vector<PartField>& fields);

  const std::vector<Part>& parts() const { return parts_; }
  const std::vector<Part>& plain() const { return plain_; }

  /// Bones whose joint with their parent has a pin.
  std::vector<int> pinned() const;

  /// Goes back to ball and socket where parts are not proved apart: at the joints that are there, or at all joints of both parts when none is.
  /// @return flags of the bones whose parts changed; none: no part that is named has a hinge
  std::vector<char> give_up(const std::vector<Uncertified>& open);

  /// Which joints have no pin, and why; a sentence a reason.
  std::vector<std::string> warnings() const;

 private:
  enum class State : char { kNone, kPinned, kManyAxes, kWeak, kNoRoom, kNoCut, kShutIn, kGivenUp };

  using Ranges = std::vector<std::pair<double, double>>;   // of each bone's hinge, folded being 0

  void plan(const std::vector<PartField>& fields, const Ranges& ranges);
  State plan_joint(int child, const std::vector<PartField>& fields, std::pair<double, double> range, std::optional<HingeSolids>& solids) const;
  bool crowded(int child, const HingeSolids& solids) const;
  std::vector<int> joints_of(int bone) const;
  std::vector<int> joints_at(const Uncertified& place) const;
  std::optional<Part> fitted(const Part& plain, const std::vector<int>& joints) const;
  std::vector<int> culprits(const Part& plain) const;
  void drop(int joint, State why, std::vector<char>& changed);
  void fit(std::vector<char>& changed);
  const Part& part_of(int bone) const;
  bool shut_in(int joint, std::pair<double, double> range) const;
  void open_up(const Ranges& ranges);

  const Scene& scene_;
  const std::vector<Part> plain_;
  std::vector<State> state_;                         // of the joint of each bone with its parent
  std::vector<std::optional<HingeSolids>> solids_;   // the same
  std::vector<Part> parts_;
};

}  // namespace transformables::finishing
