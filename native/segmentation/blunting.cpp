#include "segmentation/blunting.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "segmentation/lattice.h"
#include "segmentation/level_set.h"

namespace transformables::segmentation_inner {
namespace {

constexpr float kTime = 0.2f;        // of a step of the flow; more than a quarter is unstable
constexpr float kAim = 0.8f;         // of the threshold, so that what comes to rest, and is then kept off zero by kLeast, is below it
constexpr float kSharp = 0.97f;      // of the threshold: above that the flow sets in
constexpr int kSteps = 6;            // between two looks at what is still sharp
constexpr int kLooks = 24;
constexpr int kReach = 4;            // samples about a sharp one that move
constexpr int kPasses = 8;           // what moves between two parts may meet what moved between one of them and a third
constexpr int kTravel = 8;           // samples that an interface may go at a time
constexpr float kBeside = 2;         // steps: what is farther from the interface only keeps its distance
constexpr float kFlat = 0.3f;        // smaller slopes are ridges, where curvature means nothing: plain diffusion there
constexpr float kOpposed = 0.5f;     // steps: two level sets that differ by more from each other's negative are not a pair's, a third is near
constexpr int kMargin = 3;           // samples about a part in its box (segmentation.h)

using Offsets = std::array<std::ptrdiff_t, 27>;

Offsets offsets_of(const GridShape& shape) {
  Offsets offsets;
  for (int k = 0; k < 27; ++k) offsets[std::size_t(k)] = ((k / 9 - 1) * std::ptrdiff_t(shape.size.y()) + (k / 3 % 3 - 1)) * shape.size.x() + k % 3 - 1;
  return offsets;
}

// What all flows read.
struct Whole {
  const Segmentation& s;
  const Target& target;
  const std::vector<std::int16_t>& core;
  float threshold;
  Offsets offsets = offsets_of(s.shape);

  /// No third part and no outside sample is a neighbour.
  bool is_between(std::size_t i, int one, int other) const {
    return std::all_of(offsets.begin(), offsets.end(), [&](std::ptrdiff_t o) {
      const std::size_t n = std::size_t(std::ptrdiff_t(i) + o);
      return s.owner[n] == one || s.owner[n] == other;
    });
  }
  /// A bone's level set, in steps.
  float level(int bone, const Eigen::Vector3i& c) const {
    const Grid<float>& phi = s.phi[std::size_t(bone)];
    const Eigen::Vector3i local = c - s.shape.nearest(phi.shape.origin);
    return phi.shape.contains(local) ? std::clamp(phi.at(local) / float(s.shape.step), -kBand, kBand) : kBand;
  }
};

bool is_sharp(const float* around, float threshold) { return std::abs(curvature<1>({around + 13, 3, 9})[0]) > kSharp * threshold; }

// One pair's interface near its sharp places.
class Flow {
 public:
  Flow(const Whole& whole, int first, int second) : a(first), b(second), whole_(whole) {}

  /// Samples beside the interface where it is too sharp, in the target's grid.
  std::vector<std::size_t> sharp;
  int a, b;

  void run() {
    open();
    std::vector<std::size_t> here;
    for (std::size_t g : sharp) here.push_back(side_.shape.index(whole_.s.shape.cell(g) - first_));
    for (int look = 0; look < kLooks && !here.empty(); ++look) {
      find_moving(here);
      for (int k = 0; k < kSteps; ++k) step();
      here.clear();
      std::copy_if(seen_.begin(), seen_.end(), std::back_inserter(here), [&](std::size_t i) { return is_sharp_at(i); });
    }
  }

  /// Calls `visit` with the cell and the new half difference, in steps, of all that moved.
  template <class Visit>
  void for_changes(Visit visit) const {
    for (std::size_t i : changed_) visit(side_.shape.cell(i) + first_, kept(side_[i]));
  }

 private:
  static float kept(float v) { return v < 0 ? std::min(v, -kLeast) : std::max(v, kLeast); }
  std::size_t in_whole(std::size_t i) const { return whole_.s.shape.index(side_.shape.cell(i) + first_); }
  Stencil<1> at(std::size_t i) const { return {&side_[i], side_.shape.size.x(), side_.shape.size.x() * side_.shape.size.y()}; }
  void open();
  bool may_move(std::size_t i);
  void find_moving(const std::vector<std::size_t>& from);
  void step();
  void keep_distance();
  void take();
  float moved(const Stencil<1>& s) const;
  bool is_sharp_at(std::size_t i) const;

  enum State : char { kUnknown, kHeld, kFree };

