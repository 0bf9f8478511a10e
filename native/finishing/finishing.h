// Finishing: from level sets and a path to meshes that can be held (paper, sections 6 and 7).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "character/character.h"
#include "common/mesh.h"
#include "common/progress.h"
#include "embedding/embedding.h"
#include "finishing/certificate.h"
#include "finishing/part.h"
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
  bool exact_surface = true;    ///< the target's own triangles outside, cut exactly; false: all surfaces from level sets
  bool hinges = true;           ///< a pin, a clevis and a tongue at joints of one axis, where there is room; false: balls in sockets
  double least_share = 0.35;    ///< of the clearance, that the proof of the motion asks for; 0: only that nothing touches
  int threads = 0;
};

struct Parts {
  std::vector<Part> parts;                 ///< only bones that have one, by bone
  Certificate certificate;                 ///< of the path, on the parts' own triangles; empty for a path without moves
  std::shared_ptr<const ReadyParts> ready; ///< parts as the proof left them, for another; null: there was none
  std::vector<Collision> collisions;       ///< what is left where there is no proof, measured on samples; empty when it holds
  double minimum_clearance = 0;            ///< over the motion, target units: what is proved, or where there is no proof, what samples show
  double carved_volume_pct = 0;            ///< of the target's volume
  double filled_volume_pct = 0;            ///< of the target's volume, by the parts' meshes
  std::vector<int> pinned;                 ///< bones whose joint with their parent has a pin
  std::vector<std::string> warnings;       ///< crumbs dropped, thin places; one sentence each
};

/// Clearance, carving along the path, one connected piece a bone, union with the skeletal mesh, surface extraction, checks, and the
/// proof that the parts stay apart. Carving works on sampled fields, the proof on the meshes: pairs for which it fails are set further
/// apart, a little more each time, and carved again.
/// @throws InvalidInput, Cancelled
Parts finish(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
             const FoldPath& path, const FinishingOptions& options, const Progress& progress);

/// What is wrong with a mesh as a printable solid; all false or zero is what finish() promises for its parts.
struct MeshCheck {
  bool open = false, non_manifold = false, self_intersecting = false, inside_out = false;
  int extra_pieces = 0;
  bool good() const { return !open && !non_manifold && !self_intersecting && !inside_out && extra_pieces == 0; }
};
/// @param simple  the mesh is known not to meet itself: that, which takes longest, is not looked at again
MeshCheck check(const TriangleMesh& mesh, bool simple = false);

/// The surface where a sampled field is 0, as a closed manifold mesh without self-intersections (each piece is a part of a convex
/// body's border, and stays in its cube of samples); negative is inside; the field must be positive all around the border.
/// @throws InvalidInput when it is not.
TriangleMesh isosurface(const Grid<float>& field);

}  // namespace transformables
