// Finishing, on designs made by hand: beams along Y whose bones turn about X.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "cases.h"
#include "finishing/finishing.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

double total_volume(const Parts& parts) {
  double sum = 0;
  for (const Part& part : parts.parts) sum += part.volume;
  return sum;
}

TEST(Finish, HalvesFillTheTargetButForTheGapAtTheirInterface) {
  const Design d = halves();
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  for (const Part& part : parts.parts) {
    expect_good(part.mesh);
    EXPECT_NEAR(part.volume, signed_volume(part.mesh), 1e-12);
  }
  const double area = 4 * kHalfWidth * kHalfWidth;
  const double missing = d.target.volume - total_volume(parts);
  EXPECT_GT(missing, 0.9 * d.options.clearance * area);
  EXPECT_LT(missing, 2 * d.options.clearance * area + 0.005 * d.target.volume);
  EXPECT_NEAR(parts.filled_volume_pct, 100 * total_volume(parts) / d.target.volume, 1e-9);
  EXPECT_EQ(parts.carved_volume_pct, 0);
  EXPECT_TRUE(parts.collisions.empty());
}

TEST(Finish, TheGapDoesNotDependOnTheLevelSetsSlope) {
  Design d = halves();
  const double even = total_volume(d.finished());
  for (Grid<float>& phi : d.segmentation.phi)
    for (float& v : phi.values) v *= 0.3f;
  EXPECT_NEAR(total_volume(d.finished()), even, 1e-3 * even);
}

TEST(Finish, TheOuterSurfaceStaysWhereTheTargetsIs) {
  const Design d = halves();
  const Parts parts = d.finished();
  const Vector3d half(kHalfWidth, 0.25, kHalfWidth);
  double farthest_x = 0, nearest_to_interface = 1;
  for (const Part& part : parts.parts)
    for (const Vector3d& v : part.mesh.vertices) {
      const Vector3d p = d.segmentation.frames[part.bone] * v;
      EXPECT_LT(box_distance(p, -half, half), 1e-4);
      farthest_x = std::max(farthest_x, p.x());
      nearest_to_interface = std::min(nearest_to_interface, std::abs(p.y()));
    }
  EXPECT_NEAR(farthest_x, kHalfWidth, 5e-4);
  EXPECT_LT(nearest_to_interface, 0.02);
}

TEST(Finish, VerticesAreNumbersOfSinglePrecision) {
  for (const Part& part : halves().finished().parts)
    for (const Vector3d& v : part.mesh.vertices)
      for (int k = 0; k < 3; ++k) EXPECT_EQ(v[k], to_float(v[k]));
}

TEST(Finish, WhatAHingeSweepsThroughItsNeighbourIsCarvedAndNoMore) {
  Design d = halves(0.004);
  d.turn(0, std::numbers::pi / 2);
  d.options.least_share = 0.51;
  const Parts parts = d.finished();
  EXPECT_TRUE(parts.collisions.empty());
  EXPECT_GE(parts.minimum_clearance, 0.5 * d.options.clearance);
  ASSERT_EQ(parts.parts.size(), 2u);
  for (const Part& part : parts.parts) expect_good(part.mesh);
  // The child's upper edge passes over a square of the root's section beside the hinge, all along X.
  const double swept_pct = 100 * kHalfWidth * kHalfWidth * 2 * kHalfWidth / d.target.volume;
  EXPECT_GT(parts.carved_volume_pct, 0.95 * swept_pct);
  EXPECT_LT(parts.carved_volume_pct, 1.25 * swept_pct);
}

TEST(Finish, PartsThatAreRoundAboutTheirHingeLoseNothing) {
  // A wheel through the root; bones too thin to be in its way.
  const auto wheel = [](const Vector3d& p) { return std::hypot(p.y(), p.z()) - 0.05; };
  Design d = beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.15, 0), bone("wheel", 0, 0, 0.03)}, 0.0005, {[=](const Vector3d& p) { return -wheel(p); }, wheel});
  d.turn(0, 0.7);
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  EXPECT_LT(parts.carved_volume_pct, 0.02);
}

