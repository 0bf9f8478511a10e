#include "finishing/refill.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "finishing/motion.h"
#include "finishing/sweep.h"
#include "finishing/topology.h"

namespace transformables::finishing {
namespace {

constexpr int kPasses = 2;           ///< a part grows by two samples at most in one
constexpr double kJoint = 1;         ///< radii of a joint's housing about it, into which nothing grows: it is the socket's
constexpr double kApart = 0.3;       ///< steps beyond the gap that new material keeps: distances on samples are of first order
constexpr float kEdge = 0.25f;       ///< see DistanceReader: new material follows the ways of edges closely
constexpr float kWorth = 0.05f;      ///< steps by which a sample's value must fall
constexpr float kDeep = -0.5f;       ///< steps: samples further inside have no surface beside them

struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

bool boxes_meet(const PartField& a, const PartField& b) {
  return ((a.corner + a.shape().size).array() > b.corner.array()).all() && ((b.corner + b.shape().size).array() > a.corner.array()).all();
}

/// One part that grows.
class Growing {
 public:
  /// @param tried  flags of samples that were looked at in an earlier pass: others have grown since, so there is nothing new to find
  /// @param joints  room about joints, which stays as it is
  Growing(const Scene& scene, PartField& part, const std::vector<Ball>& joints, std::vector<char>& tried, double gap)
      : scene_(scene), part_(part), joints_(joints), tried_(tried), gap_(float(gap)), step_(float(scene.lattice.step())), reach_(float(reach_of(scene.lattice, gap))),
        clear_(part.psi.values.size(), reach_), mask_(part.psi.values.size(), 0) {}

  /// Looks at the samples beside the part as they stand in object mode; false when none of them can be had.
  bool look(const std::vector<PartField>& parts) {
    // In object mode all parts end at the same surface, so only what is between them counts.
    std::vector<const PartField*> beside;
    for (const PartField& other : parts)
      if (&other != &part_ && boxes_meet(part_, other)) beside.push_back(&other);
    const GridShape& shape = part_.shape();
    tbb::parallel_for(0, shape.size.z(), [&](int k) {
      for (std::size_t n = shape.index(0, 0, k), end = shape.index(0, 0, k + 1); n < end; ++n) {
        if (tried_[n] || part_.bound(n) >= reach_ || part_.inner[n] < kDeep * step_) continue;
        tried_[n] = 1;
        const Eigen::Vector3i c = part_.corner + shape.cell(n);
        if (is_anothers(c) || at_a_joint(c)) continue;
        for (const PartField* other : beside)
          if (const Eigen::Vector3i q = c - other->corner; other->shape().contains(q)) clear_[n] = std::min(clear_[n], other->away.at(q).inner);
        mask_[n] = worth(n);
      }
    });
    bricks_ = bricks_of(part_, reach_, mask_);
    return !bricks_.samples.empty();
  }

  /// How near others come in a move; what can't be had any more is not looked at again. False when nothing is left.
  bool heed(const std::vector<const PartField*>& others, const MoveMotion& motion) {
    std::vector<Swept> all(others.size());
    std::vector<Matter> matters;
    for (const std::uint32_t n : bricks_.samples) matters.push_back({clear_[n], needed(n)});
    tbb::parallel_for(std::size_t(0), others.size(), [&](std::size_t o) {
      const PartField& other = *others[o];
      if (!PairConfigurations::can_meet(motion, part_, other, reach_)) return;
      all[o] = sweep(part_, bricks_, other, PairConfigurations(motion, part_, other), scene_.lattice.cover, reach_, kEdge, matters);
    });
    bool fewer = false;
    for (const Swept& swept : all)
      for (std::size_t n = 0; n < swept.least.size(); ++n) {
        const std::uint32_t at = bricks_.samples[n];
        clear_[at] = std::min(clear_[at], swept.least[n]);
        if (mask_[at] && !worth(at)) fewer = true, mask_[at] = 0;
      }
    if (fewer) bricks_ = bricks_of(part_, reach_, mask_);
    return !bricks_.samples.empty();
  }

