// Plan and transfer in turns, and what the folding room refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "cases.h"
#include "folding/carve_estimate.h"
#include "folding/cores.h"
#include "folding/transfer_along.h"

namespace transformables {
namespace {

TEST(Fold, NeverLeavesMoreToCarveThanThePlanAloneAndKeepsATiling) {
  for (const Made& m : {slab_in_the_way(), lidded(0), two_boxes(-kQuarter)}) {
    const Folding result = fold(m.segmentation, m.character, m.target, m.embedding, {}, {});
    EXPECT_LE(result.carving_after, result.carving_before);
    EXPECT_EQ(end_of(result.path, m.embedding.pose.angles).norm(), 0);
    for (std::size_t s = 0; s < m.segmentation.owner.size(); ++s) EXPECT_EQ(result.segmentation.owner[s] >= 0, m.target.distance[s] < 0);
    Made after = m;
    after.segmentation = result.segmentation;
    EXPECT_EQ(remeasured(result.path, after).overlap_volume, result.path.overlap_volume);
  }
}

// A base and four limbs that stand about in a box, each hinged somewhere on its skeleton and folded by any angle; a place belongs to the nearest skeleton.
Made limbs_at_random(unsigned seed) {
  std::mt19937 random(seed);
  const auto within = [&](double low, double high) { return low + (high - low) * double(random()) / double(std::mt19937::max()); };
  const Vector3d half{0.2, 0.12, 0.12};
  std::vector<MadeBone> bones{{-1, {0, 0, -0.09}, 0, {{-0.15, 0, -0.09}, {0.15, 0, -0.09}}, -1}};
  for (int limb = 0; limb < 4; ++limb) {
    const Vector3d a(within(-0.17, 0.17), within(-0.1, 0.1), within(-0.05, 0.1)), b(within(-0.17, 0.17), within(-0.1, 0.1), within(-0.05, 0.1));
    bones.push_back({0, a, within(-kQuarter, kQuarter), {a, b}, -1});
  }
  return made(bones, half, [bones](const Vector3d& p) {
    std::vector<double> to, apart;
    for (const MadeBone& bone : bones) to.push_back(distance(bone.skeleton, p));
    for (std::size_t i = 0; i < to.size(); ++i) {
      double other = 1;
      for (std::size_t j = 0; j < to.size(); ++j)
        if (j != i) other = std::min(other, to[j]);
      apart.push_back((to[i] - other) / 2);
    }
    return apart;
  }, 0.02);
}

// Samples that carving along a path takes.
long carved(const folding::Design& design, const FoldPath& path) {
  const FoldingOptions options;
  const std::vector<char> gone = folding::carving_of(design, design.segmentation.owner, folding::sampled_moves(design, path, options.largest_step_rad),
                                                     float(options.tolerance_steps));
  return std::count(gone.begin(), gone.end(), char(1));
}

TEST(Fold, NeverLeavesMoreToCarveThanThePapersGreedyOrderOnTheSameParts) {
  int better = 0;
  for (unsigned seed = 13; seed <= 24; ++seed) {
    Made m = limbs_at_random(seed);
    if (seed % 4) m.segmentation.pinned.assign(m.segmentation.owner.size(), 1);  // orders alone must do it then
    const Segmentation claimed = folding::with_skeletons({m.character, m.segmentation, m.target, m.embedding});
    const folding::Design design{m.character, claimed, m.target, m.embedding};
    FoldingOptions paper, options;
    paper.cost = MoveCost::kNetOverlap;
    options.expansions = seed % 2 ? 300 : 0;
    options.rounds = 2;
    const long greedy = carved(design, plan_greedy(claimed, m.character, m.target, m.embedding, paper, {}));
    const Folding result = fold(m.segmentation, m.character, m.target, m.embedding, options, {});
    const long ours = carved({m.character, result.segmentation, m.target, m.embedding}, result.path);
    EXPECT_LE(ours, greedy) << "seed " << seed;
    EXPECT_NEAR(result.carving_after, double(ours) * design.sample_volume(), 1e-12);
    better += ours < greedy;
  }
  EXPECT_GT(better, 4) << "where greedy needs nothing, nothing is shown";
}

TEST(TransferWays, LeaveHardlyMoreThanTheBetterOfThemAndOnlyTheFirstWhereThatIsNotWorthIt) {
  int freer = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Made m = limbs_at_random(seed);
    const folding::Design design{m.character, m.segmentation, m.target, m.embedding};
    const FoldPath path = greedy(m);
    const auto left = [&](const folding::TransferWays& ways) {
      TransferAlongResult result;
      folding::transferred_along(design, path, {}, {}, result, ways);
      return result.colliding_after;
    };
    const double both = left({}), first = left({.patience = {3}}), second = left({.patience = {0}});
    EXPECT_LE(both, std::min(first, second) / 0.97 + 1e-12) << "seed " << seed;
    EXPECT_LE(both, first);
    EXPECT_EQ(left({.worth = 0}), first);
    freer += both < first;
  }
  EXPECT_GT(freer, 0);
}

TEST(Fold, OpensAllJointsTogetherWhereNoneCanGoFirst) {
  Made m = interlocked();
  m.segmentation.pinned.assign(m.segmentation.owner.size(), 1);  // as an artist may demand: what holds them can't be given away
  const Folding result = fold(m.segmentation, m.character, m.target, m.embedding, {}, {});
  ASSERT_EQ(result.path.moves.size(), 1u);
  EXPECT_EQ(result.path.moves[0].turns.size(), 2u);
  EXPECT_EQ(end_of(result.path, m.embedding.pose.angles).norm(), 0);
  TransferAlongResult by_order;
  transfer_along(m.segmentation, m.character, m.target, m.embedding, best(m), {}, {}, &by_order);
  EXPECT_LT(result.carving_after, by_order.colliding_after);
}

TEST(Fold, WithoutRoundingTellsAsMuchOfCarvingAndIsATilingToo) {
  for (const Made& m : {slab_in_the_way(), two_boxes(-kQuarter)}) {
    FoldingOptions rough;
    rough.round_off = false;
    const Folding whole = fold(m.segmentation, m.character, m.target, m.embedding, {}, {}), result = fold(m.segmentation, m.character, m.target, m.embedding, rough, {});
    EXPECT_TRUE(std::equal(whole.path.moves.begin(), whole.path.moves.end(), result.path.moves.begin(), result.path.moves.end(),
                           [](const Move& a, const Move& b) { return a.turns.size() == b.turns.size(); }));
    EXPECT_NEAR(result.carving_after, whole.carving_after, 0.01 * m.target.volume);
    for (std::size_t s = 0; s < m.segmentation.owner.size(); ++s) EXPECT_EQ(result.segmentation.owner[s] >= 0, m.target.distance[s] < 0);
  }
}

TEST(Fold, GivesTheSameResultForOneAndTwoThreads) {
  const Made m = slab_in_the_way();
  FoldingOptions one, two;
  one.threads = 1, two.threads = 2;
  const Folding a = fold(m.segmentation, m.character, m.target, m.embedding, one, {}), b = fold(m.segmentation, m.character, m.target, m.embedding, two, {});
  EXPECT_TRUE(same(a.path, b.path));
  EXPECT_EQ(a.segmentation.owner, b.segmentation.owner);
}

TEST(Fold, RejectsAnImpossibleNumberOfRoundsAndStopsWhenToldTo) {
  const Made m = lidded(0);
  FoldingOptions none;
  none.rounds = 0;
  EXPECT_THROW(fold(m.segmentation, m.character, m.target, m.embedding, none, {}), InvalidInput);
  const Progress stop{[](double, std::string_view) { return false; }};
  EXPECT_THROW(fold(m.segmentation, m.character, m.target, m.embedding, {}, stop), Cancelled);
}

TEST(Errors, MismatchedInputsAreNamed) {
  const auto fails = [](const Made& m, const FoldingOptions& options = {}) {
    EXPECT_THROW(greedy(m, options), InvalidInput);
    EXPECT_THROW(best(m, options), InvalidInput);
    EXPECT_THROW(measured({}, m.segmentation, m.character, m.target, m.embedding, options), InvalidInput);
    EXPECT_THROW(transfer_along(m.segmentation, m.character, m.target, m.embedding, {}, options, {}), InvalidInput);
  };
  const Made good = lidded(-kQuarter);
  Made m = good;
  m.segmentation.frames.pop_back();
  fails(m);
  m = good;
  m.segmentation.owner.pop_back();
  fails(m);
  m = good;
  m.segmentation.owner[m.target.inside.front()] = -1;
  fails(m);
  m = good;
  m.embedding.pose.angles.resize(1);
  fails(m);
  m = good;
  m.embedding.pose.angles[0] = std::nan("");
  fails(m);
  m = good;
  m.segmentation.pinned.assign(3, 0);
  fails(m);
  m = good;
  m.segmentation.inhibited.assign(9, 0);
  fails(m);
  for (const double step : {0.0, -1.0, 5.0}) {
    FoldingOptions options;
    options.largest_step_rad = step;
    fails(good, options);
  }
  FoldingOptions options;
  options.beam_width = 0;
  fails(good, options);
  options = {};
  options.tolerance_steps = -1;
  fails(good, options);
  options = {};
  options.seconds = -1;
  fails(good, options);
}

TEST(Errors, APathOfAnotherEmbeddingIsRejected) {
  const Made m = lidded(-kQuarter);
  FoldPath path = greedy(m);
  path.moves[0].turns[0].from_rad += 0.5;
  EXPECT_THROW(remeasured(path, m), InvalidInput);
  EXPECT_THROW(transfer_along(m.segmentation, m.character, m.target, m.embedding, path, {}, {}), InvalidInput);
}

}  // namespace
}  // namespace transformables
