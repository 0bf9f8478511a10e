// Real hinges: pin, clevis and tongue, on two beams that meet at a joint.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cases.h"
#include "finishing/exact_cut.h"
#include "finishing/hinge_shape.h"
#include "finishing/openness.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using namespace finishing;

constexpr double kRadius = 0.035;

/// Two beams with a joint in the middle that turns by a little; the joint's ball has room on all sides.
Design joint(double radius = kRadius) {
  Design d = halves(radius);
  d.turn(0, 0.3);
  return d;
}

const Part& part_of(const Parts& parts, int bone) {
  return *std::find_if(parts.parts.begin(), parts.parts.end(), [&](const Part& p) { return p.bone == bone; });
}

/// Which bone's part is at a place of object mode; -1: none.
int owner_at(const Design& d, const Parts& parts, const Vector3d& p) {
  for (const Part& part : parts.parts)
    if (std::abs(winding(part.mesh, d.segmentation.frames[part.bone].inverse() * p)) > 0.5) return part.bone;
  return -1;
}

int handles(const TriangleMesh& mesh) { return 1 - (int(mesh.vertices.size()) - int(mesh.triangles.size()) / 2) / 2; }

bool told(const Parts& parts, const std::string& text) {
  return std::any_of(parts.warnings.begin(), parts.warnings.end(), [&](const std::string& w) { return w.find(text) != std::string::npos; });
}

TEST(HingeShape, SpoolAndRingAreSolidsThatShareTheBall) {
  for (const double radius : {0.1, 0.42, 0.6}) {
    const TriangleMesh s = spool(1, 0.36, radius), r = ring(1, 0.36, radius);
    expect_good(s);
    expect_good(r);
    const double all = 4 * std::numbers::pi / 3;
    EXPECT_NEAR(signed_volume(s) + signed_volume(r), all, 0.02 * all);
    EXPECT_LT(signed_volume(s) + signed_volume(r), all) << "flat sides lie within the ball";
    EXPECT_EQ(handles(s), 0);
    EXPECT_EQ(handles(r), 1);
  }
}

TEST(HingeShape, ABlockIsASolidOpenOrClosedToABand) {
  Block b{0.8, 1.2, 0.4, 1.1, 0.5, 2.5};
  const auto exact = [](const Block& of) {
    return (std::pow(of.to, 3) - std::pow(of.from, 3)) / 3 * (std::cos(of.polar_from) - std::cos(of.polar_to)) * (of.azimuth_to - of.azimuth_from);
  };
  expect_good(block(b));
  EXPECT_NEAR(signed_volume(block(b)), exact(b), 0.03 * exact(b));
  b.azimuth_to = b.azimuth_from + 2 * std::numbers::pi;
  expect_good(block(b));
  EXPECT_NEAR(signed_volume(block(b)), exact(b), 0.03 * exact(b));
  EXPECT_EQ(handles(block(b)), 1);
}

TEST(HingeShape, IsRefusedWhereEarsOrRingWouldBeWeak) {
  HingeSize size;
  EXPECT_TRUE(hinge_size(1, 0.1, 1, size));
  EXPECT_NEAR(size.outer - size.inner, 0.1, 1e-12);
  EXPECT_FALSE(hinge_size(1, 0.5, 1, size)) << "a gap of half the radius";
  EXPECT_FALSE(hinge_size(1, 0.1, 0.5, size)) << "the target's surface is near";
}

TEST(Combined, JoinsTakesAndKeepsSources) {
  const TriangleMesh big = box_mesh({-1, -1, -1}, {1, 1, 1}), small = box_mesh({0.5, -0.5, -0.4}, {1.5, 0.5, 0.6});
  SourcedMesh first{big, {}};
  for (std::size_t n = 0; n < big.triangles.size(); ++n) first.source.push_back(std::int32_t(n));
  const auto joined = combined(first, small, Combination::kUnion, 0), taken = combined(first, small, Combination::kDifference, 0);
  ASSERT_TRUE(joined && taken);
  expect_good(joined->mesh);
  expect_good(taken->mesh);
  EXPECT_NEAR(signed_volume(joined->mesh), 8.5, 1e-6);
  EXPECT_NEAR(signed_volume(taken->mesh), 7.5, 1e-6);
  for (const auto& all : {*joined, *taken})
    for (std::size_t n = 0; n < all.source.size(); ++n) {
      const auto& t = all.mesh.triangles[n];
      const Vector3d middle = (all.mesh.vertices[t[0]] + all.mesh.vertices[t[1]] + all.mesh.vertices[t[2]]) / 3;
      const bool on_first = std::abs(middle.cwiseAbs().maxCoeff() - 1) < 1e-6;
      EXPECT_EQ(all.source[n] >= 0, on_first) << middle.transpose();
    }
}

TEST(Combined, RefusesToDropMoreThanIsAllowed) {
  const TriangleMesh bar = box_mesh({-1, -0.1, -0.1}, {1, 0.1, 0.1}), knife = box_mesh({0.4, -1, -1}, {0.5, 1, 1});
  const SourcedMesh first{bar, std::vector<std::int32_t>(bar.triangles.size(), 0)};
  EXPECT_FALSE(combined(first, knife, Combination::kDifference, 0.01)) << "half a unit of the bar would go";
  ASSERT_TRUE(combined(first, knife, Combination::kDifference, 0.03));
  EXPECT_NEAR(signed_volume(combined(first, knife, Combination::kDifference, 0.03)->mesh), 1.4 * 0.04, 1e-6);
}

