// Plan and transfer in turns, and what the folding room refuses.
#include <gtest/gtest.h>

#include <cmath>

#include "cases.h"
#include "folding/carve_estimate.h"
#include "folding/cores.h"

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
