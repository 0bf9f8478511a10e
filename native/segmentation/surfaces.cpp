#include "segmentation/surfaces.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "segmentation/lattice.h"
#include "segmentation/rebuild.h"
#include "segmentation/tiling.h"

namespace transformables::segmentation_inner {
namespace {

constexpr int kMargin = 4;            // samples around a part in its box
constexpr int kPolishes = 6;          // diffusion steps: about one sample's width in all
constexpr double kContinuation = 4.5; // steps that level sets go on outside the target

std::vector<ShellSample> shell_of(const Target& target, const std::vector<char>& inside) {
  std::vector<ShellSample> shell;
  const double reach = kContinuation * target.distance.shape.step;
  for_cells(target.distance.shape, [&](std::size_t i, const Eigen::Vector3i& c) {
    if (!inside[i] && target.distance[i] < reach) shell.push_back({i, c});
  });
  std::sort(shell.begin(), shell.end(), [&](const ShellSample& a, const ShellSample& b) {
    return target.distance[a.index] != target.distance[b.index] ? target.distance[a.index] < target.distance[b.index] : a.index < b.index;
  });
  return shell;
}

// Diffusion of one level set where it is near its zero; neighbours outside the target do not count.
void diffuse(const Target& target, const std::vector<char>& inside, const std::vector<char>& where, Grid<float>& phi) {
  if (phi.values.empty()) return;
  const Eigen::Vector3i first = target.distance.shape.nearest(phi.shape.origin);
  const float near = float(2 * phi.shape.step);
  std::vector<char> in(phi.values.size());
  std::vector<std::uint32_t> band;
  for_cells(phi.shape, [&](std::size_t i, const Eigen::Vector3i& c) {
    const std::size_t g = target.distance.shape.index(c + first);
    in[i] = inside[g];
    if (in[i] && (where.empty() || where[g]) && std::abs(phi[i]) < near) band.push_back(std::uint32_t(i));
  });
  std::vector<std::array<std::uint32_t, 6>> beside(band.size());   // of each sample, itself in place of neighbours that do not count
  std::vector<float> share(band.size()), next(band.size());
  for (std::size_t b = 0; b < band.size(); ++b) {
    beside[b].fill(band[b]);
    int count = 0;
    for_neighbours(phi.shape, band[b], [&](std::size_t n) {
      if (in[n]) beside[b][count++] = std::uint32_t(n);
    });
    share[b] = count > 0 ? 0.5f / float(count) : 0;
  }
  for (int k = 0; k < kPolishes; ++k) {
    for (std::size_t b = 0; b < band.size(); ++b) {
      const float here = phi[band[b]];
      float sum = 0;
      for (const std::uint32_t n : beside[b]) sum += phi[n] - here;
      next[b] = here + share[b] * sum;
    }
    for (std::size_t b = 0; b < band.size(); ++b) phi[band[b]] = next[b];
  }
}

std::vector<char> growing(const Segmentation& segmentation) {
  std::vector<char> flags;
  for (std::size_t b = 0; b < segmentation.phi.size() && !segmentation.inhibited.empty(); ++b) flags.push_back(segmentation.may_grow(int(b)));
  return flags;
}

}  // namespace

Surfaces::Surfaces(const Target& target) : target_(target), inside_(inside_flags(target)), shell_(shell_of(target, inside_)) {}

void Surfaces::polish(std::vector<std::int16_t>& owner, std::vector<Grid<float>>& phi, const std::vector<std::int16_t>& core,
                      const std::vector<char>& where, int threads) const {
  const GridShape& shape = target_.distance.shape;
  tbb::task_arena arena(arena_size(threads));
  arena.execute([&] { tbb::parallel_for(0, int(phi.size()), [&](int b) { diffuse(target_, inside_, where, phi[b]); }); });
  std::vector<float> least(shape.count(), std::numeric_limits<float>::infinity());
  for (std::size_t bone = 0; bone < phi.size(); ++bone) {
    if (phi[bone].values.empty()) continue;
    const Eigen::Vector3i first = shape.nearest(phi[bone].shape.origin);
    for_cells(phi[bone].shape, [&](std::size_t i, const Eigen::Vector3i& c) {
      const std::size_t g = shape.index(c + first);
      if (owner[g] < 0 || core[g] >= 0 || !(where.empty() || where[g]) || phi[bone][i] >= least[g]) return;
      least[g] = phi[bone][i];
      owner[g] = std::int16_t(bone);
    });
  }
}

std::vector<char> Surfaces::changed(const Segmentation& segmentation) const {
  const GridShape& shape = segmentation.shape;
  std::vector<char> flags(shape.count(), 0);
  std::vector<std::size_t> found;
  for (std::size_t i : target_.inside) {
    const Grid<float>& phi = segmentation.phi[segmentation.owner[i]];
    const Eigen::Vector3i c = phi.values.empty() ? Eigen::Vector3i::Zero().eval() : Eigen::Vector3i(shape.cell(i) - shape.nearest(phi.shape.origin));
    if (phi.values.empty() || !phi.shape.contains(c) || phi.at(c) > 0) flags[i] = 1, found.push_back(i);
  }
  std::size_t begin = 0;
  for (int ring = 0; ring < kRefitReach; ++ring)
    for (const std::size_t end = found.size(); begin < end; ++begin)
      for_neighbours(shape, found[begin], [&](std::size_t n) {
        if (inside_[n] && !flags[n]) flags[n] = 1, found.push_back(n);
      });
  return flags;
}

bool Surfaces::tile(Segmentation& segmentation, const std::vector<std::int16_t>& core, std::vector<char>& bones) const {
  const std::vector<std::int16_t> before = segmentation.owner;
  make_tiling(target_, core, int(bones.size()), segmentation.owner, growing(segmentation));
  bool any = false;
  for (std::size_t i : target_.inside)
    if (before[i] != segmentation.owner[i]) bones[std::size_t(before[i])] = bones[std::size_t(segmentation.owner[i])] = any = true;
  return any;
}

void Surfaces::settle_tiling(Segmentation& segmentation, const std::vector<std::int16_t>& core, std::vector<char> bones, int threads, float reach) const {
  tile(segmentation, core, bones);
  settle(segmentation, {}, threads, bones, reach);
}

void Surfaces::retile(Segmentation& segmentation, const std::vector<std::int16_t>& core, int threads) const {
  const int bones = int(segmentation.phi.size());
  make_tiling(target_, core, bones, segmentation.owner, growing(segmentation));
  const std::vector<char> where = changed(segmentation);
  if (std::find(where.begin(), where.end(), 1) == where.end()) return;
  settle(segmentation, {}, threads);
  polish(segmentation.owner, segmentation.phi, core, where, threads);
  make_tiling(target_, core, bones, segmentation.owner, growing(segmentation));
  settle(segmentation, {}, threads);
}

void Surfaces::settle(Segmentation& segmentation, const std::vector<char>& doubtful, int threads, const std::vector<char>& which, float reach) const {
  const GridShape& shape = segmentation.shape;
  const Surroundings around{target_, segmentation.owner, inside_, doubtful, shell_, reach};
  const int bones = int(segmentation.phi.size());
  std::vector<Eigen::Vector3i> low(bones, shape.size), high(bones, Eigen::Vector3i::Constant(-1));
  for (std::size_t i : target_.inside) {
    const int b = segmentation.owner[i];
    low[b] = low[b].cwiseMin(shape.cell(i)), high[b] = high[b].cwiseMax(shape.cell(i));
  }
  tbb::task_arena arena(arena_size(threads));
  arena.execute([&] {
    tbb::parallel_for(0, bones, [&](int b) {
      if (!which.empty() && !which[std::size_t(b)]) return;
      if (high[b].x() < 0) {
        segmentation.phi[b] = {};
        return;
      }
      const Eigen::Vector3i first = (low[b].array() - kMargin).max(0);
      const Eigen::Vector3i end = (high[b].array() + kMargin + 1).min(shape.size.array());
      segmentation.phi[b] = rebuilt(segmentation.phi[b], around, b, first, {end - first, shape.position(first), shape.step});
    });
  });
}

}  // namespace transformables::segmentation_inner