TEST(Finish, NoPointOfAPartEntersAnotherAtAnyOfManyConfigurations) {
  Design d = halves();
  d.turn(0, 2.0);
  d.turn(0, 0.3);
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  const GridShape shape{{110, 110, 110}, Vector3d::Constant(-0.3), 0.6 / 109};
  std::vector<Grid<float>> fields;
  for (const Part& part : parts.parts) fields.push_back(signed_distance(part.mesh, shape));
  // Samples show a sharp edge too thick by a part of their step: points that seem to be inside are asked for exactly.
  constexpr double kSeems = 0.0005;
  int seem = 0, inside = 0;
  for (int n = 0; n <= 200; ++n) {
    Pose pose = d.embedding.pose;
    pose.angles[0] = 2.0 * n / 200;
    const auto frames = forward_kinematics(d.character, pose, d.embedding.morphology);
    for (int a = 0; a < 2; ++a)
      for (const Vector3d& v : parts.parts[a].mesh.vertices) {
        const Vector3d p = frames[1 - a].inverse() * (frames[a] * v);
        if ((p.cwiseAbs().array() >= 0.29).any() || sample(fields[1 - a], p) > -kSeems) continue;
        ++seem;
        inside += std::abs(winding(parts.parts[1 - a].mesh, p)) > 0.5;
      }
  }
  EXPECT_EQ(inside, 0) << "of " << seem << " that seem to be";
}

TEST(Finish, AThinFinThatPassesBetweenCoarseStepsStillCarves) {
  // A fin two fine cells thick at the beam's far end sweeps through a post that the root holds out beside it.
  const double thick = 0.008;
  const auto fin = [=](const Vector3d& p) {
    return std::min(box_distance(p, {-0.3, 0, -0.02}, {0.3, 0.15, 0.02}), box_distance(p, {-0.3, 0.1, -thick / 2}, {0.3, 0.3, thick / 2}));
  };
  Design d = beam({0.05, 0.25, 0.12}, {bone("root", -1, -0.15, 0), bone("child", 0, 0, 0.15)}, 0.004,
                  {[&](const Vector3d& p) { return -fin(p); }, fin});
  d.options.largest_step_rad = 3;
  d.turn(0, 1.5);
  const Parts parts = d.finished();
  EXPECT_TRUE(parts.collisions.empty());
  EXPECT_GT(parts.carved_volume_pct, 1);
  EXPECT_GE(parts.minimum_clearance, 0);
}

TEST(Finish, SkeletonsAreNotCarvedForAnothersSkin) {
  Design d = halves(0.02);
  d.turn(0, 1.2);
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  // Along both bones, well away from the joint, the skeleton's middle is inside its part.
  const GridShape shape{{90, 90, 90}, Vector3d::Constant(-0.3), 0.6 / 89};
  for (const Part& part : parts.parts) {
    const Grid<float> field = signed_distance(part.mesh, shape);
    for (double y = 0.05; y < 0.14; y += 0.01)
      EXPECT_LT(sample(field, {0, part.bone == 0 ? 0.15 - y : y, 0}), 0) << part.bone << " at " << y;
  }
}

TEST(Finish, ASkeletonThatAnotherWouldSwallowIsKept) {
  const auto until = [](double y) { return [y](const Eigen::Vector3d& p) { return p.y() - y; }; };
  Design d = beam({kHalfWidth, 0.25, kHalfWidth}, {bone("root", -1, -0.25, 0), bone("arm", 0, 0, 0.15), bone("tip", 1, 0.15, 0.17)}, 0.012,
                  {until(0), [&](const Eigen::Vector3d& p) { return std::max(-p.y(), p.y() - 0.15); }, [&](const Eigen::Vector3d& p) { return 0.15 - p.y(); }});
  d.turn(0, std::numbers::pi);  // the arm comes to lie along the root's bone, and so does the tip, which is much shorter
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 3u);
  for (const Part& part : parts.parts) EXPECT_GT(part.volume, 0);
  EXPECT_TRUE(parts.certificate.holds);
}

TEST(Finish, MirroredHingesThatTurnAtOnceAreKeptApart) {
  std::vector<ArmatureBone> bones{bone("root", -1, -0.05, 0.05), bone("up", 0, 0.05, 0.2), bone("down", 0, -0.05, -0.2)};
  const auto middle = [](const Vector3d& p) { return std::abs(p.y()) - 0.05; };
  Design d = beam({0.06, 0.25, 0.1}, bones, 0.008,
                  {middle, [](const Vector3d& p) { return 0.05 - p.y(); }, [](const Vector3d& p) { return 0.05 + p.y(); }});
  d.path.moves.push_back({{{0, 0, 2.2}, {1, 0, -2.2}}});
  d.options.least_share = 0.51;
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 3u);
  EXPECT_TRUE(parts.collisions.empty());
  EXPECT_GE(parts.minimum_clearance, 0.5 * d.options.clearance);
  for (const Part& part : parts.parts) expect_good(part.mesh);
}

TEST(Finish, SharpEdgesOfTheTargetThatPassEachOtherAreProvedApart) {
  // The child's lower edge is the target's own, and sharp: it sweeps past the root's side at the clearance.
  Design d = halves(0.004);
  d.turn(0, std::numbers::pi / 2);
  const Parts parts = d.finished();
  EXPECT_TRUE(parts.certificate.holds);
  EXPECT_TRUE(parts.collisions.empty());
  EXPECT_GE(parts.certificate.gap, 0.99 * d.options.least_share * d.options.clearance);
  EXPECT_EQ(parts.certificate.gap, parts.minimum_clearance);
  const Certificate again = certify(parts.parts, d.character, d.embedding, d.path, {.enough = d.options.clearance, .least = 1e-5}, {});
  EXPECT_TRUE(again.holds);
}

