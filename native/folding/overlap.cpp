#include "folding/overlap.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "folding/distance_transform.h"

namespace transformables::folding {
namespace {

constexpr int kBrick = 4, kSmall = 2;  // samples along the edges of bricks, and of the small ones within them
constexpr float kUneven = 0.1f;        // steps by which an interpolated distance may change more than the way between two points

/// Those of some balls that lie in [first, first + count), eight at a time.
template <class BallOf>
void add_eights(std::vector<PartSamples::EightBalls>& into, std::uint32_t first, std::uint32_t count, const BallOf& ball_of) {
  for (std::uint32_t begin = 0; begin < count; begin += 8) {
    PartSamples::EightBalls eight;
    eight.below = first + begin;
    for (std::uint32_t n = 0; n < 8; ++n) {
      const PartSamples::Brick ball = ball_of(first + std::min(begin + n, count - 1));
      eight.centres.x[n] = ball.centre.x(), eight.centres.y[n] = ball.centre.y(), eight.centres.z[n] = ball.centre.z();
      eight.radius[n] = ball.radius;
      eight.count[n] = std::int32_t(ball.count);
      if (begin + n < count) eight.there |= 1u << n;
    }
    into.push_back(eight);
  }
}

}  // namespace

Rigid in_lattice_units(const Eigen::Isometry3d& motion, const GridShape& shape) {
  Rigid r;
  r.turn = motion.linear().cast<float>();
  r.shift = ((motion * shape.origin - shape.origin) / shape.step).cast<float>();
  return r;
}

PartField::PartField(const std::vector<std::int16_t>& owner, const GridShape& shape, int bone) {
  Eigen::AlignedBox3i box;
  const std::int16_t* row = owner.data();
  for (int k = 0; k < shape.size.z(); ++k)
    for (int j = 0; j < shape.size.y(); ++j, row += shape.size.x()) {
      int any = 0;
      for (int i = 0; i < shape.size.x(); ++i) any |= row[i] == bone;
      if (!any) continue;
      const int from = int(std::find(row, row + shape.size.x(), bone) - row);
      int to = shape.size.x() - 1;
      while (row[to] != bone) --to;
      box.extend(Eigen::Vector3i(from, j, k)), box.extend(Eigen::Vector3i(to, j, k));
    }
  if (box.isEmpty()) return;
  low_ = box.min() - Eigen::Vector3i::Constant(kMargin);
  size_ = box.max() + Eigen::Vector3i::Constant(kMargin + 1) - low_;
  first_ = low_.cast<float>(), last_ = (low_ + size_).cast<float>().array() - 1;
  std::vector<char> own(std::size_t(size_.x()) * size_.y() * size_.z(), 0);
  for (int k = box.min().z(); k <= box.max().z(); ++k)
    for (int j = box.min().y(); j <= box.max().y(); ++j) {
      row = owner.data() + shape.index(0, j, k);
      char* to = own.data() + (std::size_t(k - low_.z()) * size_.y() + j - low_.y()) * size_.x();
      for (int i = box.min().x(); i <= box.max().x(); ++i) to[i - low_.x()] = row[i] == bone;
    }
  values_ = squared_distances(own, size_);
  const std::vector<float> depth = squared_depths(own, size_);
  for (std::size_t i = 0; i < own.size(); ++i) values_[i] = own[i] ? 0.5f - std::sqrt(depth[i]) : std::sqrt(values_[i]) - 0.5f;
}

void PartField::unite(const std::vector<std::pair<Eigen::Vector3i, float>>& near) {
  if (values_.empty()) return;
  for (const auto& [c, value] : near) {
    const Eigen::Vector3i at = c - low_;
    if ((at.array() < 0).any() || (at.array() >= size_.array()).any()) continue;
    float& mine = values_[(std::size_t(at.z()) * size_.y() + at.y()) * size_.x() + at.x()];
    mine = std::min(mine, value);
  }
}

PartSamples::PartSamples(const std::vector<std::int16_t>& owner, const GridShape& shape, const std::vector<std::size_t>& inside,
                         int bone, int stride) {
  side = float(stride);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // small brick, those of a brick after each other; sample
  const Eigen::Vector3i bricks_along = shape.size / kBrick + Eigen::Vector3i::Ones();
  for (const std::size_t s : inside) {
    if (owner[s] != bone) continue;
    const Eigen::Vector3i cell = shape.cell(s), c = cell / stride, b = c / kBrick, d = c / kSmall;
    if (cell != stride * c) continue;
    const std::uint64_t brick = (std::uint64_t(b.z()) * bricks_along.y() + b.y()) * bricks_along.x() + b.x();
    order.push_back({8 * brick + std::uint64_t(d.x() % 2 + 2 * (d.y() % 2) + 4 * (d.z() % 2)), std::uint32_t(s)});
  }
  std::sort(order.begin(), order.end());
  for (const auto& [brick, s] : order) {
    index.push_back(s);
    points.push_back(shape.cell(s).cast<float>());
  }
  const auto ball = [this](std::size_t first, std::size_t last) {
    Eigen::AlignedBox3f box;
    for (std::size_t i = first; i < last; ++i) box.extend(points[i]);
    Brick b{box.center(), 0, std::uint32_t(first), std::uint32_t(last - first)};
    for (std::size_t i = first; i < last; ++i) b.radius = std::max(b.radius, (points[i] - b.centre).norm());
    return b;
  };
  const auto group = [&](std::vector<Brick>& into, std::uint64_t children) {
    for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
      while (last < order.size() && order[last].first / children == order[first].first / children) ++last;
      into.push_back(ball(first, last));
    }
  };
  group(bricks, 8);
  group(small, 1);
  if (!points.empty()) whole = ball(0, points.size());
  make_eights();
}

