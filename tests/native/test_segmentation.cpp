#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>

#include "segmentation/level_set.h"
#include "segmentation/segmentation.h"
#include "segmentation/skeleton.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Targets -----------------------------------------------------------------------------------------------------------

Target target_of(const std::function<double(const Vector3d&)>& distance, const Vector3d& half, int resolution) {
  Target target;
  GridShape shape;
  shape.step = kLongestSide / resolution;
  for (int a = 0; a < 3; ++a) {
    shape.size[a] = 2 * int(std::ceil(half[a] / shape.step) + 5);
    shape.origin[a] = -0.5 * shape.step * (shape.size[a] - 1);
  }
  target.distance = Grid<float>(shape, 0);
  for (std::size_t i = 0; i < shape.count(); ++i) {
    target.distance[i] = float(distance(shape.position(i)));
    if (target.distance[i] < 0) target.inside.push_back(i);
  }
  target.volume = double(target.inside.size()) * std::pow(shape.step, 3);
  return target;
}

double to_box(const Vector3d& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

Target box_target(const Vector3d& half, int resolution) {
  return target_of([=](const Vector3d& p) { return to_box(p, half); }, half, resolution);
}
Target sphere_target(int resolution) {
  return target_of([](const Vector3d& p) { return p.norm() - 0.25; }, Vector3d::Constant(0.25), resolution);
}
// Two arms along z, joined at the bottom, with a gap of 0.06 between them.
Target u_target(int resolution) {
  const Vector3d half(0.25, 0.1, 0.25);
  return target_of([=](const Vector3d& p) { return std::max(to_box(p, half), -to_box(p - Vector3d(0, 0, 0.1), {0.03, 0.3, 0.25})); }, half, resolution);
}

// Characters --------------------------------------------------------------------------------------------------------

ArmatureBone bone(const std::string& name, int parent, const Vector3d& head, const Vector3d& tail, const Vector3d& hinge) {
  ArmatureBone b{name, parent, head, tail, Eigen::Matrix3d::Identity(), {}};
  b.axes.col(1) = (tail - head).normalized();
  b.axes.col(0) = (hinge - hinge.dot(b.axes.col(1)) * b.axes.col(1)).normalized();
  b.axes.col(2) = b.axes.col(0).cross(b.axes.col(1));
  if (parent >= 0) b.hinges.push_back({0, -M_PI, M_PI});
  return b;
}

struct Posed {
  Character character;
  Embedding embedding;
};

// A character standing in the target just as its bones are given.
Posed as_given(const std::vector<ArmatureBone>& bones, const Target& target) {
  Posed posed;
  posed.character = fitted(make_character(bones), target.volume, kLongestSide, 0.87 * target.distance.shape.step, 1);
  posed.embedding.morphology = Morphology::Ones(Eigen::Index(posed.character.bones.size()));
  posed.embedding.pose = rest_pose(posed.character, posed.character.root_rest);
  return posed;
}

// A random chain with a branch, folded at random within the target's middle.
Posed random_pose(const Target& target, unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) { return a + (b - a) * (random() / 4294967296.0); };
  std::vector<ArmatureBone> bones{bone("root", -1, {0, -0.05, -0.17}, {0, 0.05, -0.17}, Vector3d::UnitX())};
  for (int k = 1; k < 7; ++k) {
    const int parent = int(random() % k);
    const Vector3d head = bones[parent].tail;
    Vector3d tail;
    do {
      tail = head + Vector3d(between(-0.12, 0.12), between(-0.12, 0.12), between(-0.12, 0.12));
    } while (sample(target.distance, tail) > -0.02 || (tail - head).norm() < 0.03);
    bones.push_back(bone("b" + std::to_string(k), parent, head, tail, Vector3d(between(-1, 1), between(-1, 1), between(-1, 1))));
  }
  return as_given(bones, target);
}

// Two half boxes, joined by a hinge along y at x = 0 and the given height.
Posed half_boxes(const Target& target, double height) {
  return as_given({bone("left", -1, {-0.2, 0, height}, {0, 0, height}, Vector3d::UnitY()),
                   bone("right", 0, {0, 0, height}, {0.2, 0, height}, Vector3d::UnitY())}, target);
}

