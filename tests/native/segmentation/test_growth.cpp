#include <gtest/gtest.h>

#include "segmentation/cases.h"
#include "segmentation/lattice.h"
#include "segmentation/skeleton.h"

namespace transformables {
namespace {

using namespace cases;

TEST(Growth, TilesEveryTargetForRandomPoses) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    expect_tiling(grown(posed, target), posed, target);
  }
}

// At every sample beside an interface but those of the skeletons themselves, which are thinner than the threshold allows.
TEST(Growth, LeavesNoInterfaceSharperThanTheThreshold) {
  std::vector<float> all;
  std::size_t with_skeletons = 0;
  for (const Target& target : {sphere_target(48), box_target({0.25, 0.2, 0.25}, 48), u_target(64), sphere_target(32)})
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const Posed posed = random_pose(target, seed);
      const Segmentation s = grown(posed, target);
      const auto skeleton = segmentation_inner::skeleton_on_lattice(posed.character, target, posed.embedding);
      const auto some = interface_curvatures(s, target, segmentation_inner::whole_skeletons(skeleton, target));
      ASSERT_FALSE(some.empty()) << seed;
      EXPECT_LE(some.back(), float(SegmentationOptions().curvature_limit)) << "seed " << seed << ", " << some.size() << " samples";
      all.insert(all.end(), some.begin(), some.end());
      with_skeletons += interface_curvatures(s, target).size();
    }
  std::sort(all.begin(), all.end());
  ASSERT_GT(all.size(), 50000u);
  EXPECT_LT(double(with_skeletons - all.size()), 0.02 * double(with_skeletons));
  // A staircase has a median near 0.5.
  EXPECT_LT(all[all.size() / 2], 0.06f);
}

TEST(Growth, FollowsTheTargetAndNotTheStraightLine) {
  const Target target = u_target(48);
  // The left bone stands all along its arm; the right arm has only a stub at its foot.
  const Posed posed = as_given({bone("foot", -1, {0.14, 0, -0.2}, {-0.14, 0, -0.2}, Vector3d::UnitY()),
                                bone("left", 0, {-0.14, 0, -0.2}, {-0.07, 0, 0.22}, Vector3d::UnitY())}, target);
  const Segmentation s = grown(posed, target);
  expect_tiling(s, posed, target);
  int right = 0;
  for (std::size_t i : target.inside) {
    const Vector3d p = s.shape.position(i);
    if (p.x() < 0.03 || p.z() < -0.1) continue;
    ++right;
    ASSERT_EQ(s.owner[i], 0) << p.transpose();
  }
  EXPECT_GT(right, 1000);
}

TEST(Growth, GivesShortAndThinBonesAPart) {
  const Target target = box_target({0.25, 0.15, 0.15}, 32);
  const double h = target.distance.shape.step;
  const Posed posed = as_given({bone("long", -1, {-0.2, 0, 0}, {0, 0, 0}, Vector3d::UnitY()),
                                bone("short", 0, {0, 0, 0}, {0.4 * h, 0, 0}, Vector3d::UnitY()),
                                bone("end", 1, {0.4 * h, 0, 0}, {0.2, 0, 0}, Vector3d::UnitY())}, target);
  expect_tiling(grown(posed, target), posed, target);
}

TEST(Growth, JoinsAnAxisThatAnotherBoneCrosses) {
  const Target target = box_target({0.25, 0.15, 0.15}, 32);
  const Posed posed = as_given({bone("bar", -1, {-0.2, 0.01, 0}, {0.2, 0.01, 0}, Vector3d::UnitY()),
                                bone("bend", 0, {0.2, 0.01, 0}, {0, 0.1, 0}, Vector3d::UnitZ()),
                                bone("across", 1, {0, 0.1, 0}, {0, -0.1, 0}, Vector3d::UnitX())}, target);
  expect_tiling(grown(posed, target), posed, target);
}

TEST(Growth, OfTwoEqualHalvesMeetsInTheMiddleAndRunsOnOutside) {
  const Target target = box_target({0.25, 0.1, 0.1}, 48);
  const Posed posed = as_given({bone("middle", -1, {0, -0.06, 0}, {0, 0.06, 0}, Vector3d::UnitX()),
                                bone("left", 0, {-0.1, 0, 0}, {-0.2, 0, 0}, Vector3d::UnitY()),
                                bone("right", 0, {0.1, 0, 0}, {0.2, 0, 0}, Vector3d::UnitY())}, target);
  const Segmentation s = grown(posed, target);
  expect_tiling(s, posed, target);
  const double reach = 3 * s.shape.step;
  for (std::size_t i = 0; i < s.shape.count(); ++i) {
    const Vector3d p = s.shape.position(i);
    if (target.distance[i] > reach || std::abs(p.x()) > 0.25) continue;
    std::array<float, 3> v;
    for (int b = 0; b < 3; ++b) v[b] = value(s.phi[b], s.shape, i);
    const int best = int(std::min_element(v.begin(), v.end()) - v.begin());
    if (p.x() < -0.12) {
      ASSERT_EQ(best, 1) << p.transpose();
    }
    if (p.x() > 0.12) {
      ASSERT_EQ(best, 2) << p.transpose();
    }
    if (std::abs(p.x()) < 0.02) {
      ASSERT_EQ(best, 0) << p.transpose();
    }
  }
}

