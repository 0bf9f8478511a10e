#include "folding/smoothing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "folding/path_collisions.h"

namespace transformables::folding {
namespace {

constexpr int kRounds = 4;
constexpr float kSigma = 1.7f;   // samples: surroundings are weighed by a Gaussian of this width
constexpr int kRadius = 3;       // samples: and cut off here
constexpr float kMargin = 1.02f; // a sample changes hands only for so much more weight, lest it goes to and fro
constexpr int kChecks = 6;       // times that changes are tried without those that failed before

struct Offset {
  Eigen::Vector3i by;
  float weight;
};

std::vector<Offset> surroundings() {
  std::vector<Offset> all;
  for (int k = -kRadius; k <= kRadius; ++k)
    for (int j = -kRadius; j <= kRadius; ++j)
      for (int i = -kRadius; i <= kRadius; ++i) {
        const float r2 = float(i * i + j * j + k * k);
        if (r2 <= float(kRadius * kRadius) + 1) all.push_back({{i, j, k}, std::exp(-r2 / (2 * kSigma * kSigma))});
      }
  return all;
}

class Smoothing {
 public:
  Smoothing(const Design& design, const std::vector<std::int16_t>& owner, const std::vector<std::int16_t>& core, const std::vector<SampledMove>& moves,
            float tolerance)
      : owner_(owner), design_(design), shape_(design.segmentation.shape), core_(core), around_(surroundings()), present_(present_bones()),
        collisions_(design, present_, moves, tolerance) {
    tbb::parallel_for(0, design.bones(), [&](int b) { collisions_.set_part(owner_, b); });
  }

  bool round();
  std::vector<std::int16_t> owner_;

 private:
  std::vector<char> present_bones() const {
    std::vector<char> present(design_.bones(), 0);
    for (const std::size_t s : design_.target.inside) present[owner_[s]] = 1;
    return present;
  }
  std::int16_t wished(std::size_t s, std::vector<float>& weight) const;
  bool beside_another(std::size_t s) const;
  bool beside(std::size_t s, int bone) const;
  std::vector<std::uint32_t> change_all();
  std::vector<std::uint32_t> colliding(const std::vector<std::uint32_t>& samples) const;
  void refresh(const std::vector<char>& parts);

  const Design& design_;
  const GridShape& shape_;
  const std::vector<std::int16_t>& core_;
  const std::vector<Offset> around_;
  const std::vector<char> present_;
  PathCollisions collisions_;
  std::vector<std::int16_t> before_;  // owners at the start of the round
};

/// The owner of most of a sample's surroundings.
std::int16_t Smoothing::wished(std::size_t s, std::vector<float>& weight) const {
  const Eigen::Vector3i c = shape_.cell(s);
  std::fill(weight.begin(), weight.end(), 0.0f);
  for (const Offset& o : around_) {
    const Eigen::Vector3i n = c + o.by;
    if (!shape_.contains(n)) continue;
    const int bone = owner_[shape_.index(n)];
    if (bone >= 0) weight[bone] += o.weight;
  }
  const auto most = std::max_element(weight.begin(), weight.end());
  return *most > kMargin * weight[owner_[s]] ? std::int16_t(most - weight.begin()) : owner_[s];
}

bool Smoothing::beside_another(std::size_t s) const {
  const Eigen::Vector3i c = shape_.cell(s);
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const Eigen::Vector3i n = c + Eigen::Vector3i(i, j, k);
        if (!shape_.contains(n)) continue;
        const int bone = owner_[shape_.index(n)];
        if (bone >= 0 && bone != owner_[s]) return true;
      }
  return false;
}

bool Smoothing::beside(std::size_t s, int bone) const {
  const Eigen::Vector3i c = shape_.cell(s);
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      Eigen::Vector3i n = c;
      n[axis] += side;
      if (shape_.contains(n) && owner_[shape_.index(n)] == bone) return true;
    }
  return false;
}

/// Gives every sample to whom it should go; returns those that changed.
std::vector<std::uint32_t> Smoothing::change_all() {
  const auto& inside = design_.target.inside;
  std::vector<std::int16_t> wish(inside.size(), -1);
  constexpr std::size_t kChunk = 1024;
  tbb::parallel_for(std::size_t(0), (inside.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    std::vector<float> weight(design_.bones());
    for (std::size_t i = chunk * kChunk; i < std::min(inside.size(), (chunk + 1) * kChunk); ++i) {
      const std::size_t s = inside[i];
      if (core_[s] >= 0 || !beside_another(s)) continue;
      const std::int16_t bone = wished(s, weight);
      if (bone != owner_[s] && beside(s, bone) && design_.segmentation.may_grow(bone)) wish[i] = bone;
    }
  });
  before_ = owner_;
  std::vector<std::uint32_t> changed;
  for (std::size_t i = 0; i < inside.size(); ++i)
    if (wish[i] >= 0) owner_[inside[i]] = wish[i], changed.push_back(std::uint32_t(inside[i]));
  return changed;
}

void Smoothing::refresh(const std::vector<char>& parts) {
  tbb::parallel_for(0, design_.bones(), [&](int b) {
    if (parts[b]) collisions_.set_part(owner_, b);
  });
}

std::vector<std::uint32_t> Smoothing::colliding(const std::vector<std::uint32_t>& samples) const {
  std::vector<std::vector<std::uint32_t>> of(design_.bones());
  for (const std::uint32_t s : samples) of[owner_[s]].push_back(s);
  std::vector<std::uint32_t> result;
  for (int bone = 0; bone < design_.bones(); ++bone) {
    const std::vector<int> found = collisions_.hits(of[bone], bone, 1);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] > 0) result.push_back(of[bone][i]);
  }
  return result;
}

/// All changes are made at once, and those that collide taken back. That can make others collide, so what is left is tried again
/// until all passes; whether anything changed.
bool Smoothing::round() {
  std::vector<std::uint32_t> kept = change_all();
  std::vector<char> touched(design_.bones(), 0);
  for (const std::uint32_t s : kept) touched[owner_[s]] = touched[before_[s]] = 1;
  for (int check = 0; !kept.empty(); ++check) {
    refresh(touched);
    const std::vector<std::uint32_t> failed = check < kChecks ? colliding(kept) : kept;
    if (failed.empty()) break;
    std::fill(touched.begin(), touched.end(), 0);
    for (const std::uint32_t s : failed) touched[owner_[s]] = touched[before_[s]] = 1, owner_[s] = before_[s];
    std::erase_if(kept, [&](std::uint32_t s) { return owner_[s] == before_[s]; });
    if (kept.empty()) refresh(touched);
  }
  return !kept.empty();
}

}  // namespace

std::vector<std::int16_t> smoothed_owners(const Design& design, const std::vector<std::int16_t>& owner, const std::vector<std::int16_t>& core,
                                          const std::vector<SampledMove>& moves, float tolerance) {
  Smoothing smoothing(design, owner, core, moves, tolerance);
  for (int k = 0; k < kRounds; ++k)
    if (!smoothing.round()) break;
  return std::move(smoothing.owner_);
}

}  // namespace transformables::folding