Segmentation cut_in_halves(const Posed& posed, const Target& target) {
  Segmentation s{target.distance.shape, std::vector<std::int16_t>(target.distance.shape.count(), -1), {},
                 forward_kinematics(posed.character, posed.embedding.pose, posed.embedding.morphology)};
  for (std::size_t i : target.inside) s.owner[i] = s.shape.position(i).x() > 0;
  for (double side : {1.0, -1.0}) {
    Grid<float> phi(s.shape, 0);
    for (std::size_t i = 0; i < s.shape.count(); ++i)
      phi[i] = float(std::clamp(side * s.shape.position(i).x(), -3 * s.shape.step, 3 * s.shape.step));
    s.phi.push_back(phi);
  }
  return s;
}

Segmentation grown(const Posed& posed, const Target& target, int threads = 0) {
  SegmentationOptions options;
  options.threads = threads;
  return grow(posed.character, target, posed.embedding, options, {});
}

// Invariants --------------------------------------------------------------------------------------------------------

float value(const Grid<float>& phi, const GridShape& shape, std::size_t i) {
  if (phi.values.empty()) return 1e9f;
  const Vector3i c = shape.cell(i) - shape.nearest(phi.shape.origin);
  return phi.shape.contains(c) ? phi.at(c) : 1e9f;
}

int pieces_of(const Segmentation& s, const Target& target, int bone) {
  std::vector<char> seen(s.owner.size(), 0);
  int pieces = 0;
  for (std::size_t start : target.inside) {
    if (s.owner[start] != bone || seen[start]) continue;
    ++pieces;
    std::vector<std::size_t> open{start};
    seen[start] = 1;
    while (!open.empty()) {
      const Vector3i c = s.shape.cell(open.back());
      open.pop_back();
      for (int f = 0; f < 6; ++f) {
        Vector3i n = c;
        n[f / 2] += f % 2 ? 1 : -1;
        if (!s.shape.contains(n)) continue;
        const std::size_t k = s.shape.index(n);
        if (s.owner[k] == bone && !seen[k]) seen[k] = 1, open.push_back(k);
      }
    }
  }
  return pieces;
}

void expect_margins(const Segmentation& s, const Target& target) {
  for (std::size_t i : target.inside) {
    const GridShape& box = s.phi[s.owner[i]].shape;
    const Vector3i first = s.shape.nearest(box.origin), c = s.shape.cell(i);
    for (int a = 0; a < 3; ++a) {
      ASSERT_GE(c[a] - first[a], std::min(3, c[a]));
      ASSERT_GE(first[a] + box.size[a] - 1 - c[a], std::min(3, s.shape.size[a] - 1 - c[a]));
    }
  }
}

void expect_tiling(const Segmentation& s, const Posed& posed, const Target& target) {
  const int bones = int(posed.character.bones.size());
  std::vector<std::size_t> count(bones, 0);
  std::vector<char> inside(s.owner.size(), 0);
  for (std::size_t i : target.inside) inside[i] = 1;
  for (std::size_t i = 0; i < s.owner.size(); ++i) {
    ASSERT_EQ(s.owner[i] >= 0, inside[i] != 0);
    if (!inside[i]) continue;
    ASSERT_LT(s.owner[i], bones);
    ++count[s.owner[i]];
    for (int b = 0; b < bones; ++b)
      if (b != s.owner[i]) {
        ASSERT_LT(value(s.phi[s.owner[i]], s.shape, i), value(s.phi[b], s.shape, i));
      }
    ASSERT_LT(value(s.phi[s.owner[i]], s.shape, i), 0);
  }
  for (int b = 0; b < bones; ++b) {
    EXPECT_GT(count[b], 0u) << "bone " << b << " has no part";
    EXPECT_EQ(pieces_of(s, target, b), 1) << "bone " << b;
    for (float v : s.phi[b].values) ASSERT_LE(std::abs(v), 4 * s.shape.step);
  }
  expect_margins(s, target);
  const auto skeleton = segmentation_inner::skeleton_on_lattice(posed.character, target, posed.embedding);
  for (std::size_t i : target.inside)
    if (skeleton.core[i] >= 0) {
      ASSERT_EQ(s.owner[i], skeleton.core[i]);
    }
}

