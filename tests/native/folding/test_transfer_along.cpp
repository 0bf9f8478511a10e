// Parts that give way to each other along a path, and what smooths their interfaces, on designs made by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "cases.h"
#include "folding/carve_estimate.h"
#include "folding/cores.h"
#include "folding/smoothing.h"

namespace transformables {
namespace {

TEST(TransferAlong, GivesASlabInTheWayToThePartThatPushesIt) {
  Made m = slab_in_the_way();
  const FoldPath path = greedy(m);
  ASSERT_GT(path.overlap_volume, 0.001);
  TransferAlongResult result;
  const Segmentation after = transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {}, &result);
  EXPECT_GT(result.colliding_before, 0.001);
  EXPECT_LT(result.colliding_after, 0.03 * result.colliding_before);
  EXPECT_GT(result.moved_volume, 0.001);
  for (std::size_t s = 0; s < after.owner.size(); ++s) EXPECT_EQ(after.owner[s] >= 0, m.target.distance[s] < 0);
  EXPECT_EQ(pieces(m, after.owner, 0), 1);
  EXPECT_EQ(pieces(m, after.owner, 1), 1);
  m.segmentation = after;
  EXPECT_LT(remeasured(path, m).overlap_volume, 0.05 * path.overlap_volume);
}

TEST(TransferAlong, LeavesADesignAloneThatOpensFreely) {
  const Made m = lidded(-kQuarter);
  TransferAlongResult result;
  const Segmentation after = transfer_along(m.segmentation, m.character, m.target, m.embedding, greedy(m), {}, {}, &result);
  EXPECT_EQ(after.owner, m.segmentation.owner);
  EXPECT_EQ(result.moved_volume, 0);
}

TEST(TransferAlong, GivesTheSameResultForOneAndTwoThreads) {
  const Made m = slab_in_the_way();
  FoldingOptions one, two;
  one.threads = 1, two.threads = 2;
  const FoldPath path = greedy(m);
  EXPECT_EQ(transfer_along(m.segmentation, m.character, m.target, m.embedding, path, one, {}).owner,
            transfer_along(m.segmentation, m.character, m.target, m.embedding, path, two, {}).owner);
}

TEST(TransferAlong, KeepsEverySkeletonWithItsBone) {
  const Made m = slab_in_the_way();
  const Segmentation after = transfer_along(m.segmentation, m.character, m.target, m.embedding, greedy(m), {}, {});
  for (const std::size_t s : m.target.inside)
    EXPECT_TRUE(after.owner[s] == 0 || distance(Segment{{-0.15, 0, -0.08}, {0.15, 0, -0.08}}, m.segmentation.shape.position(s)) > 0.01);
}

// The bone that gives most away in a transfer along the greedy path, and the one that takes it.
std::pair<int, int> giver_and_taker(const Made& m, const Segmentation& after) {
  std::map<std::pair<int, int>, int> moved;
  for (std::size_t s : m.target.inside)
    if (after.owner[s] != m.segmentation.owner[s]) ++moved[{m.segmentation.owner[s], after.owner[s]}];
  EXPECT_FALSE(moved.empty()) << "nothing is transferred here at all";
  if (moved.empty()) return {0, 1};
  return std::max_element(moved.begin(), moved.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
}

TEST(TransferAlong, LeavesWhatIsPinnedWithItsBone) {
  Made m = slab_in_the_way();
  const FoldPath path = greedy(m);
  const auto [giver, taker] = giver_and_taker(m, transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {}));
  m.segmentation.pinned.assign(m.segmentation.owner.size(), 0);
  for (std::size_t s : m.target.inside) m.segmentation.pinned[s] = m.segmentation.owner[s] == giver;
  const Segmentation after = transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {});
  for (std::size_t s : m.target.inside)
    if (m.segmentation.pinned[s]) {
      ASSERT_EQ(after.owner[s], giver);
    }
  const Folding folding = fold(m.segmentation, m.character, m.target, m.embedding, {}, {});
  for (std::size_t s : m.target.inside)
    if (m.segmentation.pinned[s]) {
      ASSERT_EQ(folding.segmentation.owner[s], giver);
    }
}

