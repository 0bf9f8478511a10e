// The parts before any gap is cut between them: together they are the target.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cases.h"
#include "finishing/finishing.h"
#include "finishing/outer_surface.h"
#include "finishing/part_field.h"
#include "finishing/row_reader.h"
#include "finishing/shared_surface.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

struct Divided {
  Character character;
  Target target;
  Embedding embedding;
  Segmentation segmentation;
};

/// A box that bones share, each with what is nearest to it. The first is the root, and all others turn about it.
Divided divided(const std::vector<Segment>& axes, double step) {
  const Vector3d half(0.25, 0.21, 0.17);
  Divided d;
  std::vector<ArmatureBone> bones;
  for (const Segment& axis : axes) {
    bones.push_back({"bone" + std::to_string(bones.size()), bones.empty() ? -1 : 0, axis.a, axis.b, Eigen::Matrix3d::Identity(), {}});
    if (bones.size() > 1) bones.back().hinges.push_back({0, -1, 1});
  }
  d.character = make_character(bones);
  for (Bone& bone : d.character.bones) bone.radius = 0.012;
  d.embedding.pose = rest_pose(d.character, d.character.root_rest);
  d.embedding.morphology = Morphology::Ones(long(bones.size()));
  d.target.mesh = box_mesh(-half, half);
  d.target.volume = signed_volume(d.target.mesh);
  const Eigen::Array3i cells = (half.array() / step).ceil().cast<int>() + 4;
  const GridShape shape{(2 * cells).matrix(), -step * (cells.cast<double>() - 0.5).matrix(), step};
  d.target.distance = signed_distance(d.target, shape);
  d.segmentation.shape = shape;
  d.segmentation.owner.assign(shape.count(), -1);
  d.segmentation.frames = forward_kinematics(d.character, d.embedding.pose, d.embedding.morphology);
  d.segmentation.phi.assign(bones.size(), Grid<float>(shape, 0));
  for (std::size_t v = 0; v < shape.count(); ++v) {
    const Vector3d p = shape.position(v);
    std::vector<double> away;
    for (const Segment& axis : axes) away.push_back(distance(axis, p));
    const std::size_t nearest = std::size_t(std::min_element(away.begin(), away.end()) - away.begin());
    for (std::size_t b = 0; b < bones.size(); ++b) {
      double other = 1;
      for (std::size_t o = 0; o < bones.size(); ++o)
        if (o != b) other = std::min(other, away[o]);
      d.segmentation.phi[b][v] = float(std::clamp((away[b] - other) / 2, -4 * step, 4 * step));
    }
    if (d.target.distance[v] >= 0) continue;
    d.target.inside.push_back(v);
    d.segmentation.owner[v] = std::int16_t(nearest);
  }
  return d;
}

/// Six arms about a middle: interfaces meet by threes along lines all through the box.
std::vector<Segment> star() {
  std::vector<Segment> axes{{{0, 0, 0}, {0.031, 0.017, 0.023}}};
  const Vector3d most(0.1875, 0.1575, 0.1275);
  for (int n = 0; n < 6; ++n) {
    Vector3d to(0.02, -0.03, 0.025), from = to;
    to[n / 2] = (n % 2 ? 1 : -1) * most[n / 2];
    from[n / 2] = to[n / 2] / 2;
    axes.push_back({from, to});
  }
  return axes;
}

/// As many bones as wanted about one point, no two in line with it: all their parts meet there.
std::vector<Segment> about_a_point(int count) {
  const Vector3d centre(0.013, -0.007, 0.004);
  const std::vector<Vector3d> ways{{0.6, 0.5, 0.62}, {-0.63, -0.48, 0.6}, {-0.58, 0.55, -0.6}, {0.55, -0.6, -0.58}};
  std::vector<Segment> axes;
  for (int n = 0; n < count; ++n) axes.push_back({centre + 0.06 * ways[std::size_t(n)].normalized(), centre + 0.15 * ways[std::size_t(n)].normalized()});
  return axes;
}

std::vector<Segment> at_random(std::uint64_t seed, int count) {
  Random random{seed};
  const auto point = [&] { return Vector3d(0.4 * (random() - 0.5), 0.32 * (random() - 0.5), 0.24 * (random() - 0.5)); };
  std::vector<Segment> axes;
  while (int(axes.size()) < count) {
    const Vector3d a = point(), b = a + 0.12 * (point() - a).normalized();
    const bool within = (b.array().abs() < Eigen::Array3d(0.22, 0.18, 0.14)).all();
    if (within && std::all_of(axes.begin(), axes.end(), [&](const Segment& other) { return distance(other, a) > 0.05 && distance(other, b) > 0.05 && distance(other, (a + b) / 2) > 0.05; }))
      axes.push_back({a, b});
  }
  return axes;
}

/// The parts with no gap between them at all.
struct Undivided {
  Divided design;
  FinishingOptions options;
  finishing::Lattice lattice;
  std::vector<finishing::PartField> fields;

  Undivided(const std::vector<Segment>& axes, int voxels) : design(divided(axes, kLongestSide / voxels)) {
    options.clearance = 0;
    lattice = finishing::make_lattice(design.target, options);
    lattice.gap = 0;
    fields = finishing::make_part_fields(design.segmentation, design.character, design.embedding, options, lattice);
  }
  /// Share of the target's volume that the parts' meshes leave out.
  double left_out() const {
    const FoldPath path;
    const finishing::Scene scene{design.character, design.embedding, design.segmentation, path, options, lattice};
    finishing::Mesher mesher(scene, design.target);
    double sum = 0;
    for (const Part& part : mesher.mesh(fields, std::vector<char>(fields.size(), 1))) sum += part.volume;
    EXPECT_TRUE(mesher.warnings().empty());
    return 1 - sum / design.target.volume;
  }
};