/// A box with a round hollow of 6 steps, and a slit of some width from there to the outside.
Grid<float> hollow_box(double slit) {
  GridShape shape;
  shape.size.setConstant(31);
  shape.origin.setConstant(-15);
  Grid<float> distance(shape, 0);
  for (std::size_t n = 0; n < distance.values.size(); ++n) {
    const Vector3d p = shape.position(n);
    const double hole = std::min(p.norm() - 6, box_distance(p, {-slit / 2, -20, 0}, {slit / 2, 20, 20}));
    distance[n] = float(std::max(box_distance(p, Vector3d::Constant(-12), Vector3d::Constant(12)), -hole));
  }
  return distance;
}

TEST(ShutHollows, AreThoseWithoutAWayOutOrWithANarrowOne) {
  const double ball = 4 * std::numbers::pi / 3 * std::pow(6 - 0.87, 3);
  EXPECT_NEAR(double(shut_hollows(hollow_box(0)).size()), ball, 0.1 * ball);
  EXPECT_GT(shut_hollows(hollow_box(1)).size(), 0.7 * ball);
  EXPECT_TRUE(shut_hollows(hollow_box(4)).empty());
  for (const Vector3d& p : shut_hollows(hollow_box(1))) EXPECT_LT(p.norm(), 6) << "nothing outside is a hollow";
}

TEST(Hinges, APinHoldsATongueBetweenTwoEars) {
  const Design d = joint();
  const Parts parts = d.finished();
  ASSERT_EQ(parts.pinned, std::vector<int>{1});
  ASSERT_TRUE(parts.certificate.holds);
  for (const Part& part : parts.parts) expect_good(part.mesh);
  const int pin = owner_at(d, parts, {0, 0, 0}), tongue = 1 - pin;
  ASSERT_GE(pin, 0);
  for (const double side : {-1.0, 1.0}) EXPECT_EQ(owner_at(d, parts, {side * 0.7 * kRadius, 0, 0}), pin) << "an ear on either side of the axis";
  for (int n = 0; n < 12; ++n) {
    const double a = n * std::numbers::pi / 6;
    EXPECT_EQ(owner_at(d, parts, {0, 0.75 * kRadius * std::cos(a), 0.75 * kRadius * std::sin(a)}), tongue) << "all around the pin";
  }
  EXPECT_EQ(handles(part_of(parts, tongue).mesh), 1) << "the hole";
}

TEST(Hinges, KeepTheClearanceAndAreProvedWithTheRest) {
  const Design d = joint();
  const Parts parts = d.finished();
  ASSERT_TRUE(parts.certificate.holds);
  EXPECT_GE(parts.certificate.gap, 0.99 * d.options.least_share * d.options.clearance);
  CertificateOptions options;
  options.enough = d.options.clearance;
  options.least = 0.7 * d.options.clearance;
  EXPECT_TRUE(certify(parts.parts, d.character, d.embedding, d.path, options, {}).holds) << "nothing here is carved tight";
}

TEST(Hinges, TakeLittleOfTheTargetsVolumeAndNothingOutsideIt) {
  Design d = joint();
  const Parts pinned = d.finished();
  d.options.hinges = false;
  const Parts plain = d.finished();
  EXPECT_TRUE(plain.pinned.empty());
  EXPECT_EQ(owner_at(d, plain, {0, 0, 0}), 1) << "the child's ball";
  const double ball = 4 * std::numbers::pi / 3 * std::pow(kRadius, 3);
  EXPECT_NEAR(pinned.filled_volume_pct, plain.filled_volume_pct, 100 * 0.4 * ball / d.target.volume);
  for (const Part& part : pinned.parts)
    for (const Vector3d& v : part.mesh.vertices)
      EXPECT_LT(box_distance(d.segmentation.frames[part.bone] * v, {-kHalfWidth, -0.25, -kHalfWidth}, {kHalfWidth, 0.25, kHalfWidth}), 1e-6);
}

TEST(Hinges, AJointOfTwoAxesKeepsItsBallAndIsNamed) {
  Design d = joint();
  std::vector<ArmatureBone> bones{bone("root", -1, -0.15, 0), bone("child", 0, 0, 0.15)};
  bones[1].hinges.push_back({2, -1, 1});
  const double radius = d.character.bones[0].radius;
  d.character = make_character(bones);
  for (Bone& b : d.character.bones) b.radius = radius;
  d.embedding.pose = rest_pose(d.character, d.character.root_rest);
  const Parts parts = d.finished();
  EXPECT_TRUE(parts.pinned.empty());
  EXPECT_TRUE(told(parts, "No pin holds the joint of 'child': they turn about several axes"));
}

TEST(Hinges, WithoutRoomTheJointKeepsItsBallAndIsNamed) {
  Design d = joint();
  d.options.clearance = 0.02;
  EXPECT_TRUE(told(d.finished(), "No pin holds the joint of 'child': a pin would be too weak"));
  Design shallow = beam({kHalfWidth, 0.25, 0.6 * kRadius}, {bone("root", -1, -0.15, 0), bone("child", 0, 0, 0.15)}, kRadius,
                        {[](const Vector3d& p) { return p.y(); }, [](const Vector3d& p) { return -p.y(); }});
  shallow.turn(0, 0.3);
  const Parts parts = shallow.finished();
  EXPECT_TRUE(parts.pinned.empty());
  EXPECT_TRUE(told(parts, "No pin holds the joint of 'child': there is no room"));
}

TEST(Hinges, ArePlacedTheSameForAnyNumberOfThreads) {
  Design d = joint();
  d.options.threads = 1;
  const Parts one = d.finished();
  d.options.threads = 2;
  const Parts two = d.finished();
  ASSERT_EQ(one.pinned, two.pinned);
  for (std::size_t n = 0; n < one.parts.size(); ++n) EXPECT_EQ(one.parts[n].mesh.vertices, two.parts[n].mesh.vertices);
}

}  // namespace
}  // namespace transformables
