#include "finishing/part_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "finishing/row_reader.h"

namespace transformables::finishing {
namespace {

constexpr int kMargin = 5;                   ///< samples between a part and its box's border
constexpr double kLargestCount = 1.2e8;      ///< samples of a lattice: 2 GB with what is held for each
constexpr float kFar = 1e3f;                 ///< a distance that is longer than any target
constexpr double kPassing = 0.875;           ///< of the clearance, that carving leaves parts that pass each other, at least
constexpr double kAboveProof = 0.25;         ///< of the clearance, by which that is more than what is proved: distances on samples are of first order

/// A box of lattice samples, both ends included.
struct SampleBox {
  Eigen::Vector3i low = Eigen::Vector3i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector3i high = Eigen::Vector3i::Constant(std::numeric_limits<int>::min());

  bool empty() const { return (low.array() > high.array()).any(); }
  void extend(const Eigen::Vector3i& c) {
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  }
  SampleBox grown(int by, const GridShape& within) const {
    return {(low.array() - by).max(0).matrix(), (high.array() + by).min(within.size.array() - 1).matrix()};
  }
};

SampleBox samples_within(const GridShape& lattice, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Array3d a = (low - lattice.origin).array() / lattice.step, b = (high - lattice.origin).array() / lattice.step;
  constexpr double kRounding = 1e-6;
  return {(a - kRounding).ceil().cast<int>().max(0).matrix(),
          (b + kRounding).floor().cast<int>().min(lattice.size.array() - 1).matrix()};
}

Grid<float> grid_over(const SampleBox& box, const GridShape& lattice, float value) {
  return Grid<float>({box.high - box.low + Eigen::Vector3i::Ones(), lattice.position(box.low), lattice.step}, value);
}

/// Calls f(sample of the lattice, index in the box's grid) for all samples of a box.
template <class F>
void for_each_sample(const SampleBox& box, F&& f) {
  std::size_t n = 0;
  for (int k = box.low.z(); k <= box.high.z(); ++k)
    for (int j = box.low.y(); j <= box.high.y(); ++j)
      for (int i = box.low.x(); i <= box.high.x(); ++i) f(Eigen::Vector3i(i, j, k), n++);
}

/// The two least level sets at every sample of the lattice, and whose the least is.
struct Nearest {
  std::vector<float> first, second;
  std::vector<std::int16_t> bone;
};

Nearest nearest_two(const Segmentation& segmentation, const GridShape& lattice) {
  const float clamp = float(4 * segmentation.shape.step);
  Nearest n{std::vector<float>(lattice.count(), clamp), std::vector<float>(lattice.count(), clamp),
            std::vector<std::int16_t>(lattice.count(), -1)};
  std::vector<SampleBox> boxes;
  for (const Grid<float>& phi : segmentation.phi) {
    const GridShape& s = phi.shape;
    boxes.push_back(phi.values.empty() ? SampleBox{} : samples_within(lattice, s.origin, s.position(Eigen::Vector3i(s.size - Eigen::Vector3i::Ones()))));
  }
  tbb::parallel_for(0, lattice.size.z(), [&](int k) {
    for (std::size_t bone = 0; bone < boxes.size(); ++bone) {
      const SampleBox& box = boxes[bone];
      if (box.empty() || k < box.low.z() || k > box.high.z()) continue;
      RowReader phi(segmentation.phi[bone], lattice, clamp);
      for (int j = box.low.y(); j <= box.high.y(); ++j) {
        std::size_t at = lattice.index(box.low.x(), j, k);
        for (const float value : phi.row(box.low.x(), box.high.x(), j, k)) {
          if (value < n.first[at]) {
            n.second[at] = n.first[at];
            n.first[at] = value;
            n.bone[at] = std::int16_t(bone);
          } else if (value < n.second[at]) {
            n.second[at] = value;
          }
          ++at;
        }
      }
    }
  });
  return n;
}

/// A bone's box: that of its samples nearest to it, and of its skeleton.
std::vector<SampleBox> boxes_of(const Nearest& nearest, const Lattice& lattice, const Segmentation& segmentation,
                                const std::vector<SkeletalShape>& skeletons) {
  const GridShape& shape = lattice.outer.shape;
  std::vector<SampleBox> boxes(skeletons.size());
  for (std::size_t at = 0; at < nearest.bone.size(); ++at)
    if (nearest.bone[at] >= 0 && lattice.outer[at] < 0) boxes[nearest.bone[at]].extend(shape.cell(at));
  for (std::size_t bone = 0; bone < boxes.size(); ++bone) {
    for (const Segment& s : skeletons[bone].capsules) {
      const Segment t = transformed(segmentation.frames[bone], s);
      const Eigen::Vector3d r = Eigen::Vector3d::Constant(skeletons[bone].radius);
      const SampleBox b = samples_within(shape, t.a.cwiseMin(t.b) - r, t.a.cwiseMax(t.b) + r);
      if (b.empty()) continue;
      boxes[bone].extend(b.low);
      boxes[bone].extend(b.high);
    }
    if (boxes[bone].empty()) boxes[bone].extend(shape.nearest(segmentation.frames[bone].translation()).cwiseMax(0).cwiseMin((shape.size.array() - 1).matrix()));
    boxes[bone] = boxes[bone].grown(kMargin, shape);
  }
  return boxes;
}

/// A shell keeps what is near the target's surface, and two plates along each segment of the skeleton that carry it.
float shelled(float psi, float outer, const Eigen::Vector3d& p, const std::vector<Segment>& skeleton, double wall) {
  double kept = -outer - wall;
  for (const Segment& s : skeleton) {
    const Eigen::Vector3d along = (s.b - s.a).normalized();
    const Eigen::Vector3d first = along.unitOrthogonal(), second = along.cross(first);
    kept = std::min({kept, std::abs(first.dot(p - s.a)) - wall / 2, std::abs(second.dot(p - s.a)) - wall / 2});
  }
  return std::max(psi, float(kept));
}

struct Maker {
  const Segmentation& segmentation;
  const Lattice& lattice;
  const FinishingOptions& options;
  const Nearest& nearest;
  const std::vector<SkeletalShape>& skeletons;
  const std::vector<SampleBox>& boxes;
  std::vector<Grid<float>> raw;    ///< each skeletal shape, before others are heeded
  std::vector<Grid<float>> cores;  ///< the same, with the gap between each other

