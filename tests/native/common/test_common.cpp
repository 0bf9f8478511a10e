// Segments and grids: what every other room leans on, against brute force.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/capsule.h"
#include "common/grid.h"
#include "common/mesh.h"
#include "common/progress.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) { return low + (high - low) * double(engine_()) / double(engine_.max()); }
  Vector3d point(double reach = 1) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }

 private:
  std::mt19937 engine_;
};

/// Distance is convex along a segment, so nested golden sections find the least one; shares nothing with the closed form.
template <class F>
double least_on_unit(F f) {
  constexpr double kGolden = 0.6180339887498949;
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
  }
  return std::min({f(0.5 * (low + high)), f(0.0), f(1.0)});
}

double brute_distance(const Segment& s, const Vector3d& p) {
  return least_on_unit([&](double t) { return (s.a + t * (s.b - s.a) - p).norm(); });
}

double brute_distance(const Segment& s, const Segment& t) {
  return least_on_unit([&](double u) { return brute_distance(t, s.a + u * (s.b - s.a)); });
}

void expect_matches_brute_force(const Segment& s, const Segment& t, double tolerance = 1e-7) {
  const double expected = brute_distance(s, t);
  const double size = 1 + (s.a - t.a).norm();
  EXPECT_NEAR(distance(s, t), expected, tolerance * size);
  EXPECT_NEAR(distance(t, s), expected, tolerance * size);
  EXPECT_NEAR(distance(Segment{s.b, s.a}, t), expected, tolerance * size);
  EXPECT_NEAR(distance(s, Segment{t.b, t.a}), expected, tolerance * size);
}

TEST(Capsule, DistanceOfRandomSegmentsIsThatOfBruteForce) {
  Dice dice(1);
  for (int i = 0; i < 60; ++i) expect_matches_brute_force({dice.point(), dice.point()}, {dice.point(), dice.point()});
}

TEST(Capsule, DistanceOfParallelSegmentsIsThatOfBruteForce) {
  Dice dice(2);
  for (int i = 0; i < 60; ++i) {
    const Segment s{dice.point(), dice.point()};
    const Vector3d along = s.b - s.a, start = dice.point(2);
    expect_matches_brute_force(s, {start, start + dice(-2, 2) * along});
  }
}

TEST(Capsule, DistanceOfNearlyParallelSegmentsIsThatOfBruteForce) {
  Dice dice(3);
  for (int i = 0; i < 120; ++i) {
    const Segment s{dice.point(), dice.point()};
    const Vector3d start = s.a + dice(-1, 1) * (s.b - s.a) + dice.point(i % 2 ? 1e-3 : 1.0);
    const double tilt = std::pow(10.0, -dice(4, 14));
    expect_matches_brute_force(s, {start, start + dice(-2, 2) * (s.b - s.a) + dice.point(tilt)});
  }
}

TEST(Capsule, DistanceOfSegmentsOnOneLineIsTheGapBetweenThem) {
  const Vector3d along = Vector3d(1, 2, -0.5).normalized(), p(0.3, -0.2, 0.7);
  const auto on_line = [&](double a, double b) { return Segment{p + a * along, p + b * along}; };
  EXPECT_NEAR(distance(on_line(0, 1), on_line(1.25, 3)), 0.25, 1e-12);
  EXPECT_NEAR(distance(on_line(0, 1), on_line(-2, -0.5)), 0.5, 1e-12);
  EXPECT_NEAR(distance(on_line(0, 1), on_line(0.5, 3)), 0, 1e-7);
  EXPECT_NEAR(distance(on_line(0, 1), on_line(0.25, 0.5)), 0, 1e-7);
}

TEST(Capsule, SegmentsThatArePointsAreMeasuredAsPoints) {
  Dice dice(4);
  for (int i = 0; i < 30; ++i) {
    const Segment s{dice.point(), dice.point()};
    const Vector3d p = dice.point(), q = dice.point();
    EXPECT_NEAR(distance(s, p), brute_distance(s, p), 1e-9);
    EXPECT_NEAR(distance(s, Segment{p, p}), brute_distance(s, p), 1e-9);
    EXPECT_NEAR(distance(Segment{p, p}, s), brute_distance(s, p), 1e-9);
    EXPECT_NEAR(distance(Segment{q, q}, Segment{p, p}), (p - q).norm(), 1e-12);
    const Vector3d nearby = p + dice.point(1e-10);
    EXPECT_NEAR(distance(Segment{p, nearby}, s), brute_distance(s, p), 1e-9);
  }
}

