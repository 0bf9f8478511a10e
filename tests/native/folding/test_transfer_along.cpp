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

/// Two boxes, all of the right one but its far end taken by the left one: of its skeleton little more than an axis is left to it then.
Made rod_in_a_block() {
  return made({{-1, {-0.15, 0, 0}, 0, {{-0.2, 0.07, 0}, {-0.05, 0.07, 0}}, -1}, {0, {0, 0, 0.1}, -kQuarter, {{0.05, 0, 0}, {0.2, 0, 0}}, -1}}, {0.25, 0.1, 0.1},
              [](const Vector3d& p) {
                const double end = 0.19 - p.x();
                return std::vector<double>{-end, end};
              });
}

std::vector<std::size_t> samples_of_the_rod(const Made& m) {
  std::vector<std::size_t> samples;
  for (const std::size_t s : m.target.inside)
    if (distance(Segment{{0.05, 0, 0}, {0.2, 0, 0}}, m.segmentation.shape.position(s)) < 0.89 * m.character.bones[1].radius) samples.push_back(s);
  return samples;
}

TEST(TransferAlong, GivesABoneItsSkeletonBackThatANeighbourHad) {
  const Made m = rod_in_a_block();
  const std::vector<std::size_t> rod = samples_of_the_rod(m);
  const auto had = std::count_if(rod.begin(), rod.end(), [&](std::size_t s) { return m.segmentation.owner[s] == 1; });
  ASSERT_LT(had, long(rod.size()) / 2);
  const Segmentation after = transfer_along(m.segmentation, m.character, m.target, m.embedding, greedy(m), {}, {});
  for (const std::size_t s : rod) EXPECT_EQ(after.owner[s], 1);
  EXPECT_EQ(pieces(m, after.owner, 1), 1);
}

TEST(GivingWay, ASkeletonGivesNothingSoWhatItPassesThroughGoes) {
  Made m = rod_in_a_block();
  for (const std::size_t s : samples_of_the_rod(m)) m.segmentation.owner[s] = 1;
  const folding::Design design{m.character, m.segmentation, m.target, m.embedding};
  const folding::PairMotion there = folding::SampledMove(design, m.embedding.pose.angles, {{{0, -kQuarter, 0}}}, 0.05).pair(0, 1);
  const folding::Skeletons skeletons = folding::skeletons_of(design);
  const folding::Parts with = folding::parts_of(m.segmentation, m.target, 1, skeletons);
  const folding::GivingWay lost = folding::giving_way(with, 0, 1, there, 0.25f, true);
  EXPECT_EQ(lost.gone.size(), lost.samples);
  for (const std::uint32_t s : lost.gone) EXPECT_NE(skeletons.bone[s], 1) << "a skeleton is carved";
  // Without its skeleton the rod would be all that is lost.
  const std::size_t rod = samples_of_the_rod(m).size();
  EXPECT_LE(folding::giving_way(folding::parts_of(m.segmentation, m.target), 0, 1, there, 0.25f, false).samples, with.samples[1].points.size());
  EXPECT_GT(lost.samples, 2 * rod);
  EXPECT_EQ(folding::giving_way(with, 0, 1, there, 0.25f, false).samples, lost.samples) << "telling which changes nothing";
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