TEST(Finish, AClearanceOfZeroStillMovesFreely) {
  Design d = halves(0);
  d.turn(0, 1);
  const Parts parts = d.finished();
  EXPECT_TRUE(parts.certificate.holds);
  EXPECT_GT(parts.minimum_clearance, 0);
}

TEST(Finish, PartsThatNeverMoveAreNotProved) {
  const Parts parts = halves().finished();
  EXPECT_TRUE(parts.certificate.intervals.empty());
  EXPECT_TRUE(parts.collisions.empty());
}

TEST(Finish, ShellsAreLighterAndAsGood) {
  Design d = halves();
  const double solid = total_volume(d.finished());
  d.options.style = Style::kShell;
  d.options.wall = 0.012;
  const Parts parts = d.finished();
  ASSERT_EQ(parts.parts.size(), 2u);
  for (const Part& part : parts.parts) expect_good(part.mesh);
  EXPECT_LT(total_volume(parts), 0.75 * solid);
}

TEST(Finish, GivesTheSameBytesForAnyNumberOfThreads) {
  Design d = halves();
  d.turn(0, 1);
  d.options.threads = 1;
  const Parts one = d.finished();
  d.options.threads = 2;
  const Parts two = d.finished();
  ASSERT_EQ(one.parts.size(), two.parts.size());
  for (std::size_t n = 0; n < one.parts.size(); ++n) {
    EXPECT_EQ(one.parts[n].mesh.vertices, two.parts[n].mesh.vertices);
    EXPECT_EQ(one.parts[n].mesh.triangles, two.parts[n].mesh.triangles);
  }
  EXPECT_EQ(one.minimum_clearance, two.minimum_clearance);
  EXPECT_EQ(one.carved_volume_pct, two.carved_volume_pct);
}

TEST(Finish, StopsWhenAsked) {
  Design d = halves();
  d.turn(0, 1);
  const Progress stop{[](double fraction, std::string_view) { return fraction < 0.5; }};
  EXPECT_THROW(finish(d.segmentation, d.character, d.target, d.embedding, d.path, d.options, stop), Cancelled);
}

TEST(Finish, TellsProgressThatNeverGoesBack) {
  Design d = halves();
  d.turn(0, 1);
  double before = 0;
  const Progress watch{[&](double fraction, std::string_view) {
    EXPECT_GE(fraction, before);
    EXPECT_LE(fraction, 1);
    before = fraction;
    return true;
  }};
  finish(d.segmentation, d.character, d.target, d.embedding, d.path, d.options, watch);
  EXPECT_EQ(before, 1);
}

TEST(Finish, RefusesOptionsOutOfRange) {
  const auto refused = [](const std::function<void(FinishingOptions&)>& change) {
    Design d = halves();
    change(d.options);
    EXPECT_THROW(d.finished(), InvalidInput);
  };
  refused([](FinishingOptions& o) { o.clearance = -1; });
  refused([](FinishingOptions& o) { o.clearance = std::nan(""); });
  refused([](FinishingOptions& o) { o.refinement = 0; });
  refused([](FinishingOptions& o) { o.refinement = 9; });
  refused([](FinishingOptions& o) { o.largest_step_rad = 0; });
  refused([](FinishingOptions& o) { o.least_share = 2; });
  refused([](FinishingOptions& o) { o.threads = -1; });
  refused([](FinishingOptions& o) { o.style = Style::kShell, o.wall = 0; });
}

TEST(Finish, RefusesPiecesOfDifferentDesigns) {
  const auto refused = [](const std::function<void(Design&)>& change) {
    Design d = halves();
    change(d);
    EXPECT_THROW(d.finished(), InvalidInput);
  };
  refused([](Design& d) { d.segmentation.phi.pop_back(); });
  refused([](Design& d) { d.segmentation.shape.step *= 2; });
  refused([](Design& d) { d.segmentation.phi[0].values.pop_back(); });
  refused([](Design& d) { d.segmentation.phi.assign(2, {}); });
  refused([](Design& d) { d.embedding.morphology.resize(5); });
  refused([](Design& d) { d.target.mesh = {}; });
  refused([](Design& d) { d.path.moves.push_back({{{7, 0, 1}}}); });
  refused([](Design& d) { d.path.moves.push_back({{{0, 0.5, 1}}}); });
}

}  // namespace
}  // namespace transformables