TEST(RowReader, ReadsWhatSamplesReadWithinTheBoxAndNothingBeyond) {
  Grid<float> phi({{5, 4, 6}, {0.1, -0.2, 0.3}, 0.1}, 0);
  for (std::size_t n = 0; n < phi.values.size(); ++n) phi[n] = float(std::sin(double(n)));
  const GridShape lattice{{40, 40, 40}, {-0.1, -0.4, 0.1}, 0.037};
  finishing::RowReader reader(phi, lattice, 9);
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j) {
      const int first = (j + k) % 20;
      const std::vector<float>& row = reader.row(first, 39, j, k);
      ASSERT_EQ(row.size(), std::size_t(40 - first));
      for (std::size_t n = 0; n < row.size(); ++n) {
        const Vector3d p = lattice.position({first + int(n), j, k}), q = (p - phi.shape.origin) / phi.shape.step;
        const bool within = (q.array() >= 0).all() && (q.array() <= Eigen::Array3d(4, 3, 5)).all();
        EXPECT_NEAR(row[n], within ? sample(phi, p) : 9, 1e-5);
      }
    }
}

TEST(Partition, WithoutAGapEverySampleWithinTheTargetIsInExactlyOnePart) {
  const Undivided made(star(), 32);
  Grid<int> parts(made.lattice.outer.shape, 0);
  for (const auto& field : made.fields)
    for (std::size_t n = 0; n < field.psi.values.size(); ++n) parts.at(field.corner + field.shape().cell(n)) += field.psi[n] < 0;
  std::size_t wrong = 0;
  for (std::size_t v = 0; v < parts.values.size(); ++v) wrong += parts[v] != int(made.lattice.outer[v] < 0);
  EXPECT_EQ(wrong, 0u);
}

constexpr double kLost = 0.0002;   ///< share of the target's volume

TEST(Partition, WithoutAGapMeshesFillTheTargetWhereThreePartsMeet) {
  for (const int voxels : {24, 48}) EXPECT_LT(std::abs(Undivided(star(), voxels).left_out()), kLost) << voxels;
}

TEST(Partition, WithoutAGapMeshesFillTheTargetWhereAllOfThemMeetAtAPoint) {
  for (const int count : {3, 4}) EXPECT_LT(std::abs(Undivided(about_a_point(count), count == 3 ? 24 : 48).left_out()), kLost) << count;
}

TEST(Partition, WithoutAGapMeshesFillTheTargetHoweverItIsDivided) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    EXPECT_LT(std::abs(Undivided(at_random(seed, 4 + int(seed)), 24).left_out()), kLost) << seed;
}

TEST(Partition, FinishedPartsThatNeitherMoveNorHaveAGapFillTheTarget) {
  const Undivided made(star(), 24);
  const Parts parts = finish(made.design.segmentation, made.design.character, made.design.target, made.design.embedding, {}, made.options, {});
  for (const Part& part : parts.parts) expect_good(part.mesh);
  EXPECT_NEAR(parts.filled_volume_pct, 100, 100 * kLost);
}

/// Parts of noise: each sample is one's, at random, and as far from all as chance wants. The last has the border, and all that is around.
std::vector<finishing::PartField> noise(std::uint64_t seed, int count) {
  Random random{seed};
  const GridShape shape{{12, 12, 12}, Vector3d::Zero(), 0.002};
  std::vector<finishing::PartField> parts(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) {
    parts[std::size_t(n)].bone = n;
    parts[std::size_t(n)].uncarved = Grid<float>(shape, 0);
  }
  const auto some = [&] { return float(shape.step * (seed % 3 == 0 ? random() : random() < 0.4 ? 1e-6 : 0.9)); };
  for (std::size_t v = 0; v < shape.count(); ++v) {
    const Eigen::Vector3i c = shape.cell(v);
    const bool border = (c.array() == 0).any() || (c.array() == 11).any();
    const int owner = border ? count - 1 : std::min(int(random() * count), count - 1);
    for (int n = 0; n < count; ++n) parts[std::size_t(n)].uncarved[v] = (n == owner ? -1 : 1) * (some() + 1e-9f);
  }
  return parts;
}

TEST(SharedSurface, PartsOfAnyNoiseAreClosedManifoldAndSimpleAfterTurningAndRoundingToFloatAndLeaveNothingBetweenThem) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, 0.5, -0.7, 0.2).normalized();
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const auto parts = noise(seed, 2 + int(seed % 4));
    double all = 0, within = 0;
    for (const auto& part : parts) {
      TriangleMesh mesh = finishing::shared_surface(part.uncarved, part, parts);
      const double volume = signed_volume(mesh);
      all += volume;
      if (&part == &parts.back()) continue;   // inside out, as it is around the others
      within += volume;
      for (Vector3d& v : mesh.vertices) v = (turn * v + Vector3d(0.2, 0.1, -0.2)).unaryExpr(&to_float);
      const MeshCheck c = check(mesh);
      EXPECT_FALSE(c.open || c.non_manifold || c.self_intersecting || c.inside_out) << "seed " << seed << ", part " << part.bone;
    }
    EXPECT_NEAR(all, 0, 1e-9 * within) << "seed " << seed;
  }
}

}  // namespace
}  // namespace transformables