  void make_raw(int bone) {
    raw[bone] = grid_over(boxes[bone], lattice.outer.shape, kFar);
    const Eigen::Isometry3d into = segmentation.frames[bone].inverse();
    for_each_sample(boxes[bone], [&](const Eigen::Vector3i& c, std::size_t n) {
      raw[bone][n] = float(std::min(skeletons[bone].distance(into * lattice.outer.shape.position(c)), double(kFar)));
    });
  }

  /// Calls f(index in bone's grid, value of `fields[other]`) where two boxes overlap.
  template <class F>
  void for_each_shared(int bone, int other, const std::vector<Grid<float>>& fields, F&& f) const {
    const SampleBox both{boxes[bone].low.cwiseMax(boxes[other].low), boxes[bone].high.cwiseMin(boxes[other].high)};
    if (both.empty()) return;
    const GridShape &a = raw[bone].shape, &b = raw[other].shape;
    for_each_sample(both, [&](const Eigen::Vector3i& c, std::size_t) {
      f(a.index(c - boxes[bone].low), fields[other][b.index(c - boxes[other].low)]);
    });
  }

  /// Where skeletal shapes overlap, each keeps what is nearer to it; a child's housing stays whole, since its
  /// parent's shape has a room cut for it already.
  void make_core(int bone) {
    cores[bone] = raw[bone];
    const float half_gap = float(lattice.gap / 2);
    for (int other = 0; other < int(boxes.size()); ++other)
      if (other != bone)
        for_each_shared(bone, other, raw, [&](std::size_t n, float theirs) {
          cores[bone][n] = std::max(cores[bone][n], (raw[bone][n] - theirs) / 2 + half_gap);
        });
  }

  /// Signed distance of a bone's side of its interfaces. Level sets are distances only roughly, the gap is to be exact.
  Grid<float> side_of(int bone) const {
    Grid<float> side = grid_over(boxes[bone], lattice.outer.shape, kFar);
    // A sample outside the level set's box is at least the margin away from the part.
    RowReader phi(segmentation.phi[bone], lattice.outer.shape, float(4 * segmentation.shape.step));
    const SampleBox& box = boxes[bone];
    std::size_t n = 0;
    for (int k = box.low.z(); k <= box.high.z(); ++k)
      for (int j = box.low.y(); j <= box.high.y(); ++j) {
        std::size_t at = lattice.outer.shape.index(box.low.x(), j, k);
        for (const float here : phi.row(box.low.x(), box.high.x(), j, k)) {
          const bool own = nearest.bone[at] == bone;
          side[n++] = ((own ? nearest.first[at] : here) - (own ? nearest.second[at] : nearest.first[at])) / 2;
          ++at;
        }
      }
    return redistanced(side);
  }

