// Finishing: from level sets and a path to meshes that can be held (paper, sections 6 and 7).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "character/character.h"
#include "common/mesh.h"
#include "common/progress.h"
#include "embedding/embedding.h"
#include "folding/folding.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables {

enum class Style { kSolid, kShell };

struct FinishingOptions {
  double clearance = 0.001;     ///< gap between neighbouring parts, target units (0.3 mm of 150 mm)
  Style style = Style::kSolid;
  double wall = 0.004;          ///< of shells, target units
  int refinement = 2;           ///< finer grid for the surfaces: samples a voxel edge
  double largest_step_rad = 0.05;
  /// The target's own triangles outside, cut exactly; false: all surfaces from level sets. Off: collisions and clearance are measured
  /// on the fields, which round the target's sharp edges off; its own edges may come nearer to each other in motion.
  bool exact_surface = false;
  int threads = 0;
};

/// A printable part, one rigid piece.
struct Part {
  int bone = 0;
  TriangleMesh mesh;            ///< bone frame, target units: closed, manifold, free of self-intersections, one piece, outward
  std::vector<std::int32_t> source;  ///< for each triangle the triangle of target.mesh that it is (a piece of); -1: an interface, or re-meshed
  double volume = 0;            ///< cubic target units
};

struct Parts {
  std::vector<Part> parts;                 ///< only bones that have one, by bone
  std::vector<Collision> collisions;       ///< of the finished parts, re-measured along the path; empty when all is well
  double minimum_clearance = 0;            ///< over the sampled motion, target units
  double carved_volume_pct = 0;            ///< of the target's volume
  double filled_volume_pct = 0;            ///< of the target's volume, by the parts' meshes
  std::vector<std::string> warnings;       ///< crumbs dropped, thin places; one sentence each
};

/// Clearance, carving along the path, one connected piece a bone, union with the skeletal mesh, surface extraction, checks.
/// @throws InvalidInput, Cancelled
Parts finish(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
             const FoldPath& path, const FinishingOptions& options, const Progress& progress);

/// What is wrong with a mesh as a printable solid; all false or zero is what finish() promises for its parts.
struct MeshCheck {
  bool open = false, non_manifold = false, self_intersecting = false, inside_out = false;
  int extra_pieces = 0;
  bool good() const { return !open && !non_manifold && !self_intersecting && !inside_out && extra_pieces == 0; }
};
MeshCheck check(const TriangleMesh& mesh);

/// The surface where a sampled field is 0, as a closed manifold mesh without self-intersections (marching tetrahedra: each
/// piece stays in its tetrahedron); negative is inside; the field must be positive all around the border.
/// @throws InvalidInput when it is not.
TriangleMesh isosurface(const Grid<float>& field);

}  // namespace transformables