/// A brick has at most eight small ones, and those at most eight points.
void PartSamples::make_eights() {
  const auto nth_of = [](const std::vector<Brick>& balls) {
    return [&balls](std::uint32_t n) {
      Brick ball = balls[n];
      ball.radius += kUneven;
      return ball;
    };
  };
  add_eights(eights[0], 0, std::uint32_t(bricks.size()), nth_of(bricks));
  std::uint32_t from = 0, to = 0;
  for (const Brick& brick : bricks) {
    while (to < small.size() && small[to].first < brick.first + brick.count) ++to;
    add_eights(eights[1], from, to - from, nth_of(small));
    from = to;
  }
  for (const Brick& brick : small) {
    Cube cube;
    cube.first = (points[brick.first] / (kSmall * side)).array().floor() * (kSmall * side);
    for (std::uint32_t n = brick.first; n < brick.first + brick.count; ++n) {
      const Eigen::Vector3f corner = (points[n] - cube.first) / side;
      cube.there |= 1u << int(corner.x() + 2 * corner.y() + 4 * corner.z());
    }
    cubes.push_back(cube);
  }
}

float PairMotion::speed(const Eigen::Vector3f& p, float radius) const {
  const std::size_t pairs = a_to_b.size() < 2 ? 0 : steady ? 1 : a_to_b.size() - 1;
  float fastest = 0;
  for (std::size_t t = 0; t < pairs; ++t) {
    const float turning = (a_to_b[t + 1].turn - a_to_b[t].turn).norm();  // Frobenius, so not under the spectral norm
    fastest = std::max(fastest, (a_to_b[t + 1](p) - a_to_b[t](p)).norm() + turning * radius);
  }
  return fastest;
}

PairMotion PairMotion::reversed() const {
  PairMotion r;
  r.steady = steady;
  for (const Rigid& m : a_to_b) r.a_to_b.push_back({m.turn.transpose(), -(m.turn.transpose() * m.shift)});
  return r;
}

namespace {

/// What two parts lose when one of them gives way; counted up to `enough`.
GivingWay loss_of(const Parts& parts, int loser, int winner, const PairMotion& there, const PairMotion& back, float tolerance, std::size_t enough, bool tell) {
  GivingWay loss;
  const auto sweep = [&](const PartSamples& samples, const PartField& field, const PairMotion& motion) {
    if (loss.samples >= enough) return;
    std::vector<char> hit;
    loss.samples += swept_samples(samples, field, motion, tolerance, tell ? &hit : nullptr, enough - loss.samples);
    for (std::size_t i = 0; i < hit.size(); ++i)
      if (hit[i]) loss.gone.push_back(samples.index[i]);
  };
  const bool plain = parts.skeletons.empty();
  if (!plain) sweep(parts.samples[winner], parts.skeletons[loser], back);
  sweep(plain ? parts.samples[loser] : parts.skins[loser], parts.fields[winner], there);
  return loss;
}

}  // namespace

