// Room embedding: the whole stage.
#include "cases.h"

#include <thread>

namespace transformables {
namespace {

TEST(Embed, FoldsAChainIntoABoxThatItIsTooLongFor) {
  const Target target = box_target({0.25, 0.2, 0.15}, 32);
  const Character character = chain(5, 0.2, 0.018, {0, -2.2, 2.2});
  const Embedding embedding = embed(character, target, quick(), {});
  EXPECT_LT(embedding.deepest_protrusion, target.distance.shape.step);
  EXPECT_LT(embedding.deepest_collision, 0.2 * target.distance.shape.step);
  const ObjectiveTerms again = Objective(character, target, {})(embedding.pose, embedding.morphology);
  EXPECT_EQ(again.total, embedding.terms.total);
  const ObjectiveTerms& t = embedding.terms;
  EXPECT_NEAR(t.total, t.compact + t.skin + 1e3 * (t.skeleton + t.protrude) + t.limits + 0.01 * t.morphology + 300 * t.unfold, 1e-9 * t.total);
}

TEST(Embed, IsTheSameForAnyNumberOfThreadsAndDiffersBySeed) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = armed();
  EmbeddingOptions options = quick();
  options.threads = 1;
  const Embedding one = embed(character, target, options, {});
  options.threads = 2;
  const Embedding two = embed(character, target, options, {});
  EXPECT_EQ(one.pose.angles, two.pose.angles);
  EXPECT_EQ(one.pose.root.matrix(), two.pose.root.matrix());
  EXPECT_EQ(one.morphology, two.morphology);
  EXPECT_EQ(one.evaluations, two.evaluations);
  options.seed = 1;
  EXPECT_NE(embed(character, target, options, {}).pose.angles, one.pose.angles);
}

TEST(Embed, IsSymmetricWhenBothAreAndNotWhenToldSo) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = armed();
  EmbeddingOptions options = quick();
  options.evaluations = 300;
  const Embedding on = embed(character, target, options, {});
  EXPECT_TRUE(on.symmetric);
  const auto frames = forward_kinematics(character, on.pose, on.morphology);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Vector3d head = frames[i].translation(), other = frames[std::size_t(character.bones[i].mirror)].translation();
    EXPECT_LT((Vector3d(-head.x(), head.y(), head.z()) - other).norm(), 1e-6);
  }
  options.symmetry = Symmetry::kOff;
  EXPECT_FALSE(embed(character, target, options, {}).symmetric);
}

TEST(Embed, GivesSymmetryUpWhereOnlyAnAsymmetricPoseFitsUnlessToldToKeepIt) {
  // The shoulders are 0.12 apart, at least 0.07 when scaled; the slab's two sides that mirror each other only 0.06.
  const Target target = box_target({0.03, 0.25, 0.12}, 32);
  EmbeddingOptions options = quick();
  const Embedding free = embed(armed(), target, options, {});
  EXPECT_FALSE(free.symmetric);
  EXPECT_LT(free.deepest_protrusion, target.distance.shape.step);
  options.symmetry = Symmetry::kOn;
  const Embedding both = embed(armed(), target, options, {});
  EXPECT_TRUE(both.symmetric);
  EXPECT_GT(both.deepest_protrusion, target.distance.shape.step);
}

TEST(Embed, KeepsProportionsWhenToldSo) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  EmbeddingOptions options = quick();
  options.evaluations = 200;
  options.proportions = false;
  EXPECT_EQ(embed(armed(), target, options, {}).morphology, unscaled(armed()));
}