TEST(Capsule, DistanceGrowsWithTheScaleEvenOfTinySegments) {
  Dice dice(5);
  for (int i = 0; i < 30; ++i) {
    const Segment s{dice.point(), dice.point()}, t{dice.point(), dice.point()};
    const double one = distance(s, t);
    for (const double scale : {1e-9, 1e-12, 1e9})
      EXPECT_NEAR(distance(Segment{s.a * scale, s.b * scale}, Segment{t.a * scale, t.b * scale}) / scale, one, 1e-9);
  }
}

TEST(Capsule, DistanceDoesNotChangeUnderARigidMotion) {
  Dice dice(6);
  for (int i = 0; i < 30; ++i) {
    const Segment s{dice.point(), dice.point()}, t{dice.point(), dice.point()};
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.rotate(Eigen::AngleAxisd(dice(-3, 3), dice.point().normalized())).pretranslate(dice.point(5));
    EXPECT_NEAR(distance(transformed(motion, s), transformed(motion, t)), distance(s, t), 1e-9);
  }
}

Grid<float> grid_of(const Eigen::Vector3i& size, double (*f)(const Vector3d&)) {
  Grid<float> grid({size, Vector3d(-0.3, 0.2, 1), 0.1}, 0.f);
  for (std::size_t i = 0; i < grid.values.size(); ++i) grid[i] = float(f(grid.shape.position(i)));
  return grid;
}

double slope(const Vector3d& p) { return 0.5 * p.x() - 2 * p.y() + p.z() + 0.25; }

TEST(Grid, IndexAndCellAreInverse) {
  const GridShape shape{{3, 4, 5}, Vector3d::Zero(), 1};
  ASSERT_EQ(shape.count(), 60u);
  for (std::size_t i = 0; i < shape.count(); ++i) {
    EXPECT_EQ(shape.index(shape.cell(i)), i);
    EXPECT_TRUE(shape.contains(shape.cell(i)));
    EXPECT_EQ(shape.nearest(shape.position(i)), shape.cell(i));
  }
  EXPECT_FALSE(shape.contains({3, 0, 0}));
  EXPECT_FALSE(shape.contains({0, -1, 0}));
}

TEST(Grid, ALinearFunctionIsReadExactlyBetweenSamples) {
  const Grid<float> grid = grid_of({5, 6, 7}, slope);
  Dice dice(7);
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = grid.shape.origin + 0.1 * Vector3d(dice(0, 4), dice(0, 5), dice(0, 6));
    EXPECT_NEAR(sample(grid, p), slope(p), 1e-5);
  }
}

TEST(Grid, SamplesThemselvesAreReadOnTheLastRowToo) {
  const Grid<float> grid = grid_of({3, 4, 2}, [](const Vector3d& p) { return std::sin(7 * p.x() + 3 * p.y() * p.z()); });
  for (std::size_t i = 0; i < grid.values.size(); ++i) EXPECT_NEAR(sample(grid, grid.shape.position(i)), grid[i], 1e-5);
}

TEST(Grid, APointOutsideReadsTheNearestPlaceOnTheBorder) {
  const Grid<float> grid = grid_of({5, 6, 7}, slope);
  const Vector3d low = grid.shape.origin, high = grid.shape.position(Eigen::Vector3i(4, 5, 6));
  Dice dice(8);
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = dice.point(50), border = p.cwiseMax(low).cwiseMin(high);
    EXPECT_NEAR(sample(grid, p), slope(border), 1e-5);
  }
}

TEST(Grid, AGridOfOneSampleAlongAnAxisCanBeRead) {
  const Grid<float> flat = grid_of({4, 1, 3}, slope), point = grid_of({1, 1, 1}, slope);
  const Vector3d p = flat.shape.origin + 0.1 * Vector3d(1.5, 0, 0.5);
  EXPECT_NEAR(sample(flat, p), slope(p), 1e-5);
  EXPECT_NEAR(sample(point, Vector3d(9, 9, 9)), slope(point.shape.origin), 1e-5);
}

TEST(Mesh, TheSignOfTheVolumeTellsWhichSideIsOut) {
  TriangleMesh corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  EXPECT_NEAR(signed_volume(corner), 1.0 / 6, 1e-12);
  for (auto& t : corner.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(signed_volume(corner), -1.0 / 6, 1e-12);
  EXPECT_TRUE(bounds(corner).isApprox(Eigen::AlignedBox3d(Vector3d::Zero(), Vector3d::Ones())));
}

TEST(Progress, AStageStopsWhenItsCallerSaysSo) {
  Progress none;
  EXPECT_NO_THROW(none(0.5));
  Progress stop{[](double fraction, std::string_view) { return fraction < 0.5; }};
  EXPECT_NO_THROW(stop(0.2, "begun"));
  EXPECT_THROW(stop(0.6, "half"), Cancelled);
}

}  // namespace
}  // namespace transformables
