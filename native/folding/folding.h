// Folding: in which order and how far the joints turn between object mode and character mode (paper, section 6).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "character/character.h"
#include "common/progress.h"
#include "embedding/embedding.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables {

/// One turn of one or more hinges, all others standing still; the hinges turn together, each at a constant rate.
struct Move {
  struct Turn {
    int angle = 0;                    ///< index into Pose::angles
    double from_rad = 0, to_rad = 0;
  };
  std::vector<Turn> turns;
};

/// Two parts that meet on the way.
struct Collision {
  int bone_a = 0, bone_b = 0;
  std::size_t move = 0;       ///< index into FoldPath::moves
  double fraction = 0;        ///< of the move, 0 to 1, where it is worst
  double volume = 0;          ///< cubic target units, there
  double swept = 0;           ///< what the two lose in this move when the one gives way that costs less: what carving would cost; 0: not known
  std::optional<Eigen::Vector3d> place{};   ///< where it is worst, on bone_a's part: bone_a's frame, target units
};

/// The way from object mode S_O to character mode S_R (all angles 0). Reversed, it is the fold.
struct FoldPath {
  std::vector<Move> moves;               ///< unfolding order
  std::vector<Collision> collisions;     ///< what is left colliding before carving, worst first
  double overlap_volume = 0;             ///< sum over moves of the volume swept through other parts, cubic target units
  bool cut_short = false;                ///< FoldingOptions::seconds ended the search before it was done
};

/// What a move costs.
enum class MoveCost {
  kSweptVolume,  ///< what would have to be carved: of each pair of parts the lesser loss when one lets the other pass; skeletons give nothing
  kNetOverlap,   ///< the paper's Eq. 11: overlap of a configuration, mean over the move
};

struct FoldingOptions {
  double largest_step_rad = 0.05;   ///< between sampled configurations of a move
  bool mirrored_together = true;    ///< in a symmetric embedding, the two hinges of a mirrored pair turn at once
  int threads = 0;                  ///< 0: all cores. The result does not depend on it.
  MoveCost cost = MoveCost::kSweptVolume;
  double tolerance_steps = 0.25;    ///< parts that tile touch everywhere: only what is deeper than this collides, in steps of the target's grid
  int beam_width = 24;              ///< plan(): states kept for each number of open joints
  int expansions = 3000;            ///< plan(): moves tried in all, at most; bounds the time without a clock
  int rounds = 5;                   ///< fold(): of planning and transfer
  bool round_off = true;            ///< fold(): smooths and rounds interfaces at the end; how much carving takes hardly depends on it
  double seconds = 0;               ///< plan(), fold(): after that long the best so far is taken, which then depends on the machine; 0: no limit
};

/// The paper's greedy order: starting from S_O, each time the joint (or mirrored pair) whose unfolding all the way collides least (Eq. 11,
/// sampled) is unfolded. @throws InvalidInput, Cancelled
FoldPath plan_greedy(const Segmentation& segmentation, const Character& character, const Target& target,
                     const Embedding& embedding, const FoldingOptions& options, const Progress& progress);

/// Greedy's order made better: a beam search over the orders, then moves taken earlier or later and joints turned half-way or aside,
/// within their limits, where that lets another pass. Never costs more than plan_greedy with the same options; the same
/// result for any number of threads.
/// @param start  a path found earlier for the same embedding, by the same options: the result is not worse than that, either
/// @throws InvalidInput, Cancelled
FoldPath plan(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
              const FoldingOptions& options, const Progress& progress, const FoldPath* start = nullptr);

/// `path` with its collisions and overlap measured on a segmentation. @throws InvalidInput
FoldPath measured(const FoldPath& path, const Segmentation& segmentation, const Character& character, const Target& target,
                  const Embedding& embedding, const FoldingOptions& options);

/// The ranges that a path asks of each hinge: for mesh transfer.
std::vector<JointRange> ranges_of(const FoldPath& path, const Character& character);
/// The straight ranges from the folded angle to 0, before any path is known.
std::vector<JointRange> straight_ranges(const Character& character, const Embedding& embedding);

/// What transfer_along did.
struct TransferAlongResult {
  double colliding_before = 0, colliding_after = 0;   ///< volume of all samples that ever meet another part, cubic target units
  double moved_volume = 0;                            ///< given to another part
  std::vector<std::size_t> yielding;                  ///< samples for which no owner is free of collisions: carve these first
};

/// Gives colliding material to the part it collides with, or to another that it touches and that can carry it without
/// colliding, as long as that lowers the overlap along the path: mesh transfer for every pair, not only joined ones.
/// The whole volume in object mode is unchanged; the result is a tiling. @throws InvalidInput, Cancelled
Segmentation transfer_along(const Segmentation& segmentation, const Character& character, const Target& target,
                            const Embedding& embedding, const FoldPath& path, const FoldingOptions& options, const Progress& progress,
                            TransferAlongResult* result = nullptr);

/// A path and the segmentation that goes with it.
struct Folding {
  FoldPath path;
  Segmentation segmentation;
  double carving_before = 0, carving_after = 0;   ///< what carving would take, rehearsed on samples, cubic target units
  std::vector<std::size_t> yielding;              ///< see TransferAlongResult
};

/// Plans and transfers in turn, as each makes room for the other, `rounds` times at most; the best that was met. Where all joints opening
/// together, in one move, or the paper's greedy order (Eq. 11) leaves less to carve, it is that. `carving_after` is never more than the
/// greedy order leaves to carve on the segmentation as it was given, each bone having its skeleton.
/// @throws InvalidInput, Cancelled
Folding fold(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
             const FoldingOptions& options, const Progress& progress);

/// All sampled configurations of a path, folded first, as angle vectors; the angles of neighbours differ by at most `largest_step_rad`.
struct PathSamples {
  std::vector<Eigen::VectorXd> angles;
  std::vector<std::size_t> move;   ///< which move each belongs to
};
/// @throws InvalidInput when the path does not fit the angles, or the step is not positive.
PathSamples sampled(const FoldPath& path, const Eigen::VectorXd& folded_angles, double largest_step_rad);

}  // namespace transformables
