// Parts as proofs need them.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "finishing/box_tree.h"
#include "finishing/certificate.h"
#include "finishing/part.h"

namespace transformables {

class ReadyParts {
 public:
  struct Ready {
    TriangleMesh mesh;
    finishing::BoxTree tree;
    std::vector<Eigen::Vector3d> points;   ///< one of each connected piece
  };
  std::map<int, std::shared_ptr<const Ready>> of;   ///< by bone
};

namespace finishing {

/// A part to be compared.
struct Solid {
  int bone = 0;
  std::shared_ptr<const ReadyParts::Ready> part;
  std::optional<BoxTree> fresh{};   ///< triangles that an earlier certificate does not know; empty: it knows all

  const BoxTree& tree() const { return part->tree; }
};

/// By bone.
/// @param before   parts that are ready
/// @param compare  whether triangles that are not among those are wanted
std::vector<Solid> solids_of(const std::vector<const Part*>& parts, const ReadyParts& before, bool compare);

/// Whether a piece of one lies within the other; `into_b` takes A's frame to B's.
bool holds_a_piece(const Solid& b, const Solid& a, const Eigen::Isometry3d& into_b);

}  // namespace finishing
}  // namespace transformables