TEST(Growth, OfAMirroredInputIsMirrored) {
  const Target target = box_target({0.25, 0.15, 0.15}, 40);
  std::vector<ArmatureBone> bones{bone("body", -1, {0, -0.07, 0.013}, {0, 0.07, 0.013}, Vector3d::UnitX())};
  for (double side : {-1.0, 1.0}) {
    bones.push_back(bone(side < 0 ? "a" : "b", 0, {0.05 * side, 0.07, 0.02}, {0.15 * side, 0.05, 0.09}, Vector3d::UnitZ()));
    bones.push_back(bone(side < 0 ? "c" : "d", int(bones.size()) - 1, {0.15 * side, 0.05, 0.09}, {0.19 * side, -0.08, -0.07}, Vector3d::UnitZ()));
  }
  const Posed posed = as_given(bones, target);
  const Segmentation s = grown(posed, target);
  const auto index_of = [&](const std::string& name) {
    for (std::size_t b = 0; b < posed.character.bones.size(); ++b)
      if (posed.character.bones[b].name == name) return std::int16_t(b);
    return std::int16_t(-1);
  };
  std::vector<std::int16_t> other(5);
  for (const auto& [a, b] : {std::pair{"a", "b"}, {"c", "d"}, {"body", "body"}})
    other[index_of(a)] = index_of(b), other[index_of(b)] = index_of(a);
  std::size_t different = 0;
  for (std::size_t i : target.inside) {
    Vector3i c = s.shape.cell(i);
    c.x() = s.shape.size.x() - 1 - c.x();
    different += s.owner[s.shape.index(c)] != other[s.owner[i]];
  }
  EXPECT_LT(double(different), 0.01 * double(target.inside.size()));
}

TEST(Growth, IsTheSameForOneThreadAndTwo) {
  const Target target = sphere_target(32);
  const Posed posed = random_pose(target, 4);
  const Segmentation one = grown(posed, target, 1), two = grown(posed, target, 2);
  EXPECT_EQ(one.owner, two.owner);
  for (std::size_t b = 0; b < one.phi.size(); ++b) EXPECT_EQ(one.phi[b].values, two.phi[b].values);
}

TEST(Growth, RefusesBadOptionsAndForeignData) {
  const Target target = sphere_target(16);
  const Posed posed = as_given({bone("a", -1, {-0.1, 0, 0}, {0, 0, 0}, Vector3d::UnitY()), bone("b", 0, {0, 0, 0}, {0.1, 0, 0}, Vector3d::UnitY())}, target);
  const auto with = [&](auto change) {
    SegmentationOptions options;
    change(options);
    return grow(posed.character, target, posed.embedding, options, {});
  };
  EXPECT_THROW(with([](auto& o) { o.speed = 0; }), InvalidInput);
  EXPECT_THROW(with([](auto& o) { o.speed = NAN; }), InvalidInput);
  EXPECT_THROW(with([](auto& o) { o.curvature = -0.1; }), InvalidInput);
  EXPECT_THROW(with([](auto& o) { o.curvature = 2; }), InvalidInput);
  EXPECT_THROW(with([](auto& o) { o.curvature_limit = -1; }), InvalidInput);
  EXPECT_THROW(with([](auto& o) { o.threads = -1; }), InvalidInput);
  Embedding foreign = posed.embedding;
  foreign.pose.angles.resize(7);
  EXPECT_THROW(grow(posed.character, target, foreign, {}, {}), InvalidInput);
  Target empty = target;
  empty.inside.clear();
  EXPECT_THROW(grow(posed.character, empty, posed.embedding, {}, {}), InvalidInput);
}

TEST(Growth, SaysWhichBoneLiesOutside) {
  const Target target = sphere_target(16);
  const Posed posed = as_given({bone("in", -1, {0, 0, 0}, {0.1, 0, 0}, Vector3d::UnitY()), bone("astray", 0, {0.5, 0, 0}, {0.7, 0, 0}, Vector3d::UnitY())}, target);
  try {
    grow(posed.character, target, posed.embedding, {}, {});
    FAIL() << "no error";
  } catch (const Infeasible& e) {
    EXPECT_NE(std::string(e.what()).find("astray"), std::string::npos);
  }
}

TEST(Growth, StopsWhenAsked) {
  const Target target = sphere_target(32);
  const Posed posed = random_pose(target, 1);
  int calls = 0;
  const Progress stop{[&](double, std::string_view) { return ++calls < 4; }};
  EXPECT_THROW(grow(posed.character, target, posed.embedding, {}, stop), Cancelled);
  EXPECT_EQ(calls, 4);
}

TEST(Growth, GivesEveryBoneItsWholeSkeleton) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    const Segmentation s = grown(posed, target);
    const auto skeleton = segmentation_inner::skeleton_on_lattice(posed.character, target, posed.embedding);
    const auto is_in = [&](int b, std::size_t i) {
      return segmentation_inner::distance_to_bone(skeleton, b, s.shape.position(i)) < -0.1 * skeleton.shapes[b].radius;
    };
    std::size_t of_one = 0, lost = 0;   // samples well within one bone's skeleton and no other's, nor on another's axis
    for (std::size_t i : target.inside) {
      int holder = -1, holders = 0;
      for (int b = 0; b < int(posed.character.bones.size()); ++b)
        if (is_in(b, i)) holder = b, ++holders;
      if (holders != 1 || (skeleton.core[i] >= 0 && skeleton.core[i] != holder)) continue;
      bool hangs_on = false;   // another's axis may cut a corner off
      segmentation_inner::for_neighbours(s.shape, i, [&](std::size_t n) { hangs_on |= s.owner[n] == holder && is_in(holder, n); });
      ++of_one, lost += hangs_on && s.owner[i] != holder;
    }
    EXPECT_GT(of_one, 100u);
    EXPECT_EQ(lost, 0u) << "of " << of_one;
  }
}

}  // namespace
}  // namespace transformables