GivingWay giving_way(const Parts& parts, int a, int b, const PairMotion& there, float tolerance, bool tell) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  const PairMotion back = there.reversed();
  const bool a_smaller = parts.samples[a].points.size() <= parts.samples[b].points.size();  // the cheaper look often tells enough
  const std::size_t any = a_smaller ? swept_samples(parts.samples[a], parts.fields[b], there, tolerance, nullptr, 1)
                                    : swept_samples(parts.samples[b], parts.fields[a], back, tolerance, nullptr, 1);
  if (any == 0) return {};
  GivingWay first = loss_of(parts, a, b, there, back, tolerance, kAll, tell);
  GivingWay second = loss_of(parts, b, a, back, there, tolerance, first.samples, tell);
  return second.samples < first.samples ? second : first;
}

std::vector<std::int16_t> skins_of(std::vector<std::int16_t> owner, const Skeletons& skeletons) {
  for (std::size_t s = 0; s < skeletons.bone.size(); ++s)
    if (skeletons.bone[s] == owner[s]) owner[s] = -1;
  return owner;
}

PartField skeleton_field(const Skeletons& skeletons, const GridShape& shape, int bone) {
  PartField field(skeletons.bone, shape, bone);
  field.unite(skeletons.near[std::size_t(bone)]);
  return field;
}

Parts parts_of(const Segmentation& segmentation, const Target& target, int stride, const Skeletons& skeletons) {
  const GridShape& shape = segmentation.shape;
  const int bones = int(segmentation.frames.size());
  constexpr float kNone = std::numeric_limits<float>::max();
  std::vector<float> least(shape.count(), kNone), second(shape.count(), kNone);
  const auto each_sample = [&](int bone, const auto& visit) {
    const Grid<float>& phi = segmentation.phi[bone];
    if (phi.values.empty()) return;
    const Eigen::Vector3i low = shape.nearest(phi.shape.origin);
    for (std::size_t i = 0; i < phi.values.size(); ++i) {
      const Eigen::Vector3i c = low + phi.shape.cell(i);
      if (shape.contains(c)) visit(shape.index(c), phi.values[i]);
    }
  };
  for (int bone = 0; bone < bones; ++bone)
    each_sample(bone, [&](std::size_t s, float v) {
      second[s] = std::min(second[s], std::max(v, least[s]));
      least[s] = std::min(least[s], v);
    });
  Parts parts;
  parts.fields.resize(bones), parts.samples.resize(bones);
  if (!skeletons.bone.empty()) parts.skeletons.resize(bones), parts.skins.resize(bones);
  const std::vector<std::int16_t> skin = skins_of(segmentation.owner, skeletons);
  tbb::parallel_for(0, bones, [&](int bone) {
    parts.samples[bone] = PartSamples(segmentation.owner, shape, target.inside, bone, stride);
    parts.fields[bone] = PartField(segmentation.owner, shape, bone);
    std::vector<float> psi(segmentation.phi[bone].values.empty() ? 0 : shape.count(), kNone);
    each_sample(bone, [&](std::size_t s, float v) {
      const float other = v > least[s] ? least[s] : second[s];
      const float apart = other == kNone ? -kNone : (v - other) / 2;
      psi[s] = std::max(apart, target.distance[s]) / float(shape.step);
    });
    if (!psi.empty()) parts.fields[bone].refine(shape, [&](std::size_t s) { return psi[s]; });
    if (skeletons.bone.empty()) return;
    parts.fields[bone].unite(skeletons.near[std::size_t(bone)]);
    parts.skeletons[bone] = skeleton_field(skeletons, shape, bone);
    parts.skins[bone] = PartSamples(skin, shape, target.inside, bone, stride);
  });
  return parts;
}

}  // namespace transformables::folding
