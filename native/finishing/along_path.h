// All pairs of parts that can meet, move by move.
#pragma once

#include <utility>
#include <vector>

#include "finishing/carve.h"
#include "finishing/motion.h"
#include "finishing/sweep.h"

namespace transformables::finishing {

inline constexpr double kWindow = 0.6;     ///< steps: at least one sample is as near to any surface

/// A place between two parts tells nothing that a nearer one does not tell better, when it is further than this from one of them.
inline double window_of(const Lattice& lattice, double gap) { return gap / 2 + kWindow * lattice.step(); }

/// Pairs that can come near each other in a move, in order.
std::vector<std::pair<int, int>> near_pairs(const MoveMotion& motion, const std::vector<PartField>& parts, double reach);

std::vector<Bricks> all_bricks(const std::vector<PartField>& parts, double reach);

/// Calls f(move index, its motion, pairs that can meet) along the path.
template <class F>
void for_each_move(const Scene& scene, const std::vector<PartField>& parts, double reach, const Progress& progress, const char* note, F&& f) {
  const auto states = states_of(scene.path, scene.embedding.pose.angles);
  for (std::size_t m = 0; m < scene.path.moves.size(); ++m) {
    progress(double(m) / scene.path.moves.size(), note);
    const MoveMotion motion(scene.character, scene.embedding, scene.segmentation, scene.path.moves[m], states[m], parts,
                            scene.options, scene.lattice.cover);
    f(m, motion, near_pairs(motion, parts, reach));
  }
}

}  // namespace transformables::finishing
