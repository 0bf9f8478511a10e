// The certificate, on parts made by hand: the last word is always the plane geometry of the case, never the prover's own.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "certificate_cases.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

/// Least distance at evenly spaced times, corners of the fin against the wall's box: what sampling sees.
double sampled_gap(const Case& c, int samples) {
  const auto wall = bounds(c.parts[0].mesh), fin = bounds(c.parts[1].mesh);
  double least = 1e300;
  for (int n = 0; n < samples; ++n) {
    Pose pose = c.embedding.pose;
    pose.angles[0] = -1.0 + 2.0 * n / (samples - 1);
    const auto frames = forward_kinematics(c.character, pose, c.embedding.morphology);
    // The fin's middle line, densely, less its half thickness: under the true distance.
    for (int k = 0; k <= 200; ++k) {
      const Vector3d p(fin.min().x() + (fin.max().x() - fin.min().x()) * k / 200, 0, 0);
      least = std::min(least, wall.exteriorDistance(frames[0].inverse() * (frames[1] * p)) - 0.0005);
    }
  }
  return least;
}

TEST(Certificate, FindsTheThinFinThatPassesAThinWallBetweenTwoSamples) {
  const Case c = fin_and_wall(0.22, 0.2);
  ASSERT_GT(sampled_gap(c, 20), 0.003) << "samples a twentieth of the move apart must miss it, or nothing is shown";
  const Certificate certificate = c.certified();
  EXPECT_FALSE(certificate.holds);
  EXPECT_EQ(certificate.gap, 0);
  ASSERT_FALSE(certificate.open.empty());
  const auto wall = bounds(c.parts[0].mesh), fin = bounds(c.parts[1].mesh);
  for (const Uncertified& place : certificate.open) {
    EXPECT_EQ(place.reason, Uncertified::Reason::kTouching);
    EXPECT_LT(place.distance, c.options.least);
    EXPECT_NEAR(place.fraction, 0.5, 0.02);
    EXPECT_LT(wall.exteriorDistance(place.on_a), 1e-9) << "places are told in the frames of the bones";
    EXPECT_LT(fin.exteriorDistance(place.on_b), 1e-9);
  }
}

TEST(Certificate, ThatIsNotWantedToTheEndSaysOnlyWhetherItHolds) {
  Case good = fin_and_wall(0.2, 0.2 + 2 * kVoxel), bad = fin_and_wall(0.22, 0.2);
  good.options.to_the_end = bad.options.to_the_end = false;
  EXPECT_TRUE(good.certified().holds);
  const Certificate refused = bad.certified();
  EXPECT_FALSE(refused.holds);
  EXPECT_TRUE(refused.open.empty() && refused.intervals.empty());
  EXPECT_EQ(refused.steps, 0);
}

TEST(Certificate, ProvesATrueGapOfTwoVoxelsAsAlmostTwoVoxels) {
  const double corner = std::hypot(0.2, 0.0005);
  const Case c = fin_and_wall(std::sqrt(corner * corner - 0.0005 * 0.0005), 0.2 + 2 * kVoxel);
  const Certificate certificate = c.certified();
  ASSERT_TRUE(certificate.holds);
  // The fin's far corners run on a circle of radius `corner`, which is 2 voxels from the wall's edge on the way.
  const double gap = 0.2 + 2 * kVoxel - corner;
  EXPECT_LE(certificate.gap, gap + 1e-6);
  EXPECT_GE(certificate.gap, 0.9 * gap);
}

TEST(Certificate, CoversEveryMoveFromItsBeginningToItsEndWithoutAHole) {
  const Certificate certificate = fin_and_wall(0.2, 0.21).certified();
  ASSERT_TRUE(certificate.holds);
  double reached = 0;
  for (const auto& row : certificate.intervals) {
    EXPECT_EQ(row.t0, reached);
    EXPECT_GT(row.t1, row.t0);
    EXPECT_GE(row.bound, certificate.gap);
    reached = row.t1;
  }
  EXPECT_EQ(reached, 1);
}

TEST(Certificate, IsRefusedToPartsThatTouch) {
  Case c = fin_and_wall(0.2, 0.3);
  c.parts[0].mesh = box_mesh({0.2, 0, -0.05}, {0.24, 0.2, 0.05});
  EXPECT_FALSE(c.certified().holds);
}

TEST(Certificate, IsRefusedToAPartInsideAnother) {
  Case c({bone("root", -1, {0, 0, 0}, {}), bone("arm", 0, {0, 0, 0}, {2})});
  c.add(0, box_mesh(Vector3d::Constant(-0.2), Vector3d::Constant(0.2)));
  c.add(1, box_mesh(Vector3d::Constant(-0.02), Vector3d::Constant(0.02)));
  c.path.moves.push_back({{{0, 0.0, 1.0}}});
  for (int swapped = 0; swapped < 2; ++swapped, std::swap(c.parts[0].mesh, c.parts[1].mesh)) {
    const Certificate certificate = c.certified();
    EXPECT_FALSE(certificate.holds);
    ASSERT_EQ(certificate.open.size(), 1u);
    EXPECT_EQ(certificate.open[0].reason, Uncertified::Reason::kInside);
  }
}

TEST(Certificate, LooksAtPartsThatNeverMoveAgainstEachOther) {
  Case c({bone("root", -1, {0, 0, 0}, {}), bone("arm", 0, {0.1, 0, 0}, {2})});
  c.add(0, box_mesh({0, 0, 0}, {0.05, 0.05, 0.05}));
  c.add(1, box_mesh({0, 0, 0}, {0.05, 0.05, 0.05}));
  const Certificate apart = c.certified();
  ASSERT_TRUE(apart.holds);
  EXPECT_NEAR(apart.gap, 0.05, 0.05 * 0.06);
  c.parts[1].mesh = box_mesh({-0.06, 0, 0}, {0.05, 0.05, 0.05});
  EXPECT_FALSE(c.certified().holds);
}

