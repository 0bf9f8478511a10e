#include "segmentation/surfaces.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "segmentation/lattice.h"
#include "segmentation/tiling.h"

namespace transformables::segmentation_inner {
namespace {

constexpr int kMargin = 4;            // samples around a part in its box
constexpr int kReach = 3;             // samples around a doubtful one that are fitted anew
constexpr int kFits = 60;             // iterations of the fit
constexpr int kPolishes = 6;          // diffusion steps: about one sample's width in all
constexpr double kContinuation = 4.5; // steps that level sets go on outside the target

// What all bones' level sets are rebuilt against.
struct Surroundings {
  const Target& target;
  const std::vector<std::int16_t>& owner;
  const std::vector<char>& inside;
  const std::vector<char>& doubtful;
  const std::vector<ShellSample>& shell;
};

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

// The face neighbours of a sample that are inside the target.
struct InsideNeighbours {
  std::array<std::uint32_t, 6> index;
  int count = 0;
};

// One bone's level set while it is rebuilt, in steps, over its box.
class Rebuild {
 public:
  Rebuild(const Surroundings& around, int bone, const Eigen::Vector3i& first, const GridShape& box)
      : around_(around), first_(first), phi_(box, kBand), dirty_(box.count(), 0), global_(box.count()), inside_(box.count()), own_(box.count()) {
    for_cells(box, [&](std::size_t i, const Eigen::Vector3i& c) {
      global_[i] = around.target.distance.shape.index(first + c);
      inside_[i] = around.inside[global_[i]];
      own_[i] = around.owner[global_[i]] == bone;
    });
  }

  Grid<float> run(const Grid<float>& before) {
    take(before);
    find_dirty();
    if (!fitted_.empty()) {
      start_fit();
      for (int k = 0; k < kFits; ++k) fit();
    }
    for (std::size_t i = 0; i < phi_.values.size(); ++i)
      if (inside_[i]) phi_[i] = right_side(i, phi_[i], kLeast);
    continue_outside();
    for (float& v : phi_.values) v *= float(phi_.shape.step);
    return std::move(phi_);
  }

 private:
  float right_side(std::size_t i, float v, float least) const {
    return own_[i] ? std::clamp(v, -kBand, -least) : std::clamp(v, least, kBand);
  }

  void take(const Grid<float>& before);
  void find_dirty();
  void start_fit();
  void fit();
  void continue_outside();