// Curvature (1 / step) of interfaces where only two parts are near and the target's surface is far.
std::vector<float> interface_curvatures(const Segmentation& s, const Target& target) {
  std::vector<float> found;
  for (std::size_t i : target.inside) {
    if (target.distance[i] > -3 * s.shape.step) continue;
    const Vector3i c = s.shape.cell(i);
    std::set<int> near;
    bool beside = false;
    for (int k = 0; k < 125; ++k) {
      const Vector3i o(k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2);
      const int owner = s.owner[s.shape.index(c + o)];
      near.insert(owner);
      beside |= o.cwiseAbs().sum() == 1 && owner != s.owner[i];
    }
    if (!beside || near.size() != 2) continue;
    const Grid<float>& phi = s.phi[s.owner[i]];
    const Vector3i local = c - s.shape.nearest(phi.shape.origin);
    float around[27];
    for (int k = 0; k < 27; ++k) around[k] = phi.at(local + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)) / float(s.shape.step);
    found.push_back(std::abs(segmentation_inner::curvature({around + 13, 1, 3, 9})));
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Target> some_targets() { return {sphere_target(32), box_target({0.25, 0.2, 0.25}, 32), u_target(40)}; }

// Growth ------------------------------------------------------------------------------------------------------------

TEST(Growth, TilesEveryTargetForRandomPoses) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    expect_tiling(grown(posed, target), posed, target);
  }
}

TEST(Growth, LeavesSmoothInterfaces) {
  const Target target = sphere_target(48);
  std::vector<float> all;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto some = interface_curvatures(grown(random_pose(target, seed), target), target);
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  ASSERT_GT(all.size(), 300u);
  // A staircase has a median near 0.5; the threshold of Eq. 6 is 0.25.
  EXPECT_LT(all[all.size() / 2], 0.125f);
  EXPECT_LT(all[all.size() * 9 / 10], 0.25f);
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

// Retiling ----------------------------------------------------------------------------------------------------------

TEST(Retiled, LeavesATilingAsItIs) {
  const Target target = sphere_target(32);
  const Posed posed = random_pose(target, 2);
  const Segmentation before = grown(posed, target);
  const Segmentation after = retiled(before, posed.character, target, posed.embedding);
  EXPECT_EQ(before.owner, after.owner);
  for (std::size_t b = 0; b < before.phi.size(); ++b) EXPECT_EQ(before.phi[b].values, after.phi[b].values);
}

TEST(Retiled, MendsRandomDamageAndOnlyThere) {
  const Target target = sphere_target(40);
  const Posed posed = random_pose(target, 3);
  const Segmentation before = grown(posed, target);
  Segmentation damaged = before;
  const Vector3d spot(0.1, 0.1, 0.1);
  std::mt19937 random(7);
  for (std::size_t i : target.inside)
    if ((before.shape.position(i) - spot).norm() < 0.05) damaged.owner[i] = std::int16_t(int(random() % 8) - 1);
  const Segmentation after = retiled(damaged, posed.character, target, posed.embedding);
  expect_tiling(after, posed, target);
  for (std::size_t i : target.inside) {
    if ((before.shape.position(i) - spot).norm() < 0.05 + 12 * before.shape.step) continue;
    ASSERT_EQ(before.owner[i], after.owner[i]);
    ASSERT_EQ(value(before.phi[before.owner[i]], before.shape, i), value(after.phi[before.owner[i]], after.shape, i));
  }
}

TEST(Retiled, GivesACutOffPieceToTheNeighbourAroundIt) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32);
  const Posed posed = half_boxes(target, 0);
  Segmentation s = cut_in_halves(posed, target);
  for (std::size_t i : target.inside)
    if ((s.shape.position(i) - Vector3d(0.1, 0.05, 0.05)).norm() < 0.035) s.owner[i] = 0;
  const Segmentation after = retiled(s, posed.character, target, posed.embedding);
  expect_tiling(after, posed, target);
  for (std::size_t i : target.inside)
    if (s.shape.position(i).x() > 2 * s.shape.step) {
      ASSERT_EQ(after.owner[i], 1);
    }
}

TEST(Retiled, FillsTheVoidOfARemovedPart) {
  const Target target = sphere_target(32);
  const Posed posed = random_pose(target, 5);
  Segmentation s = grown(posed, target);
  for (auto& o : s.owner)
    if (o == 3) o = -1;
  const Segmentation after = retiled(s, posed.character, target, posed.embedding);
  EXPECT_TRUE(after.phi[3].values.empty());
  for (std::size_t i : target.inside) ASSERT_TRUE(after.owner[i] >= 0 && after.owner[i] != 3);
}

