// Solids cut and joined exactly (CGAL corefinement): the target by a part's interfaces, a part by its hinges.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/mesh.h"

namespace transformables::finishing {

/// A solid whose triangles know where they come from.
struct SourcedMesh {
  TriangleMesh mesh;
  std::vector<std::int32_t> source;  ///< a triangle each: the target's triangle that it is (a piece of), or -1
};

/// A target that is ready to be cut, many times and from several threads at once.
class CuttableTarget {
 public:
  explicit CuttableTarget(const TriangleMesh& target);
  ~CuttableTarget();
  CuttableTarget(const CuttableTarget&) = delete;
  CuttableTarget& operator=(const CuttableTarget&) = delete;

  /// False for a mesh that is not closed and manifold.
  bool usable() const { return surface_ != nullptr; }

  /// What a closed simple cutter and the target have in common; its largest piece, cavities filled. Nothing when
  /// there is none, or it could not be computed as a manifold.
  std::optional<SourcedMesh> cut(const TriangleMesh& cutter) const;

 private:
  struct Surface;
  std::unique_ptr<Surface> surface_;
};

enum class Combination { kUnion, kDifference };

/// Two closed simple solids made one, or the second taken from the first, in one piece, cavities filled; the second's triangles have no
/// source. Nothing when it could not be computed as a manifold, or more than `most_dropped` (a volume) lies in pieces apart from the largest.
std::optional<SourcedMesh> combined(const SourcedMesh& first, const TriangleMesh& second, Combination how, double most_dropped);

/// Rounds a simple closed mesh, moved by `into`, to single precision as it will be in Blender, and mends what rounding broke: edges that became too short
/// are collapsed, flat caps flipped. False when the result still meets itself; when true, it was looked at all over and does not.
/// @param scale  target units for one Blender unit
bool round_and_tidy(SourcedMesh& part, const Eigen::Isometry3d& into, double scale);

/// The nearest length in target units that is a number of single precision in Blender units: rounded once more there, a mesh could meet itself.
/// Through memory, since GCC 12 at -O2 drops a conversion to float and back where it makes vectors of neighbouring numbers.
inline double rounded_to_float(double x, double scale) {
  const volatile float rounded = float(x / scale);
  return double(rounded) * scale;
}

}  // namespace transformables::finishing
