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

namespace transformables {
namespace {

using Eigen::Vector3d;

struct Divided {
  Character character;
  Target target;
  Embedding embedding;
  Segmentation segmentation;
};

/// A box that six arms of a star share, each with what is nearest to it: interfaces meet by threes along lines all through it.
Divided star(double step) {
  const Vector3d half(0.25, 0.21, 0.17);
  Divided d;
  std::vector<ArmatureBone> bones{{"middle", -1, {0, 0, 0}, {0.031, 0.017, 0.023}, Eigen::Matrix3d::Identity(), {}}};
  for (int n = 0; n < 6; ++n) {
    Vector3d to(0.02, -0.03, 0.025), from = to;
    to[n / 2] = (n % 2 ? 0.75 : -0.75) * half[n / 2];
    from[n / 2] = to[n / 2] / 2;
    bones.push_back({"arm" + std::to_string(n), 0, from, to, Eigen::Matrix3d::Identity(), {{0, -1, 1}}});
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
    for (const ArmatureBone& bone : bones) away.push_back(distance(Segment{bone.head, bone.tail}, p));
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

/// The parts with no gap between them at all.
struct Undivided {
  Divided design;
  FinishingOptions options;
  finishing::Lattice lattice;
  std::vector<finishing::PartField> fields;

  explicit Undivided(double step) : design(star(step)) {
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
  const Undivided made(kLongestSide / 32);
  Grid<int> parts(made.lattice.outer.shape, 0);
  for (const auto& field : made.fields)
    for (std::size_t n = 0; n < field.psi.values.size(); ++n) parts.at(field.corner + field.shape().cell(n)) += field.psi[n] < 0;
  std::size_t wrong = 0;
  for (std::size_t v = 0; v < parts.values.size(); ++v) wrong += parts[v] != int(made.lattice.outer[v] < 0);
  EXPECT_EQ(wrong, 0u);
}

TEST(Partition, WithoutAGapMeshesLeaveOutOnlyWhatTheLatticeRoundsOffWhereThreePartsMeet) {
  const double coarse = Undivided(kLongestSide / 16).left_out(), fine = Undivided(kLongestSide / 32).left_out();
  EXPECT_GT(fine, 0) << "they overlap";
  EXPECT_LT(fine, 0.0025);
  EXPECT_LT(fine, coarse / 2.5) << "a loss along interfaces goes with the step, one along lines with its square";
}

}  // namespace
}  // namespace transformables