TEST(Retiled, SmoothsAStaircase) {
  const Target target = box_target({0.25, 0.2, 0.2}, 48);
  const Posed posed = half_boxes(target, 0);
  Segmentation s = cut_in_halves(posed, target);
  for (std::size_t i : target.inside) s.owner[i] = s.shape.position(i).x() + 0.21 * s.shape.position(i).y() - 0.4 * s.shape.position(i).z() > 0.01;
  const Segmentation after = retiled(s, posed.character, target, posed.embedding);
  const auto curvatures = interface_curvatures(after, target);
  ASSERT_GT(curvatures.size(), 300u);
  EXPECT_LT(curvatures[curvatures.size() / 2], 0.06f);
  EXPECT_LT(curvatures[curvatures.size() * 95 / 100], 0.25f);
}

TEST(Retiled, RefusesForeignDataAndOwnersThatDoNotExist) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32), other = sphere_target(16);
  const Posed posed = half_boxes(target, 0);
  Segmentation s = cut_in_halves(posed, target);
  EXPECT_THROW(retiled(s, posed.character, other, posed.embedding), InvalidInput);
  Segmentation wrong = s;
  wrong.phi.pop_back();
  EXPECT_THROW(retiled(wrong, posed.character, target, posed.embedding), InvalidInput);
  wrong = s;
  wrong.owner[target.inside[5]] = 9;
  EXPECT_THROW(retiled(wrong, posed.character, target, posed.embedding), InvalidInput);
  wrong = s;
  std::fill(wrong.owner.begin(), wrong.owner.end(), std::int16_t(-1));
  EXPECT_THROW(retiled(wrong, posed.character, target, posed.embedding), InvalidInput);
  Target parted = box_target({0.25, 0.1, 0.1}, 32);
  std::erase_if(parted.inside, [&](std::size_t i) { return std::abs(s.shape.position(i).x() - 0.15) < 1.5 * s.shape.step; });
  wrong = s;
  for (std::size_t i = 0; i < wrong.owner.size(); ++i)
    if (s.shape.position(i).x() > 0.1) wrong.owner[i] = -1;
  EXPECT_THROW(retiled(wrong, posed.character, parted, posed.embedding), InvalidInput);
}

// Transfer ----------------------------------------------------------------------------------------------------------

constexpr double kThickness = 0.08;   // half of it, of the box of two halves

Target bar() { return box_target({0.25, 0.12, kThickness}, 64); }

TransferResult transferred(const Posed& posed, const Target& target, double angle, TransferOptions options, Segmentation* after = nullptr) {
  std::vector<TransferResult> results;
  const Segmentation s = transfer(cut_in_halves(posed, target), posed.character, target, posed.embedding, {{1, 0, 0, angle}}, options, {}, &results);
  if (after) *after = s;
  return results.at(0);
}

TEST(Transfer, FindsTheRadiusOfAHingeInTheMiddle) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0);
  TransferOptions options;
  options.method = TransferMethod::kCylinder;
  // Beyond b / cos(angle / 2) the two halves' arcs leave room for the turn.
  for (double angle : {M_PI / 2, -M_PI / 2, 1.2}) {
    const double expected = kThickness / std::cos(angle / 2);
    EXPECT_NEAR(transferred(posed, target, angle, options).radius, expected, 2 * target.distance.shape.step) << angle;
  }
}

TEST(Transfer, IsNotNeededWhenTheHingeSitsOnTheEdgeThatOpens) {
  const Target target = bar();
  const double h = target.distance.shape.step;
  const Posed posed = half_boxes(target, kThickness - 0.5 * h);
  const TransferResult opens = transferred(posed, target, -M_PI / 2, {});
  EXPECT_EQ(opens.radius, 0);
  EXPECT_EQ(opens.moved_volume, 0);
  EXPECT_LT(opens.left_overlap, 1e-4 * target.volume);
  EXPECT_GT(transferred(posed, target, 0.5, {}).moved_volume, 0) << "the other way it closes";
}

