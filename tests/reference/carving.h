// Carving to the letter of the paper (section 6, after Garg et al. 2016): dense level sets, every sample against every
// configuration. Slow on purpose: the oracle for the production code and the baseline for its speed.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "character/character.h"
#include "common/grid.h"
#include "embedding/embedding.h"
#include "folding/folding.h"

namespace transformables::reference {

/// The parts in object mode, a bone each, all over one grid; target units, negative inside.
struct Solids {
  std::vector<Grid<float>> parts;   ///< skin and skeletal mesh in one
  std::vector<Grid<float>> cores;   ///< the skeletal meshes, which stay as they are
  Grid<float> worth;                ///< of each sample: the paper does not say which of two parts gives way; the one that loses less worth does
};

struct CarvingOptions {
  double gap = 0;             ///< what comes nearer than that is removed, target units
  double largest_motion = 0;  ///< that any sample makes between two configurations, target units, positive
};

/// For each sample within `a` the least value of `b` over some configurations (`a_to_b`: see level_set_collision); beyond a's
/// surface a large number.
Grid<float> swept(const Grid<float>& a, const Grid<float>& b, const std::vector<Eigen::Isometry3d>& a_to_b);

/// The configurations of a move, as displacements of all bones (see `displacements`), so many that no sample moves too far between two.
std::vector<std::vector<Eigen::Isometry3d>> configurations(const Character& character, const Embedding& embedding, const Move& move,
                                                           const Eigen::VectorXd& start, const Solids& solids, double largest_motion);

/// Move by move and pair by pair: of two parts that come too near, the one that loses less gives way to the other, all but its skeletal
/// mesh, phi = max(phi, gap - least of the other's phi); then the other gives way to that skeletal mesh. Skeletal meshes that meet are left so.
void carve(const Character& character, const Embedding& embedding, const FoldPath& path, const CarvingOptions& options, Solids& solids);

}  // namespace transformables::reference