TEST(Embed, FromAGivenPoseItEndsNoWorseAndTellsEachBetterOneInTheCallersThread) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(3, 0.12, 0.018);
  Embedding start;
  start.pose = pose_at(character, {0, -0.18, 0});
  start.morphology = unscaled(character);
  Objective objective(character, target, {});
  const double before = objective(start.pose, start.morphology).total;
  const auto caller = std::this_thread::get_id();
  int told = 0;
  EmbeddingOptions options = quick();
  options.evaluations = 400;
  const Embedding end = embed(character, target, options, {}, start, [&](const Embedding& best) {
    ++told;
    EXPECT_EQ(std::this_thread::get_id(), caller);
    EXPECT_EQ(best.pose.angles.size(), character.angle_count);
  });
  EXPECT_LE(end.terms.total, before);
  EXPECT_GT(told, 1);
  EXPECT_LE(end.evaluations, 400);
}

TEST(Embed, FromAGivenPoseItGoesOnUntilItsBudgetIsUsedThoughItConvergesLongBefore) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(3, 0.12, 0.018);
  Embedding start;
  start.pose = pose_at(character, {0, -0.18, 0});
  start.morphology = unscaled(character);
  EmbeddingOptions options;
  options.proportions = false;
  options.symmetry = Symmetry::kOff;
  options.evaluations = 4000;
  options.pinned = {{0, start.pose.root}};  // leaves two angles
  const Embedding end = embed(character, target, options, {}, start);
  EXPECT_GT(end.evaluations, 3500);
  EXPECT_LE(end.evaluations, 4000);
}

TEST(Embed, ShowsWhereItIsWithoutBeingChangedByIt) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = armed();
  EmbeddingOptions options = quick();
  const Embedding unseen = embed(character, target, options, {});
  int shown = 0;
  options.trying = [&](const Embedding& e) {
    ++shown;
    EXPECT_EQ(e.pose.angles.size(), character.angle_count);
    EXPECT_EQ(e.morphology.size(), Eigen::Index(character.bones.size()));
  };
  const Embedding seen = embed(character, target, options, {});
  EXPECT_GT(shown, 0);
  EXPECT_EQ(seen.pose.angles, unseen.pose.angles);
  EXPECT_EQ(seen.terms.total, unseen.terms.total);
}

TEST(Embed, StopsWhenAsked) {
  const Target target = box_target({0.25, 0.2, 0.15});
  const Character character = armed();
  int ticks = 0;
  const Progress progress{[&](double fraction, std::string_view) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    return ++ticks < 5;
  }};
  EXPECT_THROW(embed(character, target, {}, progress), Cancelled);
  EXPECT_EQ(ticks, 5) << "it does not go on to where it would ask again";
}

TEST(Embed, AsksWhetherToStopAfterAFewEvaluations) {
  const Target target = box_target({0.25, 0.2, 0.15}, 64);
  EmbeddingOptions options = quick();
  options.threads = 1;
  long asked = 0;
  const Progress progress{[&](double, std::string_view) { return ++asked > 0; }};
  const Embedding found = embed(armed(), target, options, progress);
  EXPECT_GE(asked, found.evaluations / 16) << "an evaluation takes a millisecond or two";
}

