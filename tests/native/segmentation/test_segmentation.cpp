// The room as a whole: what holds for every pose, after all that is done to a segmentation.
#include <gtest/gtest.h>

#include "segmentation/edits.h"
#include "segmentation/cases.h"

namespace transformables {
namespace {

using namespace cases;

std::vector<JointRange> some_ranges(const Posed& posed) {
  std::vector<JointRange> ranges;
  for (int b = 1; b < int(posed.character.bones.size()); ++b) ranges.push_back({b, 0, 0, b % 2 ? 1.5 : -1.2});
  return ranges;
}

TEST(Segmentation, TilesTheTargetForRandomPosesAfterGrowthAndTransfer) {
  const auto targets = some_targets();
  for (unsigned seed = 11; seed <= 22; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    const Segmentation s = grown(posed, target);
    expect_tiling(s, posed, target);
    const Segmentation after = transfer(s, posed.character, target, posed.embedding, some_ranges(posed), {}, {});
    expect_tiling(after, posed, target);
  }
}

TEST(Segmentation, KeepsTheWholeVolumeInTransfer) {
  const Target target = box_target({0.25, 0.2, 0.25}, 32);
  for (unsigned seed = 31; seed <= 34; ++seed) {
    SCOPED_TRACE(seed);
    const Posed posed = random_pose(target, seed);
    const Segmentation before = grown(posed, target);
    const Segmentation after = transfer(before, posed.character, target, posed.embedding, some_ranges(posed), {}, {});
    for (std::size_t i = 0; i < before.owner.size(); ++i) ASSERT_EQ(before.owner[i] >= 0, after.owner[i] >= 0);
  }
}

// Bones at random in one arm of a U, and a foot: nothing of the arm's bones may show in the other arm above the base.
TEST(Segmentation, NeverLetsAPartCrossTheGapOfAU) {
  const Target target = u_target(40);
  for (unsigned seed = 41; seed <= 46; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto between = [&](double a, double b) { return a + (b - a) * (random() / 4294967296.0); };
    std::vector<ArmatureBone> bones{bone("foot", -1, {0.2, 0, -0.2}, {-0.1, 0, -0.2}, Vector3d::UnitY())};
    for (int k = 0; k < 3; ++k)
      bones.push_back(bone("arm" + std::to_string(k), k, bones.back().tail, {between(-0.2, -0.06), between(-0.06, 0.06), -0.1 + 0.1 * k}, Vector3d::UnitY()));
    bones.push_back(bone("hand", 3, bones.back().tail, {between(-0.12, -0.05), 0, 0.2}, Vector3d::UnitY()));
    const Posed posed = as_given(bones, target);
    const Segmentation s = grown(posed, target);
    expect_tiling(s, posed, target);
    for (std::size_t i : target.inside) {
      const Vector3d p = s.shape.position(i);
      if (p.x() > 0.03 && p.z() > -0.05) {
        ASSERT_EQ(s.owner[i], 0) << p.transpose();
      }
    }
  }
}

}  // namespace
}  // namespace transformables
