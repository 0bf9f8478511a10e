#include "segmentation/blocks.h"

#include <tbb/parallel_for.h>

namespace transformables::segmentation_inner {
namespace {

// Replaces every level set by half its difference from the least of the others, and names the owners.
void half_differences(Blocks& blocks, int b, std::vector<std::int16_t>& owner) {
  Block& block = blocks.all[b];
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
    if (first && block.inside[k] && (least <= 0 || least + second <= kClosed)) owner[blocks.sample(b, k)] = first->bone;
  }
}

}  // namespace

Blocks::Blocks(const Target& target) {
  const std::vector<char> inside = inside_flags(target);
  shape = target.distance.shape;
  counts = (shape.size.array() + kSide - 1) / kSide;
  all.resize(counts.prod());
  const float per_step = float(1 / shape.step);
  tbb::parallel_for(0, int(all.size()), [&](int b) {
    Block& block = all[b];
    for (int k = 0; k < kCells; ++k) {
      const std::size_t i = sample(b, k);
      block.inside[k] = i < inside.size() && inside[i];
      block.limit[k] = i < inside.size() ? std::clamp(target.distance[i] * per_step, -kBand, kBand) : kBand;
      if (!block.inside[k]) block.limit[k] = std::max(block.limit[k], 0.01f);
      block.inside_count += block.inside[k];
    }
    block.unclaimed = block.inside_count;
  });
}

bool Blocks::add(int b, std::int16_t bone) {
  Block& block = all[std::size_t(b)];
  const auto at = std::lower_bound(block.bones.begin(), block.bones.end(), bone);
  if (at != block.bones.end() && *at == bone) return false;
  const auto place = block.layers.begin() + (at - block.bones.begin());
  Layer* added = block.layers.insert(place, std::make_unique<Layer>(bone))->get();
  block.bones.insert(at, bone);
  for (std::size_t k = 0; k < added->around.size(); ++k) {
    const Eigen::Vector3i c = cell(b) + Eigen::Vector3i(int(k) % 3 - 1, int(k) / 3 % 3 - 1, int(k) / 9 - 1);
    if (!contains(c)) continue;
    Layer* other = all[std::size_t(index(c.x(), c.y(), c.z()))].layer(bone);
    added->around[k] = other;
    if (other) other->around[added->around.size() - 1 - k] = added;
  }
  return true;
}

Grown Blocks::read(int bones) {
  Grown grown{std::vector<std::int16_t>(shape.count(), -1), std::vector<Grid<float>>(bones)};
  tbb::parallel_for(0, int(all.size()), [&](int b) { half_differences(*this, b, grown.owner); });
  std::vector<std::vector<int>> where(bones);
  for (std::size_t b = 0; b < all.size(); ++b)
    for (const auto& layer : all[b].layers) where[layer->bone].push_back(int(b));
  tbb::parallel_for(0, bones, [&](int bone) {
    if (where[bone].empty()) return;
    Eigen::Vector3i low = counts, high = Eigen::Vector3i::Zero();
    for (int b : where[bone]) low = low.cwiseMin(cell(b)), high = high.cwiseMax(cell(b));
    const Eigen::Vector3i first = kSide * low, end = (kSide * (high.array() + 1)).matrix().cwiseMin(shape.size);
    Grid<float>& grid = grown.phi[bone];
    grid = Grid<float>({end - first, shape.position(first), shape.step}, float(kBand * shape.step));
    for (int b : where[bone]) {
      const Layer& layer = *all[b].layer(bone);
      for (int k = 0; k < kCells; ++k) {
        const Eigen::Vector3i c = kSide * cell(b) + Eigen::Vector3i(k % kSide, k / kSide % kSide, k / (kSide * kSide)) - first;
        if (grid.shape.contains(c)) grid.at(c) = float(layer.next[k] * shape.step);
      }
    }
  });
  return grown;
}

void gather(const Layer& layer, std::array<float, kCells> Layer::*values, float* out) {
  static const Layer kNone(-1);
  const float* from[27];
  for (std::size_t k = 0; k < layer.around.size(); ++k) from[k] = ((layer.around[k] ? layer.around[k] : &kNone)->*values).data();
  for (int z = -1; z <= kSide; ++z)
    for (int y = -1; y <= kSide; ++y) {
      const int row = 9 * (z < 0 ? 0 : z < kSide ? 1 : 2) + 3 * (y < 0 ? 0 : y < kSide ? 1 : 2);
      const int offset = ((z & 7) * kSide + (y & 7)) * kSide;
      float* line = out + ((z + 1) * kHaloSide + y + 1) * kHaloSide;
      line[0] = from[row][offset + kSide - 1];
      Eigen::Map<Row<kSide>>(line + 1) = Eigen::Map<const Row<kSide>>(from[row + 1] + offset);
      line[kSide + 1] = from[row + 2][offset];
    }
}

}  // namespace transformables::segmentation_inner
