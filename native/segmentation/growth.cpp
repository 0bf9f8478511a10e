#include "segmentation/growth.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>

#include "segmentation/blocks.h"
#include "segmentation/level_set.h"

namespace transformables::segmentation_inner {
namespace {

constexpr float kAdvance = 0.5f;        // v0 dt in steps: FACTS.md, 0.9 breaks
constexpr float kCurvatureBand = 1.5f;  // curvature means something only near the front
constexpr int kSettling = 4;            // steps that a filled block still works, so that its interfaces come to rest
constexpr int kPatience = 24;           // steps without a new claim that end growth
constexpr float kTieBias = 0.02f;       // steps; breaks ties of joined bones
constexpr float kCoreDepth = 0.3f;      // steps; a bone's own samples are at least so deep inside it

class Growth {
 public:
  Growth(const Character& character, const Target& target, const Skeleton& skeleton, const SegmentationOptions& options)
      : target_(target), curvature_(float(options.curvature)), limit_(float(options.curvature_limit)), blocks_(target), awake_(blocks_.all.size(), 1) {
    for (std::size_t b = 0; b < character.bones.size(); ++b) seed(skeleton, int(b));
    tbb::parallel_for(0, int(blocks_.all.size()), [&](int b) { settle_seeds(character, skeleton, b); });
  }

  void run(const Progress& progress) {
    const std::size_t total = target_.inside.size();
    std::size_t best = total + 1;
    for (int waited = 0; waited < kPatience; ++waited) {
      list_awake();
      if (active_.empty()) return;
      step();
      const std::size_t left = unclaimed();
      if (left < best) best = left, waited = 0;
      progress(double(total - left) / double(total), "growing skins");
    }
  }

  Grown result(int bones) { return blocks_.read(bones); }

 private:
  void seed(const Skeleton& skeleton, int bone);
  void settle_seeds(const Character& character, const Skeleton& skeleton, int block);
  void list_awake();
  void step();
  void advance(int block);
  void redistance(int block);
  void project(Block& block);
  void open_neighbours();
  std::size_t unclaimed() const {
    std::size_t sum = 0;
    for (const Block& b : blocks_.all) sum += b.unclaimed;
    return sum;
  }

  const Target& target_;
  float curvature_, limit_;
  Blocks blocks_;
  std::vector<char> awake_;
  std::vector<int> active_;
};

// Layers of a bone in all blocks near its skeletal shape.
void Growth::seed(const Skeleton& skeleton, int bone) {
  const GridShape& shape = blocks_.shape;
  Eigen::AlignedBox3d box;
  for (const Segment& s : skeleton.shapes[bone].capsules)
    for (const Eigen::Vector3d& p : {s.a, s.b}) box.extend(skeleton.frames[bone] * p);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(skeleton.shapes[bone].radius + kBand * shape.step);
  const auto block_at = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3i(shape.nearest(p).cwiseMax(0).cwiseMin((shape.size.array() - 1).matrix()) / kSide);
  };
  const Eigen::Vector3i low = block_at(box.min() - margin), high = block_at(box.max() + margin);
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const int block = blocks_.index(x, y, z);
        if (blocks_.all[block].inside_count > 0) blocks_.add(block, std::int16_t(bone));
      }
  for (std::size_t i : target_.inside)
    if (skeleton.core[i] == bone) {
      const Eigen::Vector3i c = shape.cell(i) / kSide;
      blocks_.add(blocks_.index(c.x(), c.y(), c.z()), std::int16_t(bone));
    }
}

// Away from its joint, along its skeleton: the mean direction of a bone's own segments.
Eigen::Vector3d leaving(const Skeleton& skeleton, int bone, const Eigen::Vector3d& joint) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Segment& s : skeleton.shapes[bone].capsules)
    sum += 0.5 * (skeleton.frames[bone] * s.a + skeleton.frames[bone] * s.b) - joint;
  return sum.norm() > 0 ? Eigen::Vector3d(sum.normalized()) : sum;
}

// Positive on the child's side of the plane that halves the angle at a joint.
double bisector_side(const Skeleton& skeleton, int child, int parent, const Eigen::Vector3d& p) {
  const Eigen::Vector3d joint = skeleton.frames[child].translation();
  return (p - joint).dot(leaving(skeleton, child, joint) - leaving(skeleton, parent, joint));
}

