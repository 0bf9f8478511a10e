// A proof that finished parts stay apart at every time of a fold, not only at samples (DESIGN section 3, "Folding").
//
// It is made of intervals. Over each, the parts' own triangles are kept apart by planes: a plane that separates two boxes or
// triangles at the middle of the interval still does at its ends, by what the joints' rates and lever arms allow
// (Schwarzer, Saha and Latombe 2005, refined by direction: sliding along a gap costs nothing to first order).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "character/character.h"
#include "common/progress.h"
#include "embedding/embedding.h"
#include "finishing/part.h"
#include "folding/folding.h"

namespace transformables {

struct CertificateOptions {
  double enough = 0.001;       ///< parts further apart than this are not looked at more closely, target units
  double least = 1e-5;         ///< parts that come nearer than this count as touching, target units
  double tolerance = 0.25;     ///< a pair's proven gap is at most this share under its true one, where that is under `enough`
  long steps = 6'000'000;     ///< boxes and triangles compared for one pair in one move, at most: bounds the time without a clock
  bool to_the_end = true;      ///< false: a proof that fails anywhere is given up there; its certificate does not hold, and says nothing else
  int threads = 0;             ///< 0: all cores. The result does not depend on it.
  std::vector<std::pair<int, int>> pairs{};  ///< bones of the pairs that are looked at, the lesser first; empty: all
};

/// From t0 to t1 of a move (0 to 1, hinges turning at constant rates) two parts are at least `bound` apart.
struct CertifiedInterval {
  std::size_t move = 0;        ///< index into FoldPath::moves
  int bone_a = 0, bone_b = 0;  ///< a < b
  double t0 = 0, t1 = 1;
  double bound = 0;            ///< target units, positive
};

/// A place for which there is no proof. A pair that touches in several places of a move has several.
struct Uncertified {
  enum class Reason { kTouching, kInside, kUnresolved };
  std::size_t move = 0;
  int bone_a = 0, bone_b = 0;
  double fraction = 0;         ///< of the move
  double distance = 0;         ///< of the parts there, at most, target units
  Reason reason = Reason::kTouching;
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero(), on_b = Eigen::Vector3d::Zero();  ///< kTouching: where, each in its bone's frame
};

struct Certificate {
  bool holds = false;                        ///< no two parts come nearer than `gap`, ever
  double gap = 0;                            ///< least bound of all intervals, target units; 0 unless `holds`
  std::vector<CertifiedInterval> intervals;  ///< by move, pair, time
  std::vector<Uncertified> open;             ///< by move and pair; empty when it holds
  long steps = 0;                            ///< boxes and triangles that were compared
};

/// Proves as much as can be proved. Every pair of parts has its intervals in move 0 (a path without moves is taken as one that
/// stands still); in a later move those pairs that move against each other in it: the others stand as they stood before.
/// @param parts  finish()'s, or any closed meshes in bone frames, one a bone at most
/// @throws InvalidInput when the parts, the embedding or the path do not fit the character, or an option is out of range
/// @throws Cancelled
Certificate certify(const std::vector<Part>& parts, const Character& character, const Embedding& embedding, const FoldPath& path,
                    const CertificateOptions& options, const Progress& progress);

/// Parts made ready to be compared (box trees), for proofs to come.
class ReadyParts;

/// Proves the same design again and again while some of its parts change: what was found out about triangles that are still there, to the last
/// bit, is taken over, and only new ones are compared. Cutting leaves most triangles of a part as they were.
class Prover {
 public:
  /// Refers to the character, the embedding and the path while it lives. @throws InvalidInput as certify() does
  /// @param ready  another prover's, which saves time where parts are the same; may be null
  Prover(const Character& character, const Embedding& embedding, const FoldPath& path, const CertificateOptions& options,
         std::shared_ptr<const ReadyParts> ready = nullptr);
  ~Prover();

  /// @throws as the function of the same name
  Certificate certify(const std::vector<Part>& parts, const Progress& progress);
  /// Of the parts that were looked at last.
  std::shared_ptr<const ReadyParts> ready() const;

 private:
  class Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace transformables
