// Segmentation: grow a skin for every bone until the skins tile the target (paper, section 5).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "character/character.h"
#include "common/grid.h"
#include "common/progress.h"
#include "embedding/embedding.h"
#include "target/target.h"

namespace transformables {

/// Level sets of all bones over the target's grid, in object mode (target frame).
///
/// Tiling: every inside sample has exactly one bone in `owner`; each bone's samples are one face-connected piece
/// that holds its skeleton. Part i is where phi[i] < phi[j] for all j and the target's distance is negative; the
/// interface of i and j is where phi[i] = phi[j], so that parts tile at any finer resolution, too.
struct Segmentation {
  GridShape shape;                             ///< that of target.distance
  std::vector<std::int16_t> owner;             ///< a bone for each inside sample, -1 outside
  std::vector<Grid<float>> phi;                ///< for each bone, over a box of the same lattice that holds its part with at least
                                               ///< 3 samples of margin (clipped to the grid); target units, negative inside,
                                               ///< near its interface a distance (clamped to +-4 steps). Empty for a bone without a part.
  std::vector<Eigen::Isometry3d> frames;       ///< each bone's frame in object mode, target frame
  std::vector<char> pinned{};                  ///< a flag for each sample: the artist chose its owner (edits.h), so transfer, folding and
                                               ///< smoothing leave it there. With its bone's core one connected piece. Empty: none
  std::vector<char> inhibited{};               ///< a flag for each bone: its part may lose material but takes none. Empty: none

  bool is_pinned(std::size_t sample) const { return !pinned.empty() && pinned[sample]; }
  bool may_grow(int bone) const { return inhibited.empty() || !inhibited[std::size_t(bone)]; }
};

struct SegmentationOptions {
  double speed = 1;               ///< v0 of Eq. 7, steps of growth a unit of time
  double curvature = 0.2;         ///< c of Eq. 7, in units of v0 * step
  double curvature_limit = 0.25;  ///< kappa_0 of Eq. 6, 1 / step: sharper features than this erode
  int threads = 0;                ///< 0: all cores. The result does not depend on it.
};

/// Grows level sets from the skeletal meshes by Eqs. 6 and 7 with projection until every inside voxel is claimed. Every bone gets its skeletal shape whole, at
/// 0.9 of its radius; where shapes meet, each sample goes to the bone in whose shape it lies deepest. The interface of two parts (where half the difference of their
/// level sets is zero) is nowhere sharper than `curvature_limit`, but at the skeletons' own samples and where a third part or the target's surface is a neighbour.
/// @throws InvalidInput when options are out of range; Infeasible when a bone lies wholly outside the target; Cancelled
Segmentation grow(const Character& character, const Target& target, const Embedding& embedding,
                  const SegmentationOptions& options, const Progress& progress);

/// A range of a hinge's angle that a joint must be able to pass without parent and child skins colliding.
struct JointRange {
  int bone = 0;      ///< the child
  int hinge = 0;     ///< which of its hinges (0 to 2)
  double from_rad = 0, to_rad = 0;
};

enum class TransferDirection { kLessVolume, kChildToParent, kParentToChild };

/// What is moved: Eqs. 8 to 10, or only the samples whose own way round the hinge meets the other part (single hinges
/// only), or of the two whichever changes less for what it mends.
enum class TransferMethod { kBetter, kCylinder, kExact };

struct TransferOptions {
  TransferDirection direction = TransferDirection::kLessVolume;
  std::map<int, TransferDirection> direction_of{};   ///< of these joints, by their child, instead
  TransferMethod method = TransferMethod::kBetter;
  int samples = 24;     ///< T' of Eq. 11: configurations tried across a range
  bool round_off = true;   ///< fits the interfaces of joints to fractions of a sample, and mends what that leaves; whose a sample is hardly depends on it
  int threads = 0;
};

struct TransferResult {
  int bone = 0;                ///< the child
  double radius = 0;           ///< R* of Eqs. 8 to 10, target units; 0: none was needed, or the exact alternative was taken
  bool child_to_parent = true;
  double moved_volume = 0;     ///< cubic target units
  double left_overlap = 0;     ///< Eq. 11 after the transfer, cubic target units (mean over samples)
};

/// Mesh transfer (Eqs. 8 to 11) at every joint, leaves first: a cylinder about the hinge's axis (a sphere for two or three hinges),
/// its radius by bisection, the result checked; then all joints are `rounded`. `ranges`: the angles each hinge must pass, others staying folded.
/// The result is again a tiling, and every bone keeps its own skeleton: where the skeleton of one bone of a joint sweeps through the
/// part of the other, transfer can't help, and `left_overlap` tells how much is left for carving. A joint is left as it
/// is when no transfer would mend more than it changes.
/// @throws InvalidInput when a range names no hinge or is not finite, a direction names a bone that does not exist or has no parent, or samples or threads
///         are out of range; Cancelled
Segmentation transfer(const Segmentation& segmentation, const Character& character, const Target& target,
                      const Embedding& embedding, const std::vector<JointRange>& ranges, const TransferOptions& options,
                      const Progress& progress, std::vector<TransferResult>* results = nullptr);

/// The interface of each joint's parent and child made to fit at all angles of its ranges, to a fraction of a sample: what slides along each
/// other becomes round about the hinge, each side giving where it is in the way by less. Moves little more than a sample; what collides
/// deeper stays, as do pinned samples and inhibited bones. The result is again a tiling.
/// @throws InvalidInput when a range names no hinge or is not finite, threads are out of range, or the segmentation is another character's or target's
Segmentation rounded(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                     const std::vector<JointRange>& ranges, int threads);

/// Makes `owner` a tiling again after it was changed: pieces that do not hold the bone's skeleton go to the neighbour they touch
/// most, unowned inside samples to the nearest bone; then phi is rebuilt near what changed, smooth interfaces kept.
Segmentation retiled(const Segmentation& segmentation, const Character& character, const Target& target,
                     const Embedding& embedding);

}  // namespace transformables
