#include <gtest/gtest.h>

#include "segmentation/cases.h"

namespace transformables {
namespace {

using namespace cases;

TEST(Retiled, LeavesATilingAsItIs) {
  const Target target = sphere_target(32);
  const Posed posed = random_pose(target, 2);
  const Segmentation before = grown(posed, target);
  const Segmentation after = retiled(before, posed.character, target, posed.embedding);
  EXPECT_EQ(before.owner, after.owner);
  for (std::size_t b = 0; b < before.phi.size(); ++b) EXPECT_EQ(before.phi[b].values, after.phi[b].values);
}

TEST(Retiled, MendsRandomDamageAndOnlyThere) {
  const Target target = sphere_target(40);
  const Posed posed = random_pose(target, 3);
  const Segmentation before = grown(posed, target);
  Segmentation damaged = before;
  const Vector3d spot(0.1, 0.1, 0.1);
  std::mt19937 random(7);
  for (std::size_t i : target.inside)
    if ((before.shape.position(i) - spot).norm() < 0.05) damaged.owner[i] = std::int16_t(int(random() % 8) - 1);
  const Segmentation after = retiled(damaged, posed.character, target, posed.embedding);
  expect_tiling(after, posed, target);
  for (std::size_t i : target.inside) {
    if ((before.shape.position(i) - spot).norm() < 0.05 + 12 * before.shape.step) continue;
    ASSERT_EQ(before.owner[i], after.owner[i]);
    ASSERT_EQ(value(before.phi[before.owner[i]], before.shape, i), value(after.phi[before.owner[i]], after.shape, i));
  }
}

TEST(Retiled, GivesACutOffPieceToTheNeighbourAroundIt) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32);
  const Posed posed = half_boxes(target, 0);
  Segmentation s = cut_in_halves(posed, target);
  for (std::size_t i : target.inside)
    if ((s.shape.position(i) - Vector3d(0.1, 0.05, 0.05)).norm() < 0.035) s.owner[i] = 0;
  const Segmentation after = retiled(s, posed.character, target, posed.embedding);
  expect_tiling(after, posed, target);
  for (std::size_t i : target.inside)
    if (s.shape.position(i).x() > 2 * s.shape.step) {
      ASSERT_EQ(after.owner[i], 1);
    }
}

TEST(Retiled, FillsTheVoidOfARemovedPart) {
  const Target target = sphere_target(32);
  const Posed posed = random_pose(target, 5);
  Segmentation s = grown(posed, target);
  for (auto& o : s.owner)
    if (o == 3) o = -1;
  const Segmentation after = retiled(s, posed.character, target, posed.embedding);
  EXPECT_TRUE(after.phi[3].values.empty());
  for (std::size_t i : target.inside) ASSERT_TRUE(after.owner[i] >= 0 && after.owner[i] != 3);
}

TEST(Retiled, SmoothsAStaircase) {
  const Target target = box_target({0.25, 0.2, 0.2}, 48);
  const Posed posed = half_boxes(target, 0);
  Segmentation s = cut_in_halves(posed, target);
  for (std::size_t i : target.inside) s.owner[i] = s.shape.position(i).x() + 0.21 * s.shape.position(i).y() - 0.4 * s.shape.position(i).z() > 0.01;
  const Segmentation after = retiled(s, posed.character, target, posed.embedding);
  const auto curvatures = interface_curvatures(after, target);
  ASSERT_GT(curvatures.size(), 300u);
  EXPECT_LT(curvatures[curvatures.size() / 2], 0.06f);
  EXPECT_LT(curvatures[curvatures.size() * 95 / 100], 0.25f);
}

TEST(Retiled, RefusesForeignDataAndOwnersThatDoNotExist) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32), other = sphere_target(16);
  const Posed posed = half_boxes(target, 0);
  Segmentation s = cut_in_halves(posed, target);
  EXPECT_THROW(retiled(s, posed.character, other, posed.embedding), InvalidInput);
  Segmentation wrong = s;
  wrong.phi.pop_back();
  EXPECT_THROW(retiled(wrong, posed.character, target, posed.embedding), InvalidInput);
  wrong = s;
  wrong.owner[target.inside[5]] = 9;
  EXPECT_THROW(retiled(wrong, posed.character, target, posed.embedding), InvalidInput);
  wrong = s;
  std::fill(wrong.owner.begin(), wrong.owner.end(), std::int16_t(-1));
  EXPECT_THROW(retiled(wrong, posed.character, target, posed.embedding), InvalidInput);
  Target parted = box_target({0.25, 0.1, 0.1}, 32);
  std::erase_if(parted.inside, [&](std::size_t i) { return std::abs(s.shape.position(i).x() - 0.15) < 1.5 * s.shape.step; });
  wrong = s;
  for (std::size_t i = 0; i < wrong.owner.size(); ++i)
    if (s.shape.position(i).x() > 0.1) wrong.owner[i] = -1;
  EXPECT_THROW(retiled(wrong, posed.character, parted, posed.embedding), InvalidInput);
}

}  // namespace
}  // namespace transformables