TEST(Embed, RefusesOptionsOutOfRange) {
  const Target target = box_target({0.25, 0.2, 0.15}, 24);
  const Character character = chain(3, 0.12, 0.018);
  const auto refused = [&](auto change) {
    EmbeddingOptions options = quick();
    change(options);
    EXPECT_THROW(embed(character, target, options, {}), InvalidInput);
  };
  refused([](EmbeddingOptions& o) { o.runs = 0; });
  refused([](EmbeddingOptions& o) { o.starts = 0; });
  refused([](EmbeddingOptions& o) { o.evaluations = 0; });
  refused([](EmbeddingOptions& o) { o.threads = -1; });
  refused([](EmbeddingOptions& o) { o.least_scale = 0; });
  refused([](EmbeddingOptions& o) { o.least_scale = 1.2; });
  refused([](EmbeddingOptions& o) { o.largest_scale = 0.9; });
  refused([](EmbeddingOptions& o) { o.weights.skin = -1; });
  refused([](EmbeddingOptions& o) { o.locked = {{99, 0}}; });
  refused([](EmbeddingOptions& o) { o.locked = {{-1, 0}}; });
  refused([](EmbeddingOptions& o) { o.locked = {{0, 0}, {0, 1}}; });
  refused([](EmbeddingOptions& o) { o.locked = {{0, std::nan("")}}; });
  refused([](EmbeddingOptions& o) { o.pinned = {{3, Eigen::Isometry3d::Identity()}}; });
  refused([](EmbeddingOptions& o) {
    o.pinned = {{0, Eigen::Isometry3d::Identity()}};
    o.pinned[0].frame.linear() *= 2;
  });
  refused([](EmbeddingOptions& o) {  // nothing is left to be searched
    o.pinned = {{0, Eigen::Isometry3d::Identity()}};
    o.locked = {{0, 0.5}, {1, -0.5}};
    o.proportions = false;
  });
  refused([](EmbeddingOptions& o) { o.proportion_of = {{0, 0, 1}}; });
  refused([](EmbeddingOptions& o) { o.proportion_of = {{0, 1.2, 1.1}}; });
  refused([](EmbeddingOptions& o) { o.weights.skeleton = std::nan(""); });
  refused([](EmbeddingOptions& o) { o.painted = {{3, {}}}; });
  refused([](EmbeddingOptions& o) { o.painted = {{-2, {}}}; });
  refused([](EmbeddingOptions& o) { o.painted = {{0, {{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Constant(std::nan(""))}}}}; });
}

TEST(Embed, RefusesSymmetryWithoutMirrorPlanesAndAStartOfAnotherCharacter) {
  Target target = box_target({0.25, 0.2, 0.15}, 24);
  EmbeddingOptions options = quick();
  options.symmetry = Symmetry::kOn;
  target.mirror_axis.reset();
  EXPECT_THROW(embed(armed(), target, options, {}), InvalidInput);
  target.mirror_axis = 0;
  Character lopsided = armed();
  lopsided.mirrored = false;
  EXPECT_THROW(embed(lopsided, target, options, {}), InvalidInput);
  options.pinned = {{0, Eigen::Isometry3d::Identity()}};
  EXPECT_THROW(embed(armed(), target, options, {}), InvalidInput);
  Embedding start;
  start.pose = pose_at(chain(2, 0.1, 0.01), {0, 0, 0});
  start.morphology = Morphology::Ones(2);
  EXPECT_THROW(embed(armed(), target, quick(), {}, start), InvalidInput);
}

TEST(SkeletonFit, NamesTheBonesThatStickOutAndThosePairsThatCollide) {
  const Target target = box_target({0.25, 0.2, 0.2});
  const Character character = chain(3, 0.1, 0.06, {0, -1.6, 1.6});
  Pose pose = pose_at(character, {0, 0.05, 0});
  pose.angles << M_PI / 2, M_PI / 2;
  const SkeletonFit fit = skeleton_fit(character, target, pose, unscaled(character));
  ASSERT_EQ(fit.collisions.size(), 1u);
  EXPECT_EQ(fit.collisions[0].first, 0);
  EXPECT_EQ(fit.collisions[0].second, 2);
  EXPECT_NEAR(fit.collisions[0].depth, 0.02, 1e-9);
  ASSERT_EQ(fit.protrusion.size(), 3u);
  EXPECT_NEAR(fit.protrusion[0], 0.01, 2e-3);
  EXPECT_NEAR(fit.protrusion[1], 0.01, 2e-3);
  const SkeletonFit out = skeleton_fit(character, target, pose_at(character, {0, 0.12, 0}), unscaled(character));
  EXPECT_GT(out.protrusion[2], out.protrusion[1]);
  EXPECT_THROW(skeleton_fit(character, target, pose_at(chain(2, 0.1, 0.01), {0, 0, 0}), unscaled(character)), InvalidInput);
}

}  // namespace
}  // namespace transformables
