#include "segmentation/rebuild.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "segmentation/bending.h"
#include "segmentation/lattice.h"

namespace transformables::segmentation_inner {
namespace {

constexpr int kFits = 60;             // iterations of the fit

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
      guess();
      fit();
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
  void guess();
  void fit();
  void continue_outside();

  const Surroundings& around_;
  Eigen::Vector3i first_;
  Grid<float> phi_;
  std::vector<char> dirty_;
  std::vector<std::size_t> global_;                        // of each sample of the box, its index in the target's grid
  std::vector<char> inside_, own_;
  std::vector<std::size_t> fitted_;
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
  for (int ring = 0; ring < kRefitReach; ++ring) {
    const std::size_t end = fitted_.size();
    for (; begin < end; ++begin)
      for_neighbours(phi_.shape, fitted_[begin], [&](std::size_t n) {
        if (!dirty_[n] && inside_[n]) dirty_[n] = 1, fitted_.push_back(n);
      });
  }
  std::sort(fitted_.begin(), fitted_.end());
}

// First guess: the number of steps to the nearest sample of the other side, unless the old value can stand.
void Rebuild::guess() {
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
}

// Down the bending energy with every sample held on its owner's side, after Lempitsky's smooth surfaces from binary volumes (2010).
void Rebuild::fit() {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  Bending bending(fitted_.size());
  std::vector<std::uint32_t> place(phi_.values.size(), kNone);
  for (std::size_t k = 0; k < fitted_.size(); ++k) place[fitted_[k]] = std::uint32_t(k);
  for (std::size_t k = 0; k < fitted_.size(); ++k) {
    const std::size_t i = fitted_[k];
    std::array<std::uint32_t, 6> beside;
    int count = 0;
    for_neighbours(phi_.shape, i, [&](std::size_t n) {
      if (!inside_[n]) return;
      if (place[n] == kNone) place[n] = std::uint32_t(bending.add_still(phi_[n]));
      beside[std::size_t(count++)] = place[n];
    });
    bending.set(k, phi_[i], own_[i] ? -kBand : 4 * kLeast, own_[i] ? -4 * kLeast : kBand);
    bending.set_beside(k, beside, count);
  }
  for (int k = 0; k < kFits; ++k) bending.step();
  for (std::size_t k = 0; k < fitted_.size(); ++k) phi_[fitted_[k]] = bending[k];
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
    if (d[g] > around_.reach * float(phi_.shape.step)) break;   // the nearest come first
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

}  // namespace

Grid<float> rebuilt(const Grid<float>& before, const Surroundings& around, int bone, const Eigen::Vector3i& first, const GridShape& box) {
  return Rebuild(around, bone, first, box).run(before);
}

}  // namespace transformables::segmentation_inner