TEST(TransferAlong, GivesNothingToABoneThatIsInhibited) {
  Made m = two_boxes(-kQuarter);
  const FoldPath path = greedy(m);
  const auto [giver, taker] = giver_and_taker(m, transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {}));
  m.segmentation.inhibited.assign(m.character.bones.size(), 0);
  m.segmentation.inhibited[std::size_t(taker)] = 1;
  const Segmentation after = transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {});
  std::size_t gained = 0, had = 0;
  for (std::size_t s : m.target.inside) {
    had += m.segmentation.owner[s] == taker;
    gained += after.owner[s] == taker && m.segmentation.owner[s] != taker;
  }
  EXPECT_GT(had, 100u);
  EXPECT_LT(double(gained), 0.02 * double(had)) << "rounding of the interfaces apart";
}

// Teeth of one sample on every third sample of the interface, and an island.
std::vector<std::int16_t> roughened(const Made& m) {
  std::vector<std::int16_t> owner = m.segmentation.owner;
  const GridShape& g = m.segmentation.shape;
  for (const std::size_t s : m.target.inside) {
    const Eigen::Vector3d p = g.position(s);
    if (owner[s] == 0 && p.x() > -g.step && (g.cell(s).y() + g.cell(s).z()) % 3 == 0) owner[s] = 1;
    if ((p - Eigen::Vector3d(0.12, 0.08, 0.08)).norm() < 1.2 * g.step) owner[s] = std::int16_t(1 - owner[s]);
  }
  return owner;
}

// Faces between samples of different owners.
int faces_between(const Made& m, const std::vector<std::int16_t>& owner) {
  const GridShape& g = m.segmentation.shape;
  int count = 0;
  for (const std::size_t s : m.target.inside)
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3i c = g.cell(s);
      ++c[axis];
      if (g.contains(c) && owner[g.index(c)] >= 0) count += owner[g.index(c)] != owner[s];
    }
  return count;
}

folding::Design design_of(const Made& m) { return {m.character, m.segmentation, m.target, m.embedding}; }

TEST(Smoothing, TakesTeethAndIslandsAwayWhereNothingForbidsIt) {
  const Made m = two_boxes(-kQuarter);
  const std::vector<std::int16_t> rough = roughened(m), none(rough.size(), -1);
  ASSERT_GT(faces_between(m, rough), faces_between(m, m.segmentation.owner));
  const auto smooth = folding::smoothed_owners(design_of(m), rough, none, {}, 0.25f);
  EXPECT_EQ(faces_between(m, smooth), faces_between(m, m.segmentation.owner));
  for (std::size_t s = 0; s < smooth.size(); ++s) EXPECT_EQ(smooth[s] >= 0, m.segmentation.owner[s] >= 0);
}

TEST(Smoothing, LeavesCoresAlone) {
  const Made m = two_boxes(-kQuarter);
  const std::vector<std::int16_t> rough = roughened(m);
  EXPECT_EQ(folding::smoothed_owners(design_of(m), rough, rough, {}, 0.25f), rough);
}

TEST(Smoothing, MakesNothingCollideThatDidNot) {
  Made m = slab_in_the_way();
  const FoldPath path = greedy(m);
  m.segmentation = transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {});
  const folding::Design design = design_of(m);
  const auto moves = folding::sampled_moves(design, path, FoldingOptions{}.largest_step_rad);
  const auto colliding = [&](const std::vector<std::int16_t>& owner) {
    const std::vector<char> gone = folding::carving_of(design, owner, moves, 0.25f);
    return std::count(gone.begin(), gone.end(), char(1));
  };
  const auto smooth = folding::smoothed_owners(design, m.segmentation.owner, folding::cores_of(design), moves, 0.25f);
  EXPECT_LE(colliding(smooth), colliding(m.segmentation.owner));
  EXPECT_LE(faces_between(m, smooth), faces_between(m, m.segmentation.owner));
}

}  // namespace
}  // namespace transformables
