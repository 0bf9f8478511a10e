// Room embedding: what is in the way when the joints unfold, on labels set by hand.
#include "cases.h"
#include "embedding/unfolding.h"

namespace transformables {
namespace {

/// A target whose voxels are given to two hinged bones by hand, whatever the flood would make of them.
struct ByHand {
  /// @param head  of the second bone, which turns about X, @param folded  radians
  template <class IsSecond>
  ByHand(const Vector3d& half, const Vector3d& head, double folded, const IsSecond& is_second)
      : target(box_target(half, 40)), character(chain(2, 0.1, 0.02, {0, -3, 3})), voxels(std::make_shared<const Voxels>(target)) {
    pose = pose_at(character, head - Vector3d(0, 0.1, 0));
    pose.angles << folded;
    field = voxels->wall;
    for (int z = 0; z < voxels->size.z(); ++z)
      for (int y = 0; y < voxels->size.y(); ++y)
        for (int x = 0; x < voxels->size.x(); ++x) {
          std::int32_t& cell = field[std::size_t(voxels->cell(x, y, z))];
          if (cell != 0) continue;
          cell = is_second(voxels->position(x, y, z)) ? 1 : 0;
          second += cell;
        }
  }
  double unfold() const {
    Skeleton skeleton(character);
    skeleton.set(pose, unscaled(character));
    return Unfolding(character, voxels)(skeleton, pose, field);
  }
  Target target;
  Character character;
  std::shared_ptr<const Voxels> voxels;
  Pose pose;
  std::vector<std::int32_t> field;
  double second = 0;  // voxels of the second bone
};

// Two boxes that share the face y = 0, hinged at its lower edge.
ByHand boxes(double folded) {
  return ByHand({0.06, 0.25, 0.06}, {0, 0, -0.07}, folded, [](const Vector3d& p) { return p.y() > 0; });
}

// A cube in the middle of a box, hinged so far below that it leaves its place altogether, within the box.
ByHand walled(double folded) {
  return ByHand({0.1, 0.25, 0.1}, {0, 0, -0.35}, folded, [](const Vector3d& p) { return p.cwiseAbs().maxCoeff() < 0.045; });
}

TEST(Unfolding, TwoBoxesThatSwingApartAreNotInEachOthersWay) {
  EXPECT_EQ(boxes(1.5).unfold(), 0);
  EXPECT_GT(boxes(-1.5).unfold(), 0.15);  // the other way they swing into each other
}

TEST(Unfolding, ABoneBetweenWallsIsInTheWayWithAllItsVolume) {
  const ByHand case_of = walled(0.4);
  const double share = case_of.second / double(case_of.target.inside.size());
  EXPECT_NEAR(case_of.unfold(), share, 2.0 / Unfolding::kSamples + 0.2 * share);
  EXPECT_EQ(walled(0).unfold(), 0);
}

TEST(Unfolding, OfTwoPartsTheSmallerIsInTheWayWhicheverOfThemTurns) {
  // The walls turn about the cube instead: what is lost is the cube, not the walls.
  ByHand turned({0.1, 0.25, 0.1}, {0, 0, -0.35}, 0.4, [](const Vector3d& p) { return p.cwiseAbs().maxCoeff() >= 0.045; });
  const double share = 1 - turned.second / double(turned.target.inside.size());
  EXPECT_NEAR(turned.unfold(), share, 2.0 / Unfolding::kSamples + 0.2 * share);
}

TEST(Unfolding, JointsOpenTogetherOrThoseNearerTheRootAhead) {
  EXPECT_EQ(Unfolding::opened(false, 1, 4, 0.3), 0.3);
  EXPECT_EQ(Unfolding::opened(false, 4, 4, 0.3), 0.3);
  EXPECT_NEAR(Unfolding::opened(true, 1, 4, 0.3), 0.6, 1e-12);
  EXPECT_EQ(Unfolding::opened(true, 4, 4, 0.3), 0);
  for (int depth = 1; depth <= 4; ++depth) EXPECT_EQ(Unfolding::opened(true, depth, 4, 1), 1);
}

TEST(Unfolding, IsTheSameEachTime) {
  const ByHand case_of = boxes(-1.5);
  Skeleton skeleton(case_of.character);
  skeleton.set(case_of.pose, unscaled(case_of.character));
  Unfolding unfolding(case_of.character, case_of.voxels);
  const double first = unfolding(skeleton, case_of.pose, case_of.field);
  EXPECT_EQ(unfolding(skeleton, case_of.pose, case_of.field), first);
}

TEST(Objective, WithoutAWeightUnfoldingIsNotLookedAtAndChangesNothing) {
  const Target target = box_target({0.25, 0.2, 0.15}, 32);
  const Character character = armed();
  ObjectiveWeights without;
  without.unfold = 0;
  Objective plain(character, target, without), whole(character, target, {});
  Random random(4);
  double most = 0;
  for (int k = 0; k < 20; ++k) {
    const Pose pose = random_pose(character, random, k < 15 ? 0.05 : 1);
    const ObjectiveTerms a = plain(pose, unscaled(character)), b = whole(pose, unscaled(character));
    EXPECT_EQ(a.unfold, 0);
    EXPECT_EQ(a.compact, b.compact);
    EXPECT_EQ(a.skin, b.skin);
    EXPECT_DOUBLE_EQ(a.total + ObjectiveWeights{}.unfold * b.unfold, b.total);
    most = std::max(most, b.unfold);
  }
  EXPECT_GT(most, 0);
  EXPECT_LE(most, 1);
}

}  // namespace
}  // namespace transformables
