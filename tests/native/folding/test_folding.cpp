// Folding on designs made by hand: boxes cut by planes, hinges on their edges, so that what collides is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>

#include "folding/distance_transform.h"
#include "folding/carve_estimate.h"
#include "folding/cores.h"
#include "folding/folding.h"
#include "folding/overlap.h"
#include "folding/smoothing.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
constexpr double kQuarter = std::numbers::pi / 2;

struct Made {
  Character character;
  Target target;
  Embedding embedding;
  Segmentation segmentation;
};

struct MadeBone {
  int parent = -1;
  Vector3d head = Vector3d::Zero();  // object mode
  double folded = 0;                 // angle about Y
  Segment skeleton;                  // object mode
  int mirror = -1;
};

double box_distance(const Vector3d& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

Character made_character(const std::vector<MadeBone>& bones) {
  Character c;
  for (std::size_t b = 0; b < bones.size(); ++b) {
    Bone bone;
    bone.name = "bone" + std::to_string(b);
    bone.parent = bones[b].parent;
    bone.radius = 0.012;
    bone.mirror = bones[b].mirror;
    // Parents are never turned in these designs, so heads can be given where they stand.
    if (bone.parent >= 0) {
      bone.head_in_parent = bones[b].head - bones[bone.parent].head;
      bone.hinges = {{1, -kQuarter, kQuarter}};
      bone.first_angle = c.angle_count++;
    }
    const Eigen::AngleAxisd back(-bones[b].folded, Vector3d::UnitY());
    bone.segments = {{back * (bones[b].skeleton.a - bones[b].head), back * (bones[b].skeleton.b - bones[b].head)}};
    c.bones.push_back(bone);
  }
  return c;
}

/// A box of the given half extents, cut into parts: `distances(p)[i]` is negative where part i is.
Made made(const std::vector<MadeBone>& bones, const Vector3d& half, const std::function<std::vector<double>(const Vector3d&)>& distances,
          double step = 0.0125) {
  Made m;
  m.character = made_character(bones);
  m.embedding.pose.root.translation() = bones[0].head;
  m.embedding.pose.angles = Eigen::VectorXd::Zero(m.character.angle_count);
  for (std::size_t b = 1; b < bones.size(); ++b) m.embedding.pose.angles[m.character.bones[b].first_angle] = bones[b].folded;
  m.embedding.morphology = Morphology::Ones(long(bones.size()));
  GridShape shape;
  shape.step = step;
  const Vector3d margin = half + Vector3d::Constant(3 * step);
  shape.size = (2 * margin / step).array().ceil().matrix().cast<int>();
  shape.origin = -0.5 * step * (shape.size.cast<double>() - Vector3d::Ones());
  m.target.distance = Grid<float>(shape, 0);
  m.segmentation.shape = shape;
  m.segmentation.owner.assign(shape.count(), -1);
  m.segmentation.phi.assign(bones.size(), Grid<float>(shape, 0));
  m.segmentation.frames = forward_kinematics(m.character, m.embedding.pose, m.embedding.morphology);
  for (std::size_t s = 0; s < shape.count(); ++s) {
    const Vector3d p = shape.position(s);
    m.target.distance[s] = float(box_distance(p, half));
    const std::vector<double> d = distances(p);
    for (std::size_t b = 0; b < bones.size(); ++b) m.segmentation.phi[b][s] = float(std::clamp(d[b], -4 * step, 4 * step));
    if (m.target.distance[s] >= 0) continue;
    m.target.inside.push_back(s);
    m.segmentation.owner[s] = std::int16_t(std::min_element(d.begin(), d.end()) - d.begin());
  }
  m.target.volume = 8 * half.prod();
  return m;
}

/// Two boxes side by side, hinged on the top edge between them; the right one opens upward for a positive angle.
Made two_boxes(double folded) {
  return made({{-1, {-0.15, 0, 0}, 0, {{-0.2, 0, 0}, {-0.05, 0, 0}}, -1}, {0, {0, 0, 0.1}, folded, {{0.05, 0, 0}, {0.2, 0, 0}}, -1}}, {0.25, 0.1, 0.1},
              [](const Vector3d& p) { return std::vector<double>{p.x(), -p.x()}; });
}

/// A base, a board hinged on its left edge and a lid above the board hinged on its right edge.
Made lidded(double lid_folded) {
  return made({{-1, {0, 0, -0.08}, 0, {{-0.15, 0, -0.08}, {0.15, 0, -0.08}}, -1},
               {0, {-0.2, 0, -0.04}, kQuarter, {{-0.15, 0, 0}, {0.15, 0, 0}}, -1},
               {0, {0.2, 0, 0.04}, lid_folded, {{-0.15, 0, 0.075}, {0.15, 0, 0.075}}, -1}},
              {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                return std::vector<double>{p.z() + 0.04, std::abs(p.z()) - 0.04, 0.04 - p.z()};
              });
}

/// A base with two doors above it, hinged left and right, that open to the sides; its own mirror image.
Made doors() {
  Made m = made({{-1, {0, 0, -0.05}, 0, {{-0.15, 0, -0.05}, {0.15, 0, -0.05}}, 0},
                 {0, {-0.2, 0, 0}, kQuarter, {{-0.15, 0, 0.05}, {-0.05, 0, 0.05}}, 2},
                 {0, {0.2, 0, 0}, -kQuarter, {{0.05, 0, 0.05}, {0.15, 0, 0.05}}, 1}},
                {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                  return std::vector<double>{p.z(), std::max(-p.z(), p.x()), std::max(-p.z(), -p.x())};
                });
  m.character.mirrored = true;
  m.character.mirror_angle = {1, 0};
  m.character.mirror_sign = {-1, -1};
  m.embedding.symmetric = true;
  return m;
}

/// A bar between a base and a slab that is the base's, too, and in its way.
Made slab_in_the_way() {
  return made({{-1, {0, 0, -0.08}, 0, {{-0.15, 0, -0.08}, {0.15, 0, -0.08}}, -1}, {0, {-0.2, 0, -0.04}, kQuarter, {{-0.15, 0, 0}, {0.15, 0, 0}}, -1}},
              {0.2, 0.1, 0.1}, [](const Vector3d& p) {
                return std::vector<double>{0.03 - std::abs(p.z() + 0.01), std::abs(p.z() + 0.01) - 0.03};
              });
}

FoldPath greedy(const Made& m, const FoldingOptions& options = {}) {
  return plan_greedy(m.segmentation, m.character, m.target, m.embedding, options, {});
}
FoldPath best(const Made& m, const FoldingOptions& options = {}) {
  return plan(m.segmentation, m.character, m.target, m.embedding, options, {});
}
FoldPath remeasured(const FoldPath& path, const Made& m) {
  return measured(path, m.segmentation, m.character, m.target, m.embedding, {});
}

Eigen::VectorXd end_of(const FoldPath& path, Eigen::VectorXd angles) {
  for (const Move& move : path.moves)
    for (const auto& turn : move.turns) {
      EXPECT_NEAR(angles[turn.angle], turn.from_rad, 1e-12);
      angles[turn.angle] = turn.to_rad;
    }
  return angles;
}

bool same(const FoldPath& a, const FoldPath& b) {
  if (a.moves.size() != b.moves.size() || a.overlap_volume != b.overlap_volume || a.collisions.size() != b.collisions.size()) return false;
  for (std::size_t m = 0; m < a.moves.size(); ++m) {
    if (a.moves[m].turns.size() != b.moves[m].turns.size()) return false;
    for (std::size_t t = 0; t < a.moves[m].turns.size(); ++t)
      if (a.moves[m].turns[t].angle != b.moves[m].turns[t].angle || a.moves[m].turns[t].to_rad != b.moves[m].turns[t].to_rad) return false;
  }
  for (std::size_t c = 0; c < a.collisions.size(); ++c)
    if (a.collisions[c].bone_a != b.collisions[c].bone_a || a.collisions[c].volume != b.collisions[c].volume) return false;
  return true;
}

/// Face-connected pieces of a bone's samples.
int pieces(const Made& m, const std::vector<std::int16_t>& owner, int bone) {
  const GridShape& g = m.segmentation.shape;
  std::vector<char> seen(owner.size(), 0);
  int count = 0;
  for (const std::size_t first : m.target.inside) {
    if (owner[first] != bone || seen[first]) continue;
    ++count;
    std::queue<std::size_t> open;
    for (open.push(first), seen[first] = 1; !open.empty(); open.pop())
      for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
          Eigen::Vector3i c = g.cell(open.front());
          c[axis] += side;
          if (g.contains(c) && owner[g.index(c)] == bone && !seen[g.index(c)]) seen[g.index(c)] = 1, open.push(g.index(c));
        }
  }
  return count;
}

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

// Teeth of one sample on every third sample of the interface, and an island.
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
