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
constexpr float kClosed = 0.1f;         // a gap between two fronts, in steps, that counts as closed
constexpr float kCurvatureBand = 1.5f;  // curvature means something only near the front
constexpr int kSettling = 4;            // steps that a filled block still works, so that its interfaces come to rest
constexpr int kPatience = 24;           // steps without a new claim that end growth
constexpr float kTieBias = 0.02f;       // steps; breaks ties of joined bones
constexpr float kCoreDepth = 0.3f;      // steps; a bone's own samples are at least so deep inside it

class Growth {
 public:
  Growth(const Character& character, const Target& target, const Skeleton& skeleton, const SegmentationOptions& options)
      : target_(target), curvature_(float(options.curvature)), limit_(float(options.curvature_limit)) {
    make_blocks(inside_flags(target));
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

  Grown result(int bones);

 private:
  void make_blocks(const std::vector<char>& inside);
  void seed(const Skeleton& skeleton, int bone);
  void settle_seeds(const Character& character, const Skeleton& skeleton, int block);
  void list_awake();
  void step();
  void advance(int block);
  void redistance(int block);
  void project(Block& block);
  void open_neighbours();
  void half_differences(int block, std::vector<std::int16_t>& owner);
  std::size_t sample_of(int block, int cell) const;
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

// Index of a block's sample in the grid, or the grid's count for one beyond its border.
std::size_t Growth::sample_of(int block, int cell) const {
  const Eigen::Vector3i c = kSide * blocks_.cell(block) + Eigen::Vector3i(cell % kSide, cell / kSide % kSide, cell / (kSide * kSide));
  return blocks_.shape.contains(c) ? blocks_.shape.index(c) : blocks_.shape.count();
}

void Growth::make_blocks(const std::vector<char>& inside) {
  blocks_.shape = target_.distance.shape;
  blocks_.counts = (blocks_.shape.size.array() + kSide - 1) / kSide;
  blocks_.all.resize(blocks_.counts.prod());
  awake_.assign(blocks_.all.size(), 0);
  const float per_step = float(1 / blocks_.shape.step);
  tbb::parallel_for(0, int(blocks_.all.size()), [&](int b) {
    Block& block = blocks_.all[b];
    for (int k = 0; k < kCells; ++k) {
      const std::size_t i = sample_of(b, k);
      block.inside[k] = i < inside.size() && inside[i];
      block.limit[k] = i < inside.size() ? std::clamp(target_.distance[i] * per_step, -kBand, kBand) : kBand;
      if (!block.inside[k]) block.limit[k] = std::max(block.limit[k], 0.01f);
      block.inside_count += block.inside[k];
    }
    block.unclaimed = block.inside_count;
  });
}

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
        Block& block = blocks_.all[blocks_.index(x, y, z)];
        if (block.inside_count > 0) block.add(std::int16_t(bone));
      }
  for (std::size_t i : target_.inside)
    if (skeleton.core[i] == bone) {
      const Eigen::Vector3i c = shape.cell(i) / kSide;
      blocks_.all[blocks_.index(c.x(), c.y(), c.z())].add(std::int16_t(bone));
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
  const double step = blocks_.shape.step;
  for (int k = 0; k < kCells && !block.layers.empty(); ++k) {
    const std::size_t i = sample_of(b, k);
    if (i == blocks_.shape.count()) continue;
    const Eigen::Vector3d p = blocks_.shape.position(i);
    for (auto& layer : block.layers) {
      float v = std::clamp(float(distance_to_bone(skeleton, layer->bone, p) / step), -kBand, kBand);
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
    awake_[b] = block.inside_count > 0 && !block.layers.empty() && (block.unclaimed > 0 || block.quiet < kSettling);
    if (awake_[b]) active_.push_back(int(b));
  }
}

void Growth::step() {
  tbb::parallel_for(std::size_t(0), active_.size(), [&](std::size_t k) { advance(active_[k]); });
  tbb::parallel_for(std::size_t(0), active_.size(), [&](std::size_t k) { redistance(active_[k]); });
  open_neighbours();
}

// Eq. 7, explicit. The speed is capped by half of what is left between two fronts, so that they meet and stop.
void Growth::advance(int b) {
  Block& block = blocks_.all[b];
  std::array<float, kCells> least, second;
  least.fill(kBand), second.fill(kBand);
  for (const auto& layer : block.layers)
    for (int k = 0; k < kCells; ++k) {
      const float v = layer->phi[k];
      second[k] = std::min(second[k], std::max(v, least[k]));
      least[k] = std::min(least[k], v);
    }
  float halo[kHaloCells];
  for (auto& layer : block.layers) {
    blocks_.gather(b, layer->bone, nullptr, halo);
    for (int k = 0; k < kCells; ++k) {
      const float phi = layer->phi[k];
      layer->next[k] = phi;
      if (std::abs(phi) > kBand - 0.5f) continue;
      const Stencil at{halo + halo_index(k), 1, kHaloSide, kHaloSide * kHaloSide};
      float speed = 1;
      if (std::abs(phi) < kCurvatureBand) {
        const float kappa = curvature(at);
        speed -= curvature_ * std::copysign(std::max(std::abs(kappa) - limit_, 0.f), kappa);  // Eq. 6
      }
      const float gap = phi + (phi > least[k] ? least[k] : second[k]);
      layer->next[k] = phi - std::min(kAdvance * speed * growing_slope(at), 0.5f * std::max(gap, 0.f));
    }
  }
}

// One step of the redistancing equation, then projection.
void Growth::redistance(int b) {
  Block& block = blocks_.all[b];
  float halo[kHaloCells];
  for (auto& layer : block.layers) {
    blocks_.gather(b, layer->bone, &awake_, halo);
    for (int k = 0; k < kCells; ++k) {
      const Stencil at{halo + halo_index(k), 1, kHaloSide, kHaloSide * kHaloSide};
      const float phi = *at.p;
      float v;
      if (beside_zero(at))
        v = phi + 0.5f * (distance_beside_zero(at) - phi);
      else
        v = phi - 0.5f * std::copysign(1.f, phi) * (distance_slope(at) - 1);
      layer->phi[k] = std::clamp(v, -kBand, kBand);
    }
  }
  project(block);
}

// Where level sets overlap, every one of them is shifted by the mean of the two smallest (Losasso et al. 2006); the target's own wins against all.
void Growth::project(Block& block) {
  block.unclaimed = 0;
  for (int k = 0; k < kCells; ++k) {
    float least = kBand, second = kBand;
    for (const auto& layer : block.layers) {
      const float v = layer->phi[k];
      second = std::min(second, std::max(v, least));
      least = std::min(least, v);
    }
    const float shift = 0.5f * std::min(least + second, 0.f);
    for (auto& layer : block.layers) {
      float& v = layer->phi[k];
      if (v + least < 0 || v == least) v -= shift;
      v = std::max(v, block.limit[k]);
    }
    least = std::max(least - shift, block.limit[k]);
    block.unclaimed += block.inside[k] && least > 0 && least + second - shift > kClosed;
  }
  for (auto& layer : block.layers) {
    layer->faces = 0;
    for (int a = 0; a < kSide; ++a)
      for (int c = 0; c < kSide; ++c) {
        const int at[6] = {(a * kSide + c) * kSide, (a * kSide + c) * kSide + kSide - 1, a * kSide * kSide + c,
                           (a * kSide + kSide - 1) * kSide + c, a * kSide + c, (kSide - 1) * kSide * kSide + a * kSide + c};
        for (int f = 0; f < 6; ++f)
          if (layer->phi[at[f]] < kBand - 1) layer->faces = std::uint8_t(layer->faces | (1 << f));
      }
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
        Block& next = blocks_.all[blocks_.index(c.x(), c.y(), c.z())];
        if (next.inside_count > 0 && next.add(layer->bone)) next.quiet = 0;
      }
}

// Replaces every level set by half its difference from the least of the others, and names the owners.
void Growth::half_differences(int b, std::vector<std::int16_t>& owner) {
  Block& block = blocks_.all[b];
  for (int k = 0; k < kCells; ++k) {
    float least = kBand, second = kBand;
    const Layer* first = nullptr;
    for (const auto& layer : block.layers) {
      const float v = layer->phi[k];
      if (v < least) second = least, least = v, first = layer.get();
      else second = std::min(second, v);
    }
    // The target's surface cut this level set; its true value is the other's, turned round.
    if (first && least <= block.limit[k] + 1e-4f) least = std::min(least, -second);
    for (auto& layer : block.layers) {
      const bool is_first = layer.get() == first;
      layer->next[k] = 0.5f * ((is_first ? least : layer->phi[k]) - (is_first ? second : least));
    }
    if (first && block.inside[k] && (least <= 0 || least + second <= kClosed)) owner[sample_of(b, k)] = first->bone;
  }
}

Grown Growth::result(int bones) {
  Grown grown{std::vector<std::int16_t>(blocks_.shape.count(), -1), std::vector<Grid<float>>(bones)};
  tbb::parallel_for(0, int(blocks_.all.size()), [&](int b) { half_differences(b, grown.owner); });
  std::vector<std::vector<int>> where(bones);
  for (std::size_t b = 0; b < blocks_.all.size(); ++b)
    for (const auto& layer : blocks_.all[b].layers) where[layer->bone].push_back(int(b));
  tbb::parallel_for(0, bones, [&](int bone) {
    if (where[bone].empty()) return;
    Eigen::Vector3i low = blocks_.counts, high = Eigen::Vector3i::Zero();
    for (int b : where[bone]) low = low.cwiseMin(blocks_.cell(b)), high = high.cwiseMax(blocks_.cell(b));
    const Eigen::Vector3i first = kSide * low, end = (kSide * (high.array() + 1)).matrix().cwiseMin(blocks_.shape.size);
    Grid<float>& grid = grown.phi[bone];
    grid = Grid<float>({end - first, blocks_.shape.position(first), blocks_.shape.step}, float(kBand * blocks_.shape.step));
    for (int b : where[bone]) {
      const Layer& layer = *blocks_.all[b].layer(bone);
      for (int k = 0; k < kCells; ++k) {
        const Eigen::Vector3i c = kSide * blocks_.cell(b) + Eigen::Vector3i(k % kSide, k / kSide % kSide, k / (kSide * kSide)) - first;
        if (grid.shape.contains(c)) grid.at(c) = float(layer.next[k] * blocks_.shape.step);
      }
    }
  });
  return grown;
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