  const Whole& whole_;
  Eigen::Vector3i first_;
  Grid<float> side_;                      // half the difference of the two level sets, in steps, over a box
  Offsets offsets_;
  std::vector<char> state_, marked_;
  std::vector<std::size_t> moving_;       // what moves at present
  std::vector<std::size_t> seen_;         // that, and what is beside it
  std::vector<std::size_t> changed_;      // all that ever moved
  std::vector<float> next_;               // of each moving one
};

void Flow::open() {
  const GridShape& shape = whole_.s.shape;
  Eigen::Vector3i low = shape.size, high = Eigen::Vector3i::Zero();
  for (std::size_t g : sharp) low = low.cwiseMin(shape.cell(g)), high = high.cwiseMax(shape.cell(g));
  first_ = (low.array() - (kReach + kTravel)).max(0);
  const Eigen::Vector3i end = (high.array() + kReach + kTravel + 1).min(shape.size.array());
  side_ = Grid<float>({end - first_, shape.position(first_), shape.step}, 0);
  offsets_ = offsets_of(side_.shape);
  for (const auto& [bone, half] : {std::pair(a, 0.5f), {b, -0.5f}}) {
    const Grid<float>& phi = whole_.s.phi[std::size_t(bone)];
    const Eigen::Vector3i of_box = shape.nearest(phi.shape.origin);
    const Eigen::Vector3i from = first_.cwiseMax(of_box), to = end.cwiseMin(of_box + phi.shape.size);
    for (float& v : side_.values) v += half * kBand;
    if ((from.array() >= to.array()).any()) continue;
    const float per_step = float(1 / shape.step);
    for (int z = from.z(); z < to.z(); ++z)
      for (int y = from.y(); y < to.y(); ++y) {
        float* row = &side_.at(Eigen::Vector3i(from.x(), y, z) - first_);
        const float* read = &phi.at(Eigen::Vector3i(from.x(), y, z) - of_box);
        for (int x = 0; x < to.x() - from.x(); ++x) row[x] += half * (std::clamp(read[x] * per_step, -kBand, kBand) - kBand);
      }
  }
  state_.assign(side_.values.size(), kUnknown);
  marked_.assign(side_.values.size(), 0);
}

bool Flow::may_move(std::size_t i) {
  if (state_[i] != kUnknown) return state_[i] == kFree;
  const Eigen::Vector3i local = side_.shape.cell(i), c = local + first_, last = side_.shape.size.array() - 1;
  const bool is_free = (local.array() > 0).all() && (local.array() < last.array()).all() && whole_.is_between(whole_.s.shape.index(c), a, b) &&
                       std::abs(whole_.level(a, c) + whole_.level(b, c)) < kOpposed;
  state_[i] = is_free ? kFree : kHeld;
  return is_free;
}

void Flow::find_moving(const std::vector<std::size_t>& from) {
  seen_.clear();
  const auto reach = [&](std::size_t i) {
    if (!marked_[i] && may_move(i)) marked_[i] = 1, seen_.push_back(i);
  };
  for (std::size_t i : from) reach(i);
  std::size_t begin = 0;
  for (int ring = 0; ring < kReach; ++ring)
    for (const std::size_t end = seen_.size(); begin < end; ++begin)
      for (const std::ptrdiff_t o : offsets_) reach(std::size_t(std::ptrdiff_t(seen_[begin]) + o));
  for (std::size_t i : seen_) marked_[i] = 0;
  moving_.assign(seen_.begin(), seen_.begin() + std::ptrdiff_t(begin));
  changed_.insert(changed_.end(), moving_.begin(), moving_.end());
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
}

// Eq. 7 without growth.
float Flow::moved(const Stencil<1>& s) const {
  const float here = *s.p;
  if (std::abs(here) > kBeside) return here;
  Eigen::Vector3f slope;
  float mean = 0;
  const int strides[3] = {1, s.row, s.slice};
  for (int axis = 0; axis < 3; ++axis) {
    const float below = s.p[-strides[axis]], above = s.p[strides[axis]];
    slope[axis] = 0.5f * (above - below), mean += (above + below) / 6;
  }
  if (slope.squaredNorm() < kFlat * kFlat) return here + 0.5f * (mean - here);
  const float kappa = curvature(s)[0], most = kAim * whole_.threshold;
  return here + kTime * (kappa - std::clamp(kappa, -most, most)) * slope.norm();
}

void Flow::take() {
  for (std::size_t k = 0; k < moving_.size(); ++k) {
    const std::int16_t of = whole_.core[in_whole(moving_[k])];
    const float v = std::clamp(next_[k], -kBand, kBand);
    side_[moving_[k]] = of == a ? std::min(v, -4 * kLeast) : of == b ? std::max(v, 4 * kLeast) : v;
  }
}

// A step of the flow, and one of redistancing, which leaves samples beside the interface alone.
void Flow::step() {
  next_.resize(moving_.size());
  for (std::size_t k = 0; k < moving_.size(); ++k) next_[k] = moved(at(moving_[k]));
  take();
  for (std::size_t k = 0; k < moving_.size(); ++k) {
    const Stencil<1> s = at(moving_[k]);
    const Row<1> side = Row<1>::Constant(*s.p > 0 ? 1.f : -1.f);
    next_[k] = beside_zero(s)[0] <= 0 ? *s.p : *s.p - 0.5f * side[0] * (distance_slope(s, side)[0] - 1);
  }
  take();
}

// Judged by the values that will be kept.
bool Flow::is_sharp_at(std::size_t i) const {
  if (beside_zero(at(i))[0] > 0 || whole_.core[in_whole(i)] >= 0) return false;
  float around[27];
  for (std::size_t k = 0; k < 27; ++k) around[k] = kept(side_[std::size_t(std::ptrdiff_t(i) + offsets_[k])]);
  return is_sharp(around, whole_.threshold);
}

// The part that a sample's part meets there when it may be too sharp there, else -1.
int met(const Whole& whole, std::size_t i) {
  const std::vector<std::int16_t>& owner = whole.s.owner;
  const int own = owner[i];
  int other = -1;
  for (const std::size_t k : {4, 10, 12, 14, 16, 22}) {
    const int of = owner[std::size_t(std::ptrdiff_t(i) + whole.offsets[k])];
    if (of != own) other = of;
  }
  return other >= 0 && whole.is_between(i, own, other) ? other : -1;
}

// Flows of all pairs with interfaces that are too sharp somewhere.
// @param where  flags of the samples that are looked at; empty: all
std::vector<Flow> flows_of(const Whole& whole, const std::vector<char>& where) {
  const Segmentation& s = whole.s;
  std::map<std::pair<int, int>, std::vector<std::size_t>> places;
  std::vector<Eigen::Vector3i> first;
  std::vector<Offsets> offsets;
  for (const Grid<float>& phi : s.phi) first.push_back(s.shape.nearest(phi.shape.origin)), offsets.push_back(offsets_of(phi.shape));
  const float half_step = 0.5f / float(s.shape.step);
  for (std::size_t i : whole.target.inside) {
    if (whole.core[i] >= 0 || !(where.empty() || where[i])) continue;
    const int own = s.owner[i], other = met(whole, i);
    if (other < 0) continue;
    const Eigen::Vector3i c = s.shape.cell(i);
    const float *mine = &s.phi[own].at(c - first[own]), *its = &s.phi[other].at(c - first[other]);
    float around[27];
    for (std::size_t k = 0; k < 27; ++k) around[k] = (mine[offsets[own][k]] - its[offsets[other][k]]) * half_step;
    if (is_sharp(around, whole.threshold)) places[std::minmax(own, other)].push_back(i);
  }
  std::vector<Flow> flows;
  for (auto& [pair, sharp] : places) flows.emplace_back(whole, pair.first, pair.second).sharp = std::move(sharp);
  return flows;
}

// Room in a part's box for a sample that it gains; true when there was not enough.
bool make_room(Grid<float>& phi, const GridShape& all, const Eigen::Vector3i& c) {
  const Eigen::Vector3i old = all.nearest(phi.shape.origin), local = c - old;
  const Eigen::Array3i after = phi.shape.size - local, before_end = all.size - c;
  if ((local.array() >= c.array().min(kMargin)).all() && (after >= before_end.min(kMargin + 1)).all()) return false;
  const Eigen::Vector3i first = (old.array() - kTravel).max(0), end = (old + phi.shape.size).array().min(all.size.array() - kTravel) + kTravel;
  Grid<float> wide({end - first, all.position(first), all.step}, kBand * float(all.step));
  for_cells(phi.shape, [&](std::size_t i, const Eigen::Vector3i& at) { wide.at(at + old - first) = phi[i]; });
  phi = std::move(wide);
  return true;
}

}  // namespace

bool blunt(Segmentation& segmentation, const Target& target, const std::vector<std::int16_t>& core, float threshold, int threads, std::vector<char>& outgrown) {
  const GridShape& shape = segmentation.shape;
  const Whole whole{segmentation, target, core, threshold};
  outgrown.assign(segmentation.phi.size(), 0);
  std::vector<char> where;
  tbb::task_arena arena(arena_size(threads));
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<Flow> flows = flows_of(whole, where);
    if (flows.empty()) return pass > 0;
    arena.execute([&] { tbb::parallel_for(std::size_t(0), flows.size(), [&](std::size_t k) { flows[k].run(); }); });
    where.assign(shape.count(), 0);
    for (const Flow& flow : flows)
      flow.for_changes([&](const Eigen::Vector3i& c, float side) {
        const std::size_t i = shape.index(c);
        for (const std::ptrdiff_t o : whole.offsets) where[std::size_t(std::ptrdiff_t(i) + o)] = 1;
        const int taker = side < 0 ? flow.a : flow.b;
        if (segmentation.owner[i] != taker && make_room(segmentation.phi[std::size_t(taker)], shape, c)) outgrown[std::size_t(taker)] = 1;
        segmentation.owner[i] = std::int16_t(taker);
        for (const auto& [bone, v] : {std::pair(flow.a, side), {flow.b, -side}}) {
          Grid<float>& phi = segmentation.phi[std::size_t(bone)];
          const Eigen::Vector3i local = c - shape.nearest(phi.shape.origin);
          if (phi.shape.contains(local)) phi.at(local) = v * float(shape.step);
        }
      });
  }
  return true;
}

}  // namespace transformables::segmentation_inner
