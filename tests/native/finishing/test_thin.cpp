// Remains of carving that are too thin to be printed.
#include <gtest/gtest.h>

#include "cases.h"
#include "finishing/part_field.h"
#include "finishing/thin.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

// A block with a blade half a sample thick on it; the grid's step is 1 / 64.
finishing::PartField block_with_blade() {
  finishing::PartField part;
  part.psi = sampled_field(41, 1.0 / 64, [](const Vector3d& p) {
    return std::min(box_distance(p, {-0.15, -0.15, -0.15}, {0.05, 0.15, 0.15}), box_distance(p, {0, -0.1, -0.002}, {0.2, 0.1, 0.002}));
  });
  part.core = Grid<float>(part.psi.shape, 1);
  part.inner = part.uncarved = part.psi;
  part.away = Grid<finishing::Away>(part.psi.shape, {-1, -1});  // all within the target
  finishing::refresh(part);
  return part;
}

TEST(TakeThin, TakesABladeAndLeavesTheBlockWithItsEdges) {
  finishing::PartField part = block_with_blade();
  const Grid<float> before = part.psi;
  EXPECT_GT(finishing::take_thin(part, 0.012), 0u);
  for (std::size_t n = 0; n < before.values.size(); ++n) {
    const Vector3d p = part.psi.shape.position(n);
    EXPECT_GE(part.psi[n], before[n]);
    if (p.x() > 0.1) { EXPECT_GE(part.psi[n], 0); }
    if (p.x() < 0.05) { EXPECT_EQ(part.psi[n] < 0, before[n] < 0); }
  }
}

TEST(TakeThin, LeavesACore) {
  finishing::PartField part = block_with_blade();
  part.core = part.psi;
  EXPECT_EQ(finishing::take_thin(part, 0.012), 0u);
}

}  // namespace
}  // namespace transformables
