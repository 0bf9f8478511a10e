// The order of the moves, on designs made by hand: overlaps, the greedy choice, the search, samples and ranges of a path.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cases.h"
#include "folding/distance_transform.h"
#include "folding/motion.h"
#include "folding/overlap.h"

namespace transformables {
namespace {

TEST(PartField, IsTheDistanceToABoxWithinAndAround) {
  const Made m = two_boxes(kQuarter);
  const folding::PartField field(m.segmentation.owner, m.segmentation.shape, 1);
  const auto lattice = [&](const Vector3d& p) { return Eigen::Vector3f(((p - m.segmentation.shape.origin) / m.segmentation.shape.step).cast<float>()); };
  for (const Vector3d& p : {Vector3d(0.1, 0, 0), Vector3d(-0.1, 0.03, 0.02), Vector3d(0.12, 0, 0.3), Vector3d(0.5, 0.4, 0.3)}) {
    const double deepest = -(folding::kDeepest - 0.5);  // farther inside it does not tell
    const double truth = std::max(deepest, box_distance(p - Vector3d(0.125, 0, 0), {0.125, 0.1, 0.1}) / m.segmentation.shape.step);
    EXPECT_LE(field.at(lattice(p)), truth + 0.6) << p.transpose();  // never more: a move steps by it
    EXPECT_GE(field.at(lattice(p)), 0.9 * truth - 0.6) << p.transpose();
  }
  EXPECT_TRUE(folding::PartField(m.segmentation.owner, m.segmentation.shape, 7).empty());
}

TEST(Overlap, SkippingConfigurationsMissesNothingThatTryingAllFinds) {
  const Made m = two_boxes(-kQuarter);
  const folding::Design design{m.character, m.segmentation, m.target, m.embedding};
  const folding::SampledMove move(design, m.embedding.pose.angles, {{{0, -kQuarter, 0}}}, 0.05);
  const folding::Parts parts = folding::parts_of(m.segmentation, m.target);
  const folding::PairMotion motion = move.pair(1, 0);
  std::vector<char> hit;
  folding::swept_samples(parts.samples[1], parts.fields[0], motion, 0.25f, &hit);
  std::size_t wrong = 0, found = 0;
  for (std::size_t i = 0; i < hit.size(); ++i) {
    bool ever = false;
    for (const auto& a_to_b : motion.a_to_b) ever = ever || parts.fields[0].at(a_to_b(parts.samples[1].points[i])) < -0.25f;
    wrong += ever != bool(hit[i]);
    found += ever;
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(found, 500u);
}

TEST(Overlap, CountingByBricksGivesWhatLookingAtEverySampleGives) {
  const Made m = lidded(-kQuarter);
  const folding::Parts parts = folding::parts_of(m.segmentation, m.target);
  std::size_t found = 0;
  for (int n = 0; n < 60; ++n) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.rotate(Eigen::AngleAxisd(0.1 * n, Vector3d(std::cos(n), std::sin(n), 0.5).normalized()));
    motion.pretranslate(0.05 * Vector3d(std::sin(3.0 * n), std::cos(5.0 * n), std::sin(7.0 * n)));
    const folding::Rigid a_to_b = folding::in_lattice_units(motion, m.segmentation.shape);
    const auto& points = parts.samples[std::size_t(n % 3)].points;
    const auto& field = parts.fields[std::size_t((n + 1) % 3)];
    const auto every = std::size_t(std::count_if(points.begin(), points.end(), [&](const auto& p) { return field.at(a_to_b(p)) < -0.25f; }));
    EXPECT_EQ(folding::overlapping_samples(parts.samples[std::size_t(n % 3)], field, a_to_b, 0.25f), every) << n;
    found += every;
  }
  EXPECT_GT(found, 10000u);
}

TEST(Overlap, OfSamplesTakenSparselyIsTheSameShareOfAll) {
  const Made m = two_boxes(-kQuarter);
  const folding::Design design{m.character, m.segmentation, m.target, m.embedding};
  const folding::PairMotion motion = folding::SampledMove(design, m.embedding.pose.angles, {{{0, -kQuarter, 0}}}, 0.05).pair(1, 0);
  const folding::Parts all = folding::parts_of(m.segmentation, m.target), few = folding::parts_of(m.segmentation, m.target, 2);
  const double of_all = double(folding::swept_samples(all.samples[1], all.fields[0], motion, 0.25f));
  const double of_few = double(folding::swept_samples(few.samples[1], few.fields[0], motion, 0.25f));
  EXPECT_NEAR(8 * of_few / of_all, 1, 0.15);
  EXPECT_EQ(folding::swept_samples(all.samples[1], all.fields[0], motion, 0.25f, nullptr, 10), 10u) << "counting ends when it is enough";
}

TEST(Greedy, FindsNoOverlapWhenAHingeOpensFreely) {
  const FoldPath path = greedy(two_boxes(kQuarter));
  ASSERT_EQ(path.moves.size(), 1u);
  EXPECT_TRUE(path.collisions.empty());
  EXPECT_EQ(path.overlap_volume, 0);
}

TEST(Greedy, MeasuresTheVolumeThatOneBoxTurnsIntoAnother) {
  const Made m = two_boxes(-kQuarter);
  const FoldPath path = greedy(m);
  // At the end the 0.25 x 0.2 x 0.2 box stands upright, 0.2 x 0.2 x 0.2 of it inside the other.
  ASSERT_EQ(path.collisions.size(), 1u);
  EXPECT_NEAR(path.collisions[0].volume, 0.008, 0.0008);
  EXPECT_GE(path.overlap_volume, path.collisions[0].volume * 0.95);
  EXPECT_LE(path.overlap_volume, 0.01);
  EXPECT_EQ(path.collisions[0].bone_a, 0);
  EXPECT_EQ(path.collisions[0].bone_b, 1);
}

TEST(Measured, ACollisionSaysWhatItCostsAndWhereOnTheFirstOfTheTwoItIs) {
  const Made m = two_boxes(-kQuarter);
  const Collision c = greedy(m).collisions.at(0);
  EXPECT_GE(c.swept, 0.95 * c.volume);
  EXPECT_LE(c.swept, 0.01);
  ASSERT_TRUE(c.place);
  // The first box stands where it stood; what the other sweeps of it is its right end.
  const Vector3d place = m.segmentation.frames[0] * *c.place;
  EXPECT_LT(box_distance(place - Vector3d(-0.1, 0, 0), {0.1, 0.1, 0.1}), 1e-9);
  EXPECT_NEAR(place.y(), 0, 0.02);
}

TEST(Greedy, OpensTheLidBeforeWhatLiesUnderIt) {
  const Made m = lidded(-kQuarter);
  for (const MoveCost cost : {MoveCost::kSweptVolume, MoveCost::kNetOverlap}) {
    FoldingOptions options;
    options.cost = cost;
    const FoldPath path = greedy(m, options);
    ASSERT_EQ(path.moves.size(), 2u);
    EXPECT_EQ(path.moves[0].turns[0].angle, 1);
    EXPECT_EQ(path.overlap_volume, 0);
    FoldPath wrong = path;
    std::swap(wrong.moves[0], wrong.moves[1]);
    EXPECT_GT(remeasured(wrong, m).overlap_volume, 0.001);
  }
}

TEST(Greedy, EndsWithEveryHingeAtRestAndTurnsNoneThatIsThereAlready) {
  const Made m = lidded(0);
  const FoldPath path = greedy(m);
  EXPECT_EQ(path.moves.size(), 1u);
  EXPECT_EQ(end_of(path, m.embedding.pose.angles).norm(), 0);
}

TEST(Plan, MovesALidAsideAndBackWhereGreedyCollides) {
  const Made m = lidded(0);
  const FoldPath first = greedy(m), searched = best(m);
  EXPECT_GT(first.overlap_volume, 0.001);
  EXPECT_EQ(searched.overlap_volume, 0);
  EXPECT_EQ(end_of(searched, m.embedding.pose.angles).norm(), 0);
}

TEST(Plan, IsNeverWorseThanGreedyWhateverTheBudget) {
  for (const double lid : {-kQuarter, 0.0, -0.4})
    for (const int expansions : {0, 3, 50, 2000}) {
      const Made m = lidded(lid);
      FoldingOptions options;
      options.expansions = expansions;
      EXPECT_LE(best(m, options).overlap_volume, greedy(m, options).overlap_volume);
    }
}

TEST(Plan, ThatIsOutOfTimeTakesTheBestSoFarAndSaysSo) {
  const Made m = lidded(0);
  FoldingOptions hurried, patient;
  hurried.seconds = 1e-9, patient.seconds = 1e6;
  const FoldPath path = best(m, hurried);
  EXPECT_TRUE(path.cut_short);
  EXPECT_EQ(end_of(path, m.embedding.pose.angles).norm(), 0);
  EXPECT_LE(path.overlap_volume, greedy(m).overlap_volume);
  EXPECT_TRUE(fold(m.segmentation, m.character, m.target, m.embedding, hurried, {}).path.cut_short);
  EXPECT_FALSE(best(m, patient).cut_short);
  EXPECT_TRUE(same(best(m, patient), best(m)));
}

TEST(Plan, StaysWithinTheLimitsOfEveryHinge) {
  const Made m = lidded(0);
  for (const Move& move : best(m).moves)
    for (const auto& turn : move.turns) EXPECT_LE(std::abs(turn.to_rad), kQuarter + 1e-12);
}

TEST(Plan, TurnsAMirroredPairTogetherWhenTheEmbeddingIsSymmetric) {
  Made m = doors();
  for (const FoldPath& path : {greedy(m), best(m)}) {
    ASSERT_EQ(path.moves.size(), 1u);
    EXPECT_EQ(path.moves[0].turns.size(), 2u);
    EXPECT_EQ(end_of(path, m.embedding.pose.angles).norm(), 0);
  }
  FoldingOptions apart;
  apart.mirrored_together = false;
  EXPECT_EQ(greedy(m, apart).moves.size(), 2u);
  m.embedding.symmetric = false;
  EXPECT_EQ(greedy(m).moves.size(), 2u);
}

TEST(Plan, GivesTheSameResultForOneAndTwoThreads) {
  const Made m = lidded(0);
  FoldingOptions one, two;
  one.threads = 1, two.threads = 2;
  EXPECT_TRUE(same(best(m, one), best(m, two)));
  EXPECT_TRUE(same(greedy(m, one), greedy(m, two)));
}

TEST(Plan, StopsWhenItIsToldTo) {
  const Made m = lidded(0);
  const Progress stop{[](double, std::string_view) { return false; }};
  EXPECT_THROW(plan(m.segmentation, m.character, m.target, m.embedding, {}, stop), Cancelled);
  EXPECT_THROW(plan_greedy(m.segmentation, m.character, m.target, m.embedding, {}, stop), Cancelled);
}

TEST(Sampled, NeverTurnsAHingeFartherThanTheStepAndVisitsEveryWaypoint) {
  const Made m = lidded(-kQuarter);
  const FoldPath path = greedy(m);
  for (const double step : {0.01, 0.05, 0.3}) {
    const PathSamples samples = sampled(path, m.embedding.pose.angles, step);
    ASSERT_EQ(samples.angles.size(), samples.move.size());
    EXPECT_EQ(samples.angles.front(), m.embedding.pose.angles);
    EXPECT_EQ(samples.angles.back().norm(), 0);
    for (std::size_t i = 1; i < samples.angles.size(); ++i) {
      EXPECT_LE((samples.angles[i] - samples.angles[i - 1]).cwiseAbs().maxCoeff(), step * (1 + 1e-9));
      EXPECT_GE(samples.move[i], samples.move[i - 1]);
      const bool between = samples.move[i] == 1 && samples.move[i - 1] == 0;
      EXPECT_TRUE(!between || samples.angles[i - 1][path.moves[0].turns[0].angle] == 0);
    }
  }
}

TEST(Sampled, RejectsABadStepAndAPathThatDoesNotFit) {
  const Made m = lidded(-kQuarter);
  const FoldPath path = greedy(m);
  EXPECT_THROW(sampled(path, m.embedding.pose.angles, 0), InvalidInput);
  EXPECT_THROW(sampled(path, m.embedding.pose.angles, std::nan("")), InvalidInput);
  EXPECT_THROW(sampled(path, Eigen::VectorXd::Zero(2), 0.05), InvalidInput);
  EXPECT_THROW(sampled(path, Eigen::VectorXd::Zero(1), 0.05), InvalidInput);
}

TEST(Ranges, SpanAllThatAPathAsksOfAHinge) {
  const Made m = lidded(-kQuarter);
  FoldPath path;
  path.moves = {{{{1, -kQuarter, 0.5}}}, {{{0, kQuarter, 0}}}, {{{1, 0.5, 0}}}};
  const auto ranges = ranges_of(path, m.character);
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[0].bone, 2);
  EXPECT_EQ(ranges[0].from_rad, -kQuarter);
  EXPECT_EQ(ranges[0].to_rad, 0.5);
  EXPECT_EQ(ranges[1].bone, 1);
  EXPECT_EQ(ranges[1].from_rad, kQuarter);
  EXPECT_EQ(ranges[1].to_rad, 0);
  path.moves[0].turns[0].angle = 9;
  EXPECT_THROW(ranges_of(path, m.character), InvalidInput);
}

TEST(Ranges, OfStraightUnfoldingGoFromTheFoldedAngleToRest) {
  Made m = lidded(-kQuarter);
  const auto ranges = straight_ranges(m.character, m.embedding);
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[0].from_rad, kQuarter);
  EXPECT_EQ(ranges[1].from_rad, -kQuarter);
  EXPECT_EQ(ranges[1].to_rad, 0);
  m.embedding.pose.angles.resize(5);
  EXPECT_THROW(straight_ranges(m.character, m.embedding), InvalidInput);
}

}  // namespace
}  // namespace transformables