/// Two arms and their hands, hinges about several axes, all turning in one move.
Case many_joints() {
  Case c({bone("root", -1, {0, 0, 0}, {}), bone("arm.L", 0, {0.1, 0, 0}, {2}), bone("hand.L", 1, {0.2, 0, 0}, {0, 1, 2}),
          bone("arm.R", 0, {-0.1, 0, 0}, {2}), bone("hand.R", 3, {-0.2, 0, 0}, {0, 2})});
  c.add(2, box_mesh({0.01, -0.02, -0.01}, {0.12, 0.02, 0.01}));
  c.add(4, box_mesh({-0.12, -0.02, -0.01}, {-0.01, 0.02, 0.01}));
  c.add(0, box_mesh({-0.01, -0.02, -0.01}, {0.01, 0.02, 0.01}));
  c.embedding.morphology << 1, 0.9, 1, 1.1, 1;
  c.embedding.pose.angles.setConstant(0.2);
  c.path.moves.push_back({{{0, 0.2, 1.3}, {1, 0.2, 0.9}, {2, 0.2, -0.4}, {4, 0.2, -1.1}, {5, 0.2, 0.7}}});
  c.path.moves.push_back({{{3, 0.2, 0.0}, {6, 0.2, 0.5}}});
  return c;
}

TEST(Certificate, NeverClaimsMoreThanWhatPointsOfThePartsShow) {
  const Case c = many_joints();
  const Certificate certificate = c.certified();
  ASSERT_TRUE(certificate.holds);
  Eigen::VectorXd start = c.embedding.pose.angles;
  std::size_t compared = 0;
  for (std::size_t m = 0; m < c.path.moves.size(); ++m) {
    for (int n = 0; n <= 64; ++n) {
      Pose pose = c.embedding.pose;
      pose.angles = start;
      for (const auto& turn : c.path.moves[m].turns) pose.angles[turn.angle] = turn.from_rad + n / 64.0 * (turn.to_rad - turn.from_rad);
      const auto frames = forward_kinematics(c.character, pose, c.embedding.morphology);
      for (const auto& row : certificate.intervals) {
        if (row.move != m || n / 64.0 < row.t0 || n / 64.0 > row.t1) continue;
        for (const Part& a : c.parts)
          for (const Part& b : c.parts) {
            if (a.bone != row.bone_a || b.bone != row.bone_b) continue;
            for (const Vector3d& v : a.mesh.vertices) {
              const Vector3d p = frames[b.bone].inverse() * (frames[a.bone] * v);
              EXPECT_GE(bounds(b.mesh).exteriorDistance(p), row.bound);
            }
            ++compared;
          }
      }
    }
    for (const auto& turn : c.path.moves[m].turns) start[turn.angle] = turn.to_rad;
  }
  EXPECT_GT(compared, 300u);
}

TEST(Certificate, IsTheSameForAnyNumberOfThreads) {
  Case c = many_joints();
  c.options.threads = 1;
  const Certificate one = c.certified();
  c.options.threads = 2;
  const Certificate two = c.certified();
  ASSERT_EQ(one.intervals.size(), two.intervals.size());
  EXPECT_EQ(one.gap, two.gap);
  EXPECT_EQ(one.steps, two.steps);
  for (std::size_t n = 0; n < one.intervals.size(); ++n) EXPECT_EQ(one.intervals[n].bound, two.intervals[n].bound);
}

TEST(Certificate, SaysSoWhenItsStepsRunOut) {
  Case c = fin_and_wall(0.2, 0.21);
  c.options.steps = 10;
  const Certificate certificate = c.certified();
  EXPECT_FALSE(certificate.holds);
  ASSERT_EQ(certificate.open.size(), 1u);
  EXPECT_EQ(certificate.open[0].reason, Uncertified::Reason::kUnresolved);
}

TEST(Certificate, RefusesWhatDoesNotFit) {
  const Case good = fin_and_wall(0.2, 0.21);
  const auto refused = [&](auto spoil) {
    Case c = good;
    spoil(c);
    EXPECT_THROW(c.certified(), InvalidInput);
  };
  refused([](Case& c) { c.options.tolerance = 1; });
  refused([](Case& c) { c.options.least = 0; });
  refused([](Case& c) { c.options.enough = c.options.least; });
  refused([](Case& c) { c.options.steps = 0; });
  refused([](Case& c) { c.options.threads = -1; });
  refused([](Case& c) { c.embedding.pose.angles.resize(0); });
  refused([](Case& c) { c.parts[0].bone = 9; });
  refused([](Case& c) { c.parts[0].bone = 1; });
  refused([](Case& c) { c.parts[0].mesh = {}; });
  refused([](Case& c) { c.parts[0].mesh.vertices[0].x() = NAN; });
  refused([](Case& c) { c.parts[0].mesh.triangles[0][0] = 99; });
  refused([](Case& c) { c.path.moves[0].turns[0].angle = 5; });
  refused([](Case& c) { c.path.moves[0].turns[0].from_rad = 0.3; });
  refused([](Case& c) { c.path.moves[0].turns.push_back({0, 1.0, 0.5}); });
}

TEST(Certificate, StopsWhenAsked) {
  const Case c = fin_and_wall(0.2, 0.21);
  EXPECT_THROW(certify(c.parts, c.character, c.embedding, c.path, c.options, {[](double, std::string_view) { return false; }}), Cancelled);
}

}  // namespace
}  // namespace transformables