TEST(Transfer, LowersTheOverlapAndMovesNoVolumeOutOfTheTarget) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0);
  for (TransferMethod method : {TransferMethod::kCylinder, TransferMethod::kExact, TransferMethod::kBetter})
    for (TransferDirection direction : {TransferDirection::kChildToParent, TransferDirection::kParentToChild, TransferDirection::kLessVolume}) {
      TransferOptions options;
      options.method = method;
      options.direction = direction;
      Segmentation after;
      const TransferResult result = transferred(posed, target, M_PI / 2, options, &after);
      expect_tiling(after, posed, target);
      EXPECT_GT(result.moved_volume, 0);
      // Without a transfer, half a square of the half thickness is in the way on average.
      const double before = 0.5 * kThickness * kThickness * 0.24;
      EXPECT_LT(result.left_overlap, 0.25 * before);
      if (direction == TransferDirection::kChildToParent) {
        EXPECT_TRUE(result.child_to_parent);
      }
      if (direction == TransferDirection::kParentToChild) {
        EXPECT_FALSE(result.child_to_parent);
      }
    }
}

TEST(Transfer, MovesNoMoreByTheExactWayThanByTheCylinder) {
  const Target target = bar();
  const Posed posed = half_boxes(target, 0.4 * kThickness);
  TransferOptions cylinder, exact;
  cylinder.method = TransferMethod::kCylinder;
  exact.method = TransferMethod::kExact;
  EXPECT_LT(transferred(posed, target, M_PI / 2, exact).moved_volume, 1.1 * transferred(posed, target, M_PI / 2, cylinder).moved_volume);
}

TEST(Transfer, UsesASphereForABallJoint) {
  const Target target = bar();
  std::vector<ArmatureBone> bones{bone("left", -1, {-0.2, 0, 0}, {0, 0, 0}, Vector3d::UnitY()), bone("right", 0, {0, 0, 0}, {0.2, 0, 0}, Vector3d::UnitY())};
  bones[1].hinges = {{0, -2, 2}, {2, -2, 2}};
  const Posed posed = as_given(bones, target);
  std::vector<TransferResult> results;
  TransferOptions options;
  options.direction = TransferDirection::kChildToParent;
  const Segmentation before = cut_in_halves(posed, target);
  const Segmentation after = transfer(before, posed.character, target, posed.embedding, {{1, 0, 0, 0.8}, {1, 1, 0, 0.4}}, options, {}, &results);
  expect_tiling(after, posed, target);
  ASSERT_GT(results.at(0).radius, 0);
  for (std::size_t i : target.inside)
    if (before.owner[i] != after.owner[i]) {
      ASSERT_LT(before.shape.position(i).norm(), results[0].radius + 3 * before.shape.step);
    }
}

TEST(Transfer, KeepsATilingForRandomPosesAndIsTheSameForAnyThreads) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    std::vector<JointRange> ranges;
    for (int b = 1; b < int(posed.character.bones.size()); ++b) ranges.push_back({b, 0, 0, b % 2 ? 1.5 : -1.2});
    TransferOptions one, two;
    one.threads = 1, two.threads = 2;
    const Segmentation s = grown(posed, target);
    std::vector<TransferResult> results;
    const Segmentation after = transfer(s, posed.character, target, posed.embedding, ranges, one, {}, &results);
    EXPECT_EQ(results.size(), ranges.size());
    expect_tiling(after, posed, target);
    EXPECT_EQ(after.owner, transfer(s, posed.character, target, posed.embedding, ranges, two, {}).owner);
  }
}

TEST(Transfer, RefusesBadRangesAndOptionsAndStopsWhenAsked) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32);
  const Posed posed = half_boxes(target, 0);
  const Segmentation s = cut_in_halves(posed, target);
  const auto with = [&](JointRange range, TransferOptions options = {}) {
    return transfer(s, posed.character, target, posed.embedding, {range}, options, {});
  };
  EXPECT_THROW(with({0, 0, 0, 1}), InvalidInput);
  EXPECT_THROW(with({2, 0, 0, 1}), InvalidInput);
  EXPECT_THROW(with({1, 1, 0, 1}), InvalidInput);
  EXPECT_THROW(with({1, 0, 0, NAN}), InvalidInput);
  TransferOptions few;
  few.samples = 1;
  EXPECT_THROW(with({1, 0, 0, 1}, few), InvalidInput);
  TransferOptions threads;
  threads.threads = -1;
  EXPECT_THROW(with({1, 0, 0, 1}, threads), InvalidInput);
  EXPECT_THROW(transfer(s, posed.character, sphere_target(16), posed.embedding, {{1, 0, 0, 1}}, {}, {}), InvalidInput);
  const Progress stop{[](double, std::string_view) { return false; }};
  EXPECT_THROW(transfer(s, posed.character, target, posed.embedding, {{1, 0, 0, 1}}, {}, stop), Cancelled);
}

}  // namespace
}  // namespace transformables
