// The artist's edits of a segmentation (paper, section 5, "User interaction" and "Editing skin meshes"), kept as data: a list that is
// replayed whenever the rooms before have run again.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "character/character.h"
#include "embedding/embedding.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables {

enum class EditKind {
  kRemove,      ///< the bone has no skin: its neighbours fill the place. Finishing leaves it its bare skeleton
  kInhibit,     ///< the bone's skin does not grow beyond its skeletal shape and `reach`; its neighbours fill what it had
  kKeepWhole,   ///< a painted region ends in one part: of those that hold it now, the one that holds most of it
  kAssign,      ///< a painted region ends in the bone's part
  kMoveSeam,    ///< the interface of two bones' parts meets the target's surface elsewhere (Eqs. 13 to 16)
};

struct Edit {
  EditKind kind = EditKind::kKeepWhole;
  std::string bone;                                          ///< name in the Character; not for kKeepWhole
  std::string other;                                         ///< kMoveSeam: the bone on the seam's other side
  std::string name;                                          ///< what the artist calls the region, for messages
  double reach = 0;                                          ///< kInhibit: thickness beyond the skeletal shape, target units
  std::vector<std::array<Eigen::Vector3d, 3>> painted;       ///< kKeepWhole, kAssign: triangles of the target's surface, target frame
  std::vector<Eigen::Vector3d> from, to;                     ///< kMoveSeam: where points of the seam (seams.h) were, and where they are to be: as many, in
                                                             ///< order, target frame, on the surface. Points near the moved ones that stay belong to it, too
};

/// What became of the edits: a line for each thing that the artist should know. Empty: all was done as wished.
using EditReport = std::vector<std::string>;

/// The segmentation with the edits replayed on it: removals first, then inhibitions, painted regions and seams, each kind in the list's
/// order. The result is again a tiling. Samples whose owner an edit chose are pinned, with a way to their bone's core, and inhibited bones
/// are flagged, so that later rooms respect both. Painted regions reach as deep as the nearest surface is painted, to half the
/// region's width.
///
/// An edit that makes no sense any more is left out, and told: its bone is gone or without a skin, its region is not on the target, it would
/// cut another part in two, or the seam that it moved is not there any more. A bone's skeleton stays its own: regions go round it, which is told where it shows.
/// The result is the same for any number of threads.
/// @throws InvalidInput when the segmentation belongs to other data, or an edit holds numbers that are not finite, a negative reach,
///         or lists of different lengths
Segmentation edited(const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
                    const std::vector<Edit>& edits, EditReport* report = nullptr, int threads = 0);

}  // namespace transformables