  const Surroundings& around_;
  Eigen::Vector3i first_;
  Grid<float> phi_;
  std::vector<char> dirty_;
  std::vector<std::size_t> global_;                        // of each sample of the box, its index in the target's grid
  std::vector<char> inside_, own_;
  std::vector<std::size_t> fitted_;
  std::vector<InsideNeighbours> beside_;                   // of each fitted one
  std::vector<float> bend_, next_;
};

// Old values where there are any; elsewhere far on the side that the owner says.
void Rebuild::take(const Grid<float>& before) {
  const double step = phi_.shape.step;
  const Eigen::Vector3i shift = before.values.empty() ? Eigen::Vector3i::Zero().eval() : before.shape.nearest(phi_.shape.origin);
  for_cells(phi_.shape, [&](std::size_t i, const Eigen::Vector3i& c) {
    if (!before.values.empty() && before.shape.contains(c + shift))
      phi_[i] = float(before.at(c + shift) / step);
    else
      phi_[i] = own_[i] ? -kBand : kBand;
  });
}

void Rebuild::find_dirty() {
  for (std::size_t i = 0; i < phi_.values.size(); ++i) {
    if (!inside_[i]) continue;
    const bool wrong = own_[i] ? phi_[i] > kLeast : phi_[i] < -kLeast;
    const bool doubted = !around_.doubtful.empty() && around_.doubtful[global_[i]];
    if (wrong || doubted) dirty_[i] = 1, fitted_.push_back(i);
  }
  std::size_t begin = 0;
  for (int ring = 0; ring < kReach; ++ring) {
    const std::size_t end = fitted_.size();
    for (; begin < end; ++begin)
      for_neighbours(phi_.shape, fitted_[begin], [&](std::size_t n) {
        if (!dirty_[n] && inside_[n]) dirty_[n] = 1, fitted_.push_back(n);
      });
  }
  std::sort(fitted_.begin(), fitted_.end());
}

// First guess: the number of steps to the nearest sample of the other side, unless the old value can stand.
void Rebuild::start_fit() {
  std::vector<int> layer(phi_.values.size(), 0);
  std::vector<std::size_t> front;
  for (std::size_t i : fitted_) {
    bool beside = false;
    for_neighbours(phi_.shape, i, [&](std::size_t n) { beside |= inside_[n] && own_[n] != own_[i]; });
    if (beside) layer[i] = 1, front.push_back(i);
  }
  for (std::size_t k = 0; k < front.size(); ++k)
    for_neighbours(phi_.shape, front[k], [&](std::size_t n) {
      if (dirty_[n] && layer[n] == 0) layer[n] = layer[front[k]] + 1, front.push_back(n);
    });
  for (std::size_t i : fitted_) {
    const float guess = layer[i] > 0 ? std::min(float(layer[i]) - 0.5f, kBand) : kBand;
    const bool stands = own_[i] == (phi_[i] < 0) && std::abs(phi_[i]) < guess + 0.5f &&
                        !(!around_.doubtful.empty() && around_.doubtful[global_[i]]);
    if (!stands) phi_[i] = own_[i] ? -guess : guess;
  }
  bend_.assign(phi_.values.size(), 0);
  next_ = phi_.values;
  for (std::size_t i : fitted_) {
    InsideNeighbours& beside = beside_.emplace_back();
    for_neighbours(phi_.shape, i, [&](std::size_t n) {
      if (inside_[n]) beside.index[beside.count++] = std::uint32_t(n);
    });
  }
}

// A step down the bending energy (the Laplacian squared) with every sample held on its owner's side, after Lempitsky's
// smooth surfaces from binary volumes (2010).
void Rebuild::fit() {
  const auto deviation = [&](const std::vector<float>& f, std::size_t k) {
    const InsideNeighbours& beside = beside_[k];
    float sum = 0;
    for (int n = 0; n < beside.count; ++n) sum += f[beside.index[n]];
    return beside.count > 0 ? sum / float(beside.count) - f[fitted_[k]] : 0.f;
  };
  for (std::size_t k = 0; k < fitted_.size(); ++k) bend_[fitted_[k]] = deviation(phi_.values, k);
  for (std::size_t k = 0; k < fitted_.size(); ++k) {
    const std::size_t i = fitted_[k];
    next_[i] = right_side(i, phi_[i] + 0.5f * bend_[i] - 0.3f * deviation(bend_, k), 4 * kLeast);
  }
  for (std::size_t i : fitted_) phi_[i] = next_[i];
}

// Each outside sample from its neighbours nearer to the target, weighted as the target's normal runs: constant along normals.
void Rebuild::continue_outside() {
  const Grid<float>& d = around_.target.distance;
  const Eigen::Vector3i end = first_ + phi_.shape.size;
  std::vector<char> known(phi_.values.size(), 0);
  for (std::size_t i = 0; i < phi_.values.size(); ++i) {
    known[i] = inside_[i];
    if (!known[i]) phi_[i] = kBand;
  }
  for (const auto& [g, c] : around_.shell) {
    if ((c.array() < first_.array()).any() || (c.array() >= end.array()).any()) continue;
    const std::size_t i = phi_.shape.index(c - first_);
    const float here = d[g];
    float sum = 0, weight = 0;
    for_neighbours(phi_.shape, i, [&](std::size_t n) {
      if (!known[n]) return;
      const float w = here - d[global_[n]];
      if (w > 0) sum += w * phi_[n], weight += w;
    });
    if (weight > 0) phi_[i] = sum / weight, known[i] = 1;
  }
}

// Diffusion of one level set where it is near its zero; neighbours outside the target do not count.
void diffuse(const Target& target, const std::vector<char>& inside, const std::vector<char>& where, Grid<float>& phi) {
  if (phi.values.empty()) return;
  const Eigen::Vector3i first = target.distance.shape.nearest(phi.shape.origin);
  const float near = float(2 * phi.shape.step);
  std::vector<char> in(phi.values.size());
  std::vector<std::size_t> band;
  for_cells(phi.shape, [&](std::size_t i, const Eigen::Vector3i& c) {
    const std::size_t g = target.distance.shape.index(c + first);
    in[i] = inside[g];
    if (in[i] && (where.empty() || where[g]) && std::abs(phi[i]) < near) band.push_back(i);
  });
  std::vector<float> next(band.size());
  for (int k = 0; k < kPolishes; ++k) {
    for (std::size_t b = 0; b < band.size(); ++b) {
      float sum = 0;
      int count = 0;
      for_neighbours(phi.shape, band[b], [&](std::size_t n) {
        if (in[n]) sum += phi[n], ++count;
      });
      next[b] = count > 0 ? 0.5f * (phi[band[b]] + sum / float(count)) : phi[band[b]];
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
  for (int ring = 0; ring < kReach; ++ring)
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

void Surfaces::settle_tiling(Segmentation& segmentation, const std::vector<std::int16_t>& core, std::vector<char> bones, int threads) const {
  tile(segmentation, core, bones);
  settle(segmentation, {}, threads, bones);
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

void Surfaces::settle(Segmentation& segmentation, const std::vector<char>& doubtful, int threads, const std::vector<char>& which) const {
  const GridShape& shape = segmentation.shape;
  const Surroundings around{target_, segmentation.owner, inside_, doubtful, shell_};
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
      Rebuild rebuild(around, b, first, {end - first, shape.position(first), shape.step});
      segmentation.phi[b] = rebuild.run(segmentation.phi[b]);
    });
  });
}

}  // namespace transformables::segmentation_inner