void Growth::settle_seeds(const Character& character, const Skeleton& skeleton, int b) {
  Block& block = blocks_.all[b];
  const double step = blocks_.shape.step, half = (kSide - 1) / 2.0;
  const Eigen::Vector3d middle = blocks_.shape.origin + step * ((kSide * blocks_.cell(b)).cast<double>().array() + half).matrix();
  std::vector<char> far;   // of each layer: the bone is beyond the band from all of the block
  for (const auto& layer : block.layers) far.push_back(distance_to_bone(skeleton, layer->bone, middle) > step * (kBand + std::sqrt(3.0) * half));
  for (int k = 0; k < kCells && !block.layers.empty(); ++k) {
    const std::size_t i = blocks_.sample(b, k);
    if (i == blocks_.shape.count()) continue;
    const Eigen::Vector3d p = blocks_.shape.position(i);
    for (std::size_t n = 0; n < block.layers.size(); ++n) {
      const auto& layer = block.layers[n];
      float v = far[n] ? kBand : std::clamp(float(distance_to_bone(skeleton, layer->bone, p) / step), -kBand, kBand);
      if (skeleton.core[i] == layer->bone)
        v = std::min(v, -kCoreDepth);
      else if (skeleton.core[i] >= 0)
        v = std::max(v, kCoreDepth);
      layer->phi[k] = v;
    }
    for (auto& layer : block.layers) {
      const int parent = character.bones[layer->bone].parent;
      Layer* other = parent < 0 ? nullptr : block.layer(parent);
      if (!other || std::abs(layer->phi[k] - other->phi[k]) > 1e-3f) continue;
      const double side = bisector_side(skeleton, layer->bone, parent, p);
      layer->phi[k] += side > 0 ? -kTieBias : kTieBias;
    }
  }
  project(block);
}

void Growth::list_awake() {
  active_.clear();
  for (std::size_t b = 0; b < blocks_.all.size(); ++b) {
    const Block& block = blocks_.all[b];
    const bool awake = block.inside_count > 0 && !block.layers.empty() && (block.unclaimed > 0 || block.quiet < kSettling);
    if (awake) active_.push_back(int(b));
    else if (awake_[b])
      for (const auto& layer : block.layers) layer->next = layer->phi;
    awake_[b] = awake;
  }
}

void Growth::step() {
  tbb::parallel_for(std::size_t(0), active_.size(), [&](std::size_t k) { advance(active_[k]); });
  tbb::parallel_for(std::size_t(0), active_.size(), [&](std::size_t k) { redistance(active_[k]); });
  open_neighbours();
}

// At each sample of a block, the smallest level set and the second.
struct Nearest {
  Samples least = Samples::Constant(kBand), second = least;

  explicit Nearest(const Block& block) {
    for (const auto& layer : block.layers) {
      const Eigen::Map<const Samples> phi(layer->phi.data());
      second = second.min(phi.max(least));
      least = least.min(phi);
    }
  }
};

// Calls `visit` with the first cell of each row of a block, and the row's stencil in the block's halo.
template <class Visit>
void for_rows(const float* halo, Visit visit) {
  for (int k = 0; k < kCells; k += kSide) visit(k, Stencil<kSide>{halo + halo_index(k), kHaloSide, kHaloSide * kHaloSide});
}

// Eq. 7, explicit. The speed is capped by half of what is left between two fronts, so that they meet and stop.
void Growth::advance(int b) {
  Block& block = blocks_.all[b];
  const Nearest nearest(block);
  float halo[kHaloCells];
  for (auto& layer : block.layers) {
    gather(*layer, &Layer::phi, halo);
    for_rows(halo, [&](int first, const Stencil<kSide>& at) {
      const Row<kSide> phi = at.at(0), far = phi.abs();
      Row<kSide> speed = Row<kSide>::Ones(), next = phi;
      if (far.minCoeff() < kCurvatureBand) {
        const Row<kSide> kappa = curvature(at), sharp = kappa - kappa.max(-limit_).min(limit_);   // Eq. 6
        for (int k = 0; k < kSide; ++k) speed[k] -= far[k] < kCurvatureBand ? curvature_ * sharp[k] : 0.f;
      }
      if (far.minCoeff() <= kBand - 0.5f) {
        Row<kSide> gap;
        for (int k = 0; k < kSide; ++k) gap[k] = phi[k] + (phi[k] > nearest.least[first + k] ? nearest.least[first + k] : nearest.second[first + k]);
        const Row<kSide> step = (kAdvance * speed * growing_slope(at)).min(0.5f * gap.max(0.f));
        for (int k = 0; k < kSide; ++k) next[k] -= far[k] > kBand - 0.5f ? 0.f : step[k];
      }
      Eigen::Map<Row<kSide>>(&layer->next[first]) = next;
    });
  }
}