  void grow() {
    for (const std::uint32_t n : bricks_.samples) {
      part_.inner[n] = gap_ - clear_[n];
      part_.uncarved[n] = std::min(part_.uncarved[n], part_.inner[n]);
      part_.psi[n] = std::max(part_.inner[n], part_.away[n].outer);
    }
    Grid<float> psi = part_.psi;
    keep_core_piece(psi, part_.core);
    adopt(part_, std::move(psi));
    refresh(part_);
  }

 private:
  /// How near others may come to a sample that is worth having.
  float needed(std::size_t n) const { return gap_ + kWorth * step_ - part_.inner[n]; }
  bool worth(std::size_t n) const { return clear_[n] > needed(n); }
  bool at_a_joint(const Eigen::Vector3i& c) const {
    const Eigen::Vector3d p = scene_.lattice.outer.shape.position(c);
    return std::any_of(joints_.begin(), joints_.end(), [&](const Ball& ball) { return (p - ball.centre).norm() < ball.radius; });
  }
  bool is_anothers(const Eigen::Vector3i& c) const {
    const Segmentation& s = scene_.segmentation;
    const Eigen::Vector3i near = s.shape.nearest(scene_.lattice.outer.shape.position(c));
    if (!s.shape.contains(near)) return false;
    const std::size_t sample = s.shape.index(near);
    return s.is_pinned(sample) && s.owner[sample] != part_.bone;
  }

  const Scene& scene_;
  PartField& part_;
  const std::vector<Ball>& joints_;
  std::vector<char>& tried_;
  const float gap_, step_, reach_;
  std::vector<float> clear_;   // how near others come to a sample that goes with the part
  std::vector<char> mask_;     // samples that can be had in object mode
  Bricks bricks_;              // the same
};

}  // namespace

void refill(const Scene& scene, std::vector<PartField>& parts, const Progress& progress) {
  const auto states = states_of(scene.path, scene.embedding.pose.angles);
  std::vector<MoveMotion> motions;
  for (std::size_t m = 0; m < scene.path.moves.size(); ++m)
    motions.emplace_back(scene.character, scene.embedding, scene.segmentation, scene.path.moves[m], states[m], parts, scene.options,
                         scene.lattice.cover);
  std::vector<char> there;
  for (const PartField& part : parts) there.push_back(inside_count(part.psi) > 0);
  std::vector<Ball> joints;
  for (std::size_t b = 0; b < parts.size(); ++b)
    if (const Bone& bone = scene.character.bones[b]; bone.parent >= 0)
      joints.push_back({scene.segmentation.frames[b].translation(), kJoint * bone.radius});
  const auto grows = [&](const PartField& part) {
    return there[std::size_t(part.bone)] && scene.segmentation.may_grow(part.bone) && !scene.segmentation.phi[part.bone].values.empty();
  };
  std::vector<std::vector<char>> tried;
  for (const PartField& part : parts) tried.emplace_back(part.psi.values.size(), 0);
  const std::size_t turns = kPasses * parts.size();
  for (std::size_t turn = 0; turn < turns; ++turn) {
    progress(double(turn) / double(turns), "filling what nothing passes");
    PartField& part = parts[turn % parts.size()];
    if (!grows(part)) continue;
    Growing growing(scene, part, joints, tried[turn % parts.size()], scene.lattice.gap + kApart * scene.lattice.step());
    if (!growing.look(parts)) continue;
    std::vector<const PartField*> others;
    for (const PartField& other : parts)
      if (&other != &part && there[std::size_t(other.bone)]) others.push_back(&other);
    if (std::all_of(motions.begin(), motions.end(), [&](const MoveMotion& motion) { return growing.heed(others, motion); })) growing.grow();
  }
}

}  // namespace transformables::finishing
