// Room embedding: the flood, against Dijkstra on the same voxels.
#include "cases.h"

#include <queue>

namespace transformables {
namespace {

struct Way {
  double length = 0;
  std::size_t voxel = 0;
  int bone = -1;
  bool operator>(const Way& o) const { return length > o.length; }
};

/// For each sample inside: the least way to every bone; the outer index is the bone.
std::vector<std::vector<double>> ways_by_dijkstra(const Character& character, const Target& target, const Skeleton& skeleton) {
  const GridShape& shape = target.distance.shape;
  std::vector<char> inside(shape.count(), 0);
  for (const std::size_t i : target.inside) inside[i] = 1;
  std::vector<std::vector<double>> ways(character.bones.size());
  for (std::size_t b = 0; b < character.bones.size(); ++b) {
    ways[b].assign(shape.count(), 1e9);
    std::priority_queue<Way, std::vector<Way>, std::greater<Way>> queue;
    for (const std::size_t i : target.inside)
      for (int s = skeleton.first_segment[b]; s < skeleton.first_segment[b + 1]; ++s) {
        const auto& segment = skeleton.segments[std::size_t(s)];
        const double d = distance(Segment{segment.a, segment.a + segment.length * segment.direction}, shape.position(i));
        if (d <= character.bones[b].radius) queue.push({d / shape.step, i, int(b)});
      }
    while (!queue.empty()) {
      const Way way = queue.top();
      queue.pop();
      if (way.length >= ways[b][way.voxel]) continue;
      ways[b][way.voxel] = way.length;
      const Eigen::Vector3i c = shape.cell(way.voxel);
      for (int k = 0; k < 27; ++k) {
        const Eigen::Vector3i step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1), to = c + step;
        if (k == 13 || !shape.contains(to) || !inside[shape.index(to)]) continue;
        queue.push({way.length + step.cast<double>().norm(), shape.index(to), int(b)});
      }
    }
  }
  return ways;
}

TEST(Flood, GivesEachVoxelOfAUTheBoneThatIsNearestByTheWayInside) {
  const Target target = u_target();
  const Character character = chain(3, 0.09, 0.016);
  Pose pose = pose_at(character, {-0.1, 0, 0.2});
  pose.root.linear() = Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()).toRotationMatrix();  // down the left tower
  Objective objective(character, target, {});
  objective(pose, unscaled(character));
  Skeleton skeleton(character);
  skeleton.set(pose, unscaled(character));
  const auto ways = ways_by_dijkstra(character, target, skeleton);
  const std::vector<std::int16_t>& labels = objective.labels();
  ASSERT_EQ(labels.size(), target.distance.shape.count());
  std::size_t compared = 0, agree = 0, across = 0;
  for (const std::size_t i : target.inside) {
    int best = 0, second = 1;
    for (int b = 0; b < 3; ++b)
      if (ways[std::size_t(b)][i] < ways[std::size_t(best)][i]) best = b;
    second = best == 0 ? 1 : 0;
    for (int b = 0; b < 3; ++b)
      if (b != best && ways[std::size_t(b)][i] < ways[std::size_t(second)][i]) second = b;
    ASSERT_GE(labels[i], 0);
    if (target.distance.shape.position(i).x() > 0.03 && labels[i] != 2) ++across;
    if (ways[std::size_t(second)][i] - ways[std::size_t(best)][i] < 0.5) continue;
    ++compared;
    agree += labels[i] == best;
  }
  EXPECT_GT(compared, target.inside.size() / 2);
  EXPECT_GE(double(agree), 0.99 * double(compared));
  EXPECT_EQ(across, 0u) << "the right tower is reached from the base only, so it is the lowest bone's";
}

TEST(Flood, LabelsAreMinusOneOutsideAndCoverTheInsideOfAFinerTargetToo) {
  const Target target = box_target({0.1, 0.25, 0.1}, 128);
  const Character character = chain(2, 0.2, 0.02);
  Objective objective(character, target, {});
  objective(pose_at(character, {0, -0.2, 0}), unscaled(character));
  const auto& labels = objective.labels();
  std::size_t labelled = 0, right = 0;
  for (const std::int16_t label : labels) labelled += label >= 0;
  EXPECT_EQ(labelled, target.inside.size());
  for (const std::size_t i : target.inside) right += labels[i] == (target.distance.shape.position(i).y() < 0 ? 0 : 1);
  EXPECT_GT(double(right), 0.97 * double(labelled));
}

TEST(Flood, AThinBoneStillHasVoxels) {
  const Target target = box_target({0.1, 0.25, 0.1}, 32);
  const Character character = chain(2, 0.2, 0.0005);
  Objective objective(character, target, {});
  objective(pose_at(character, {0.0031, -0.2, 0.0017}), unscaled(character));
  const auto& labels = objective.labels();
  EXPECT_NE(std::find(labels.begin(), labels.end(), 0), labels.end());
  EXPECT_NE(std::find(labels.begin(), labels.end(), 1), labels.end());
}

// Behind a bent joint both bones are equally near, and the bisector alone parts them: how the grid happens to lie about the joint must not turn it.
TEST(Flood, PartsABentLimbAlikeHoweverTheGridLies) {
  const Target target = box_target({0.2, 0.25, 0.2}, 64);
  const Character character = chain(4, 0.12, 0.006, {0, -2, 2});
  Pose pose = pose_at(character, {0.01, -0.12, -0.02});
  pose.angles << 1.1, -1.7, 1.4;
  constexpr int kGrids = 16;
  double mean = 0, square = 0;
  for (int k = 0; k < kGrids; ++k) {
    Vector3d shift = k * Vector3d(0.8191725134, 0.6710436067, 0.5497004779);
    shift = shift.array() - shift.array().floor();
    Evaluator evaluator(character, target, std::make_shared<const Voxels>(target, 0.02, shift, Voxels::kAlways), {});
    const double skin = evaluator(pose, unscaled(character)).terms.skin;
    mean += skin / kGrids;
    square += skin * skin / kGrids;
  }
  EXPECT_GT(mean, 0);
  EXPECT_LT(std::sqrt(square - mean * mean), 0.05 * mean) << mean;
}

}  // namespace
}  // namespace transformables