// True only where the redistancing equation leaves a row at the band's edge: the slope is no more than that of a distance.
bool stays_far(const Stencil<kSide>& at) {
  constexpr float kNear = kBand - 0.57f;   // three such differences make a slope of less than 1
  if (at.at(0).minCoeff() < kBand) return false;
  Row<kSide> least = at.at(-1).min(at.at(1));
  for (const int offset : {at.row, at.slice}) least = least.min(at.at(-offset)).min(at.at(offset));
  return least.minCoeff() >= kNear;
}

// One step of the redistancing equation, then projection.
void Growth::redistance(int b) {
  Block& block = blocks_.all[b];
  float halo[kHaloCells];
  for (auto& layer : block.layers) {
    gather(*layer, &Layer::next, halo);
    for_rows(halo, [&](int first, const Stencil<kSide>& at) {
      if (stays_far(at)) {
        Eigen::Map<Row<kSide>>(&layer->phi[first]).setConstant(kBand);
        return;
      }
      const Row<kSide> phi = at.at(0), beside = beside_zero(at);
      Row<kSide> side, v;
      for (int k = 0; k < kSide; ++k) side[k] = phi[k] > 0 ? 1.f : -1.f;
      v = phi - 0.5f * side * (distance_slope(at, side) - 1);
      if (beside.minCoeff() <= 0) {
        const Row<kSide> near = phi + 0.5f * (distance_beside_zero(at) - phi);
        for (int k = 0; k < kSide; ++k) v[k] = beside[k] <= 0 ? near[k] : v[k];
      }
      Eigen::Map<Row<kSide>>(&layer->phi[first]) = v.max(-kBand).min(kBand);
    });
  }
  project(block);
}

// Flags of the faces of a block that a front is near.
std::uint8_t faces_near(const Samples& phi) {
  constexpr int kSlice = kSide * kSide;
  Row<kSide> along = Row<kSide>::Constant(kBand), low = along, high = along;
  for (int k = 0; k < kCells; k += kSide) along = along.min(phi.segment<kSide>(k));
  for (int k = 0; k < kCells; k += kSlice) low = low.min(phi.segment<kSide>(k)), high = high.min(phi.segment<kSide>(k + kSlice - kSide));
  const float least[6] = {along[0], along[kSide - 1], low.minCoeff(), high.minCoeff(), phi.head<kSlice>().minCoeff(), phi.tail<kSlice>().minCoeff()};
  std::uint8_t faces = 0;
  for (int f = 0; f < 6; ++f)
    if (least[f] < kBand - 1) faces = std::uint8_t(faces | (1 << f));
  return faces;
}

// Where level sets overlap, every one of them is shifted by the mean of the two smallest (Losasso et al. 2006); the target's own wins against all.
void Growth::project(Block& block) {
  const auto [least, second] = Nearest(block);
  const Samples shift = 0.5f * (least + second).min(0.f);
  const Eigen::Map<const Samples> limit(block.limit.data());
  for (auto& layer : block.layers) {
    Samples phi = Eigen::Map<const Samples>(layer->phi.data());
    for (int k = 0; k < kCells; ++k) phi[k] -= phi[k] + least[k] < 0 ? shift[k] : 0.f;
    phi = phi.max(limit);
    Eigen::Map<Samples>(layer->phi.data()) = phi;
    layer->faces = faces_near(phi);
  }
  block.unclaimed = 0;
  for (int k = 0; k < kCells; ++k) {
    const float nearest = std::max(least[k] - shift[k], limit[k]);
    block.unclaimed += block.inside[k] && nearest > 0 && nearest + second[k] - shift[k] > kClosed;
  }
  block.quiet = block.unclaimed > 0 ? 0 : block.quiet + 1;
}

// A front that comes near a face of its block goes on in the next one.
void Growth::open_neighbours() {
  static const Eigen::Vector3i kSteps[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  for (int b : active_)
    for (const auto& layer : blocks_.all[b].layers)
      for (int f = 0; f < 6; ++f) {
        const Eigen::Vector3i c = blocks_.cell(b) + kSteps[f];
        if (!(layer->faces & (1 << f)) || !blocks_.contains(c)) continue;
        const int next = blocks_.index(c.x(), c.y(), c.z());
        if (blocks_.all[next].inside_count > 0 && blocks_.add(next, layer->bone)) blocks_.all[next].quiet = 0;
      }
}

}  // namespace

Grown grown(const Character& character, const Target& target, const Skeleton& skeleton, const SegmentationOptions& options,
            const Progress& progress) {
  Grown result;
  tbb::task_arena arena(arena_size(options.threads));
  arena.execute([&] {
    Growth growth(character, target, skeleton, options);
    growth.run(progress);
    result = growth.result(int(character.bones.size()));
  });
  return result;
}

}  // namespace transformables::segmentation_inner