  Grid<float> skin(int bone) const {
    Grid<float> inner = side_of(bone);
    const float half_gap = float(lattice.gap / 2);
    for (float& v : inner.values) v += half_gap;
    if (options.style == Style::kSolid) return inner;
    std::vector<Segment> skeleton;
    for (const Segment& s : skeletons[bone].capsules)
      if ((s.b - s.a).norm() > 1e-9) skeleton.push_back(transformed(segmentation.frames[bone], s));
    for_each_sample(boxes[bone], [&](const Eigen::Vector3i& c, std::size_t n) {
      inner[n] = shelled(inner[n], lattice.outer.at(c), lattice.outer.shape.position(c), skeleton, options.wall);
    });
    return inner;
  }

  PartField part(int bone) const {
    PartField field;
    field.bone = bone;
    field.inner = skin(bone);
    const float gap = float(lattice.gap);
    for (int other = 0; other < int(boxes.size()); ++other)
      if (other != bone)
        for_each_shared(bone, other, cores, [&](std::size_t n, float theirs) {
          field.inner[n] = std::max(field.inner[n], gap - theirs);
        });
    for (std::size_t n = 0; n < field.inner.values.size(); ++n) field.inner[n] = std::min(field.inner[n], cores[bone][n]);
    field.corner = boxes[bone].low;
    crop(field, cores[bone]);
    field.uncarved = field.inner;
    refresh(field);
    return field;
  }

  /// Cuts the fields down to the part, with a margin.
  void crop(PartField& field, const Grid<float>& whole_core) const {
    SampleBox tight;
    for (std::size_t n = 0; n < field.inner.values.size(); ++n) {
      const Eigen::Vector3i c = field.corner + field.inner.shape.cell(n);
      if (field.inner[n] < 0 && lattice.outer.at(c) < 0) tight.extend(c);
    }
    if (tight.empty()) tight.extend(field.corner);
    const SampleBox box = tight.grown(kMargin, lattice.outer.shape);
    Grid<float> inner = grid_over(box, lattice.outer.shape, kFar);
    field.core = field.psi = inner;
    field.away = Grid<Away>(inner.shape, {kFar, kFar});
    for_each_sample(box, [&](const Eigen::Vector3i& c, std::size_t n) {
      const Eigen::Vector3i local = c - field.corner;
      field.away[n].outer = lattice.outer.at(c);
      if (!field.inner.shape.contains(local)) return;
      inner[n] = field.inner.at(local);
      field.core[n] = whole_core.at(local);
    });
    field.inner = std::move(inner);
    field.corner = box.low;
  }
};

}  // namespace

Lattice make_lattice(const Target& target, const FinishingOptions& options) {
  const GridShape& coarse = target.distance.shape;
  const double step = coarse.step / options.refinement;
  const Eigen::AlignedBox3d box = bounds(target.mesh);
  const Eigen::Array3i low = ((box.min() - coarse.origin).array() / step).floor().cast<int>() - kMargin - 1;
  const Eigen::Array3i high = ((box.max() - coarse.origin).array() / step).ceil().cast<int>() + kMargin + 1;
  const GridShape shape{(high - low + 1).matrix(), coarse.origin + step * low.cast<double>().matrix(), step};
  if (shape.size.cast<double>().prod() > kLargestCount)
    throw InvalidInput("The fine grid would have more than 120 million samples; lower the resolution or the refinement.");
  Lattice lattice;
  lattice.outer = signed_distance(target, shape);
  lattice.scale = target.scale;
  // Between two configurations parts may come nearer than at them, by the cover: three quarters of the clearance are kept all the same.
  lattice.cover = std::clamp(options.clearance / 2, step / 16, step / 8);
  lattice.gap = options.clearance + std::max(lattice.cover / 2, lattice.cover - options.clearance / 4);
  lattice.passing = lattice.gap - (1 - std::clamp(options.least_share + kAboveProof, kPassing, 1.0)) * options.clearance;
  return lattice;
}

std::vector<PartField> make_part_fields(const Segmentation& segmentation, const Character& character,
                                        const Embedding& embedding, const FinishingOptions& options, const Lattice& lattice) {
  const auto skeletons = skeletal_shapes(character, embedding.morphology, lattice.gap);
  const Nearest nearest = nearest_two(segmentation, lattice.outer.shape);
  const auto boxes = boxes_of(nearest, lattice, segmentation, skeletons);
  const int count = int(skeletons.size());
  Maker maker{segmentation, lattice, options, nearest, skeletons, boxes, std::vector<Grid<float>>(count), std::vector<Grid<float>>(count)};
  tbb::parallel_for(0, count, [&](int bone) { maker.make_raw(bone); });
  tbb::parallel_for(0, count, [&](int bone) { maker.make_core(bone); });
  std::vector<PartField> parts(count);
  tbb::parallel_for(0, count, [&](int bone) { parts[bone] = maker.part(bone); });
  return parts;
}

}  // namespace transformables::finishing
