// Production against the paper to the letter (tests/reference): the objective's terms one by one, the flood, and growth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "embedding/evaluator.h"
#include "embedding/unfolding.h"
#include "reference/cases.h"
#include "reference/growth.h"
#include "reference/objective.h"
#include "segmentation/joint.h"
#include "segmentation/overlaps.h"

namespace transformables {
namespace {

using Eigen::Vector3d;
using reference::CollisionKind;
using reference::Flooded;
using reference::FloodKind;

struct Case {
  std::string name;
  Target target;
  Character character;
};

/// Three characters, in targets of which one has a gap that ways must go round.
std::vector<Case> cases(int resolution) {
  std::vector<Case> made{{"spider in a ball", reference::ball(resolution), {}},
                         {"humanoid in a box", reference::box({0.15, 0.12, 0.25}, resolution), {}},
                         {"snake in a U", reference::u_shape(resolution), {}}};
  made[0].character = reference::spider(made[0].target);
  made[1].character = reference::humanoid(made[1].target);
  made[2].character = reference::snake(made[2].target);
  return made;
}

/// The options under which the reference means what production means.
reference::ObjectiveOptions like_production(const Voxels& voxels) {
  return {FloodKind::kShortestWay, CollisionKind::kBeyondJoints, voxels.stride, voxels.spacing, Unfolding::kSamples};
}

/// Production's own segmentation of its last evaluation, in the reference's form.
std::vector<Flooded> flooded_by(const Evaluator& evaluator, const Voxels& voxels, const GridShape& shape) {
  std::vector<Flooded> flooded(shape.count());
  const Eigen::Vector3i low = voxels.first_sample / voxels.stride;
  for (int z = 0; z < voxels.size.z(); ++z)
    for (int y = 0; y < voxels.size.y(); ++y)
      for (int x = 0; x < voxels.size.x(); ++x) {
        const std::int32_t cell = evaluator.field()[std::size_t(voxels.cell(x, y, z))];
        if ((cell & kNoLabel) == kNoLabel) continue;
        flooded[shape.index(low + Eigen::Vector3i(x, y, z))] = {std::int16_t(cell & kNoLabel), cell >> kLabelBits};
      }
  return flooded;
}

bool planted(const std::vector<Flooded>& flooded) {
  return std::any_of(flooded.begin(), flooded.end(), [](const Flooded& f) { return f.bone >= 0; });
}

/// Calls `check(production's terms, pose, morphology, production's flood)` on random poses of a case.
template <class Check>
void for_random_poses(const Case& at, int count, const Check& check) {
  const auto voxels = std::make_shared<const Voxels>(at.target);
  Evaluator evaluator(at.character, at.target, voxels, {});
  const reference::Objective letter(at.character, at.target, {}, like_production(*voxels));
  Random random(17);
  for (int round = 0; round < count; ++round) {
    SCOPED_TRACE(at.name + ", pose " + std::to_string(round));
    const Pose pose = reference::random_pose(at.character, random, 0.08);
    const Morphology morphology = reference::random_morphology(at.character, random);
    const ObjectiveTerms terms = evaluator(pose, morphology).terms;
    const std::vector<Flooded> flooded = flooded_by(evaluator, *voxels, letter.shape());
    if (planted(flooded)) check(letter, terms, pose, morphology, flooded);
    if (testing::Test::HasFatalFailure()) return;
  }
}

void expect_close(double a, double b, double relative, const char* what) {
  EXPECT_NEAR(a, b, relative * std::max({std::abs(a), std::abs(b), 1e-9})) << what;
}

// ---- the objective ----

TEST(ReferenceObjective, EachTermOfProductionAgreesToRoundingWhereDefinitionsAreEqual) {
  const ObjectiveWeights weights;
  for (const Case& at : cases(20))
    for_random_poses(at, 334, [&](const auto& letter, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const ObjectiveTerms expected = letter.terms(pose, morphology, flooded);
      expect_close(terms.compact, expected.compact, 1e-9, "compact");
      expect_close(terms.skin, expected.skin, 1e-9, "skin");
      expect_close(terms.skeleton, expected.skeleton, 1e-9, "skeleton");
      expect_close(terms.protrude, expected.protrude, 1e-6, "protrude");
      expect_close(terms.limits, expected.limits, 1e-12, "limits");
      expect_close(terms.morphology, expected.morphology, 1e-12, "morphology");
      EXPECT_NEAR(terms.unfold, expected.unfold, 2.5 / Unfolding::kSamples);  // single precision: a sample between two voxels may go to the other
      expect_close(terms.total - weights.unfold * terms.unfold, expected.total - weights.unfold * expected.unfold, 1e-6, "total");
    });
}

TEST(ReferenceObjective, AFineGridIsSampledOnTheSameLatticeWithTheSameWeights) {
  for (const Case& at : cases(72)) {
    const Voxels voxels(at.target);
    EXPECT_EQ(voxels.stride, 2);
    for_random_poses(at, 3, [](const auto& letter, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const ObjectiveTerms expected = letter.terms(pose, morphology, flooded);
      expect_close(terms.compact, expected.compact, 1e-9, "compact");
      expect_close(terms.skin, expected.skin, 1e-9, "skin");
    });
  }
  const Case at = cases(40)[1];
  EXPECT_EQ(Voxels(at.target).spacing, 5);
  for_random_poses(at, 5, [](const auto& letter, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
    const ObjectiveTerms expected = letter.terms(pose, morphology, flooded);
    expect_close(terms.compact, expected.compact, 1e-9, "compact");
    expect_close(terms.skin, expected.skin, 1e-9, "skin");
  });
}

TEST(ReferenceObjective, OneVoxelInFiveTellsTheSumOverAllOfThem) {
  const Case at = cases(40)[1];
  reference::ObjectiveOptions every = like_production(Voxels(at.target));
  every.spacing = 1;
  const reference::Objective all(at.character, at.target, {}, every);
  for_random_poses(at, 10, [&](const auto&, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
    const ObjectiveTerms expected = all.terms(pose, morphology, flooded);
    expect_close(terms.compact, expected.compact, 0.02, "compact");
    expect_close(terms.skin, expected.skin, 0.2, "skin");  // few samples: one voxel in five of a joint's interface
  });
}

TEST(ReferenceObjective, AFewHundredSamplesTellWhatIsInTheWayOfAllVoxels) {
  double mean = 0;
  for (const Case& at : cases(20)) {
    reference::ObjectiveOptions every = like_production(Voxels(at.target));
    every.unfolded = 0;
    const reference::Objective all(at.character, at.target, {}, every);
    for_random_poses(at, 10, [&](const auto&, const ObjectiveTerms& terms, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const double expected = all.terms(pose, morphology, flooded).unfold;
      EXPECT_NEAR(terms.unfold, expected, 0.1);
      mean += std::abs(terms.unfold - expected) / 30;
    });
  }
  EXPECT_LT(mean, 0.04);
}

TEST(ReferenceObjective, TheFloodGivesEveryVoxelTheBoneAndDistanceThatDijkstraGives) {
  for (const Case& at : cases(24))
    for_random_poses(at, 20, [](const auto& letter, const ObjectiveTerms&, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const std::vector<Flooded> expected = letter.flood(pose, morphology);
      std::size_t other_bone = 0, other_distance = 0, inside = 0;
      for (std::size_t v = 0; v < expected.size(); ++v) {
        ASSERT_EQ(expected[v].bone < 0, flooded[v].bone < 0);
        if (expected[v].bone < 0) continue;
        ++inside;
        other_bone += expected[v].bone != flooded[v].bone;
        other_distance += std::abs(expected[v].distance - flooded[v].distance) > 1;
      }
      EXPECT_EQ(other_distance, 0u);
      // A start that rounds the other way (1/32 of a voxel) may hand over a tie.
      EXPECT_LE(double(other_bone), 0.001 * double(inside));
    });
}

TEST(ReferenceObjective, ThePapersFrontsReachEveryVoxelAndCountStepsOfTheFlood) {
  const Case at = cases(24)[2];
  const reference::Objective letter(at.character, at.target, {});
  Random random(3);
  const Pose pose = reference::random_pose(at.character, random, 0.02);
  const Morphology morphology = Morphology::Ones(Eigen::Index(at.character.bones.size()));
  const std::vector<Flooded> flooded = letter.flood(pose, morphology);
  const GridShape& shape = letter.shape();
  for (const std::size_t v : at.target.inside) {
    ASSERT_GE(flooded[v].bone, 0);
    if (flooded[v].distance == 0) continue;
    bool follows = false;
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i n = shape.cell(v) + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (!shape.contains(n) || flooded[shape.index(n)].bone < 0) continue;
      ASSERT_GE(flooded[shape.index(n)].distance, flooded[v].distance - 1);
      follows |= flooded[shape.index(n)].distance == flooded[v].distance - 1 && flooded[shape.index(n)].bone == flooded[v].bone;
    }
    ASSERT_TRUE(follows);
  }
}

// The paper's fronts move by one voxel whatever the direction, so that they run 1.7 times faster along diagonals: parts differ from
// those by true ways. This is what is left in common.
TEST(ReferenceObjective, ThePapersFloodAndProductionsGiveMostVoxelsTheSameBone) {
  for (const Case& at : cases(32)) {
    const reference::Objective paper(at.character, at.target, {});
    double same = 0, inside = 0;
    for_random_poses(at, 20, [&](const auto&, const ObjectiveTerms&, const Pose& pose, const Morphology& morphology, const auto& flooded) {
      const std::vector<Flooded> fronts = paper.flood(pose, morphology);
      for (const std::size_t v : at.target.inside) {
        same += fronts[v].bone == flooded[v].bone;
        ++inside;
      }
    });
    std::cout << "  " << at.name << ": same bone on " << 100 * same / inside << " % of voxels\n";
    EXPECT_GT(same / inside, 0.6) << at.name;
  }
}

TEST(ReferenceObjective, MovingLeastSquaresFindTheNormalOfAFlatInterface) {
  // Two bones end to end through a box, hinged about x: the interface is the plane between, and turning about an axis in it moves
  // its points along its normal, by their distance from the axis: Eq. 3 is a sum that can be done by hand.
  const Target target = reference::box({0.1, 0.25, 0.1}, 40);
  std::vector<ArmatureBone> bones{{"a", -1, {0, -0.2, 0}, {0, 0, 0}, Eigen::Matrix3d::Identity(), {}},
                                  {"b", 0, {0, 0, 0}, {0, 0.2, 0}, Eigen::Matrix3d::Identity(), {{0, -1, 0.5}}}};
  Character character = make_character(bones);
  for (Bone& bone : character.bones) bone.radius = 0.02;
  Pose pose{Eigen::Isometry3d::Identity(), Eigen::VectorXd::Zero(1)};
  pose.root.translation() = Vector3d(0, -0.2, 0);
  reference::ObjectiveOptions options;
  options.flood = FloodKind::kShortestWay;
  const double letter = reference::Objective(character, target, {}, options)(pose, Morphology::Ones(2)).skin;
  const double h = target.distance.shape.step;
  double expected = 0;
  for (int i = -8; i < 8; ++i)
    for (int k = -8; k < 8; ++k) {
      const double z = (k + 0.5) * h;   // velocity (1, 0, 0) x (x, 0, z) = (0, -z, 0); the normal to the parent is -y
      expected += std::max(-1 * z, 0.0) + std::max(0.5 * z, 0.0);
    }
  EXPECT_NEAR(letter, expected * std::pow(h / 0.01, 2), 1e-9);
}

TEST(ReferenceObjective, PlainEq4CountsNeighboursThatShareAJointAndProductionDoesNot) {
  // A short bone between two long ones, in a line: plain Eq. 4 has the long ones collide across it, at rest and for ever.
  const Target target = reference::box({0.1, 0.25, 0.1}, 24);
  const auto bone = [](const char* name, int parent, double from, double to) {
    return ArmatureBone{name, parent, {0, from, 0}, {0, to, 0}, Eigen::Matrix3d::Identity(), {{0, -2, 2}}};
  };
  std::vector<ArmatureBone> bones{bone("a", -1, 0, 0.1), bone("b", 0, 0.1, 0.12), bone("c", 1, 0.12, 0.22)};
  bones[0].hinges.clear();
  Character character = make_character(bones);
  for (Bone& b : character.bones) b.radius = 0.02;
  const Pose pose = rest_pose(character, Eigen::Isometry3d(Eigen::Translation3d(0, -0.1, 0)));
  const Morphology morphology = Morphology::Ones(3);
  reference::ObjectiveOptions beyond;
  beyond.collisions = CollisionKind::kBeyondJoints;
  EXPECT_NEAR(reference::Objective(character, target, {})(pose, morphology).skeleton, 0.02 * 0.02, 1e-12);
  EXPECT_EQ(reference::Objective(character, target, {}, beyond)(pose, morphology).skeleton, 0);
  EXPECT_EQ(Objective(character, target, {})(pose, morphology).skeleton, 0);
}

// ---- growth ----

double tie_distance(const reference::Growth& growth, std::size_t v) {
  float least = 1e9f, second = 1e9f;
  for (const auto& g : growth.phi) {
    second = std::min(second, std::max(g[v], least));
    least = std::min(least, g[v]);
  }
  return 0.5 * double(second - least);
}

struct Agreement {
  double same = 0, all = 0;
  int steps = 0;
};

/// Production's owner and the letter's, at inside samples more than one voxel from a tie.
Agreement compare_growth(const Character& character, const Target& target, const Embedding& embedding) {
  const reference::Growth letter = reference::grow(character, target, embedding, {});
  const Segmentation ours = grow(character, target, embedding, {}, {});
  Agreement result;
  result.steps = letter.steps;
  for (const std::size_t v : target.inside) {
    if (tie_distance(letter, v) <= target.distance.shape.step) continue;
    ++result.all;
    result.same += letter.owner[v] == ours.owner[v];
  }
  return result;
}

Agreement expect_same_growth(const std::string& name, const Character& character, const Target& target, const Embedding& embedding, double least = 0.98) {
  const Agreement agreement = compare_growth(character, target, embedding);
  std::cout << "  " << name << ": same bone on " << 100 * agreement.same / agreement.all << " % of the " << 100 * agreement.all / double(target.inside.size())
            << " % of samples away from ties, " << agreement.steps << " steps\n";
  EXPECT_GT(agreement.all, 0.2 * double(target.inside.size())) << name;
  EXPECT_GE(agreement.same / agreement.all, least) << name;
  return agreement;
}

TEST(ReferenceGrowth, RedistancingFindsTheDistanceFromTheZeroLevelAndLeavesItThere) {
  const Target target = reference::ball(24);
  Grid<float> phi(target.distance.shape, 0);
  const double h = phi.shape.step;
  for (std::size_t i = 0; i < phi.values.size(); ++i) {
    const double d = phi.shape.position(i).norm() - 0.17;
    phi[i] = float(d * (1 + 8 * std::abs(d)) * 0.6);  // the right zero, the wrong slope
  }
  reference::redistance(phi);
  double worst = 0;
  for (std::size_t i = 0; i < phi.values.size(); ++i) {
    const double d = phi.shape.position(i).norm() - 0.17;
    if (std::abs(d) > 1e-6) {
      ASSERT_EQ(phi[i] < 0, d < 0);
    }
    worst = std::max(worst, std::abs(phi[i] - d));
  }
  EXPECT_LT(worst, 0.8 * h);  // first order
}

TEST(ReferenceGrowth, TwoEqualBonesShareABoxAtItsMiddle) {
  const Target target = reference::box({0.1, 0.25, 0.1}, 24);
  std::vector<ArmatureBone> bones{{"a", -1, {0, -0.15, 0}, {0, -0.05, 0}, Eigen::Matrix3d::Identity(), {}},
                                  {"b", 0, {0, 0.05, 0}, {0, 0.15, 0}, Eigen::Matrix3d::Identity(), {{0, -1, 1}}}};
  Character character = make_character(bones);
  for (Bone& bone : character.bones) {
    bone.radius = 0.02;
    bone.segments.resize(1);
    bone.segments[0] = {Vector3d::Zero(), Vector3d(0, 0.1, 0)};  // not on to the child's head: the two are apart, and alike
  }
  Embedding embedding;
  embedding.pose = rest_pose(character, Eigen::Isometry3d(Eigen::Translation3d(0, -0.15, 0)));
  embedding.morphology = Morphology::Ones(2);
  const reference::Growth growth = reference::grow(character, target, embedding, {});
  for (const std::size_t v : target.inside) {
    const double y = target.distance.shape.position(v).y();
    ASSERT_EQ(growth.owner[v], y > 0 ? 1 : 0);
  }
  expect_same_growth("two bones in a box", character, target, embedding);
}

TEST(ReferenceGrowth, ProductionGivesTheSameBoneAwayFromTies) {
  // In some poses a pocket that two fronts reach at nearly the same time goes to the one here, to the other there (docs/performance.md).
  Agreement sum;
  for (const Case& at : cases(20)) {
    const Agreement agreement = expect_same_growth(at.name, at.character, at.target, reference::folded(at.character, at.target), 0.95);
    sum.same += agreement.same, sum.all += agreement.all;
  }
  EXPECT_GE(sum.same / sum.all, 0.98);
}

// ---- real targets ----

std::vector<std::filesystem::path> shared_targets() {
  std::vector<std::filesystem::path> files;
  if (const char* shared = std::getenv("TRANSFORMABLES_SHARED"))
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(shared) / "data" / "targets"))
      if (entry.path().extension() == ".ply") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Little-endian PLY with float positions first and lists of 32-bit corners, as the shared targets are.
Target ply_target(const std::filesystem::path& file, int resolution) {
  std::ifstream in(file, std::ios::binary);
  std::size_t vertex_count = 0, face_count = 0;
  for (std::string line; std::getline(in, line) && line != "end_header";) {
    std::istringstream words(line);
    std::string first, second;
    words >> first >> second;
    if (second == "vertex") words >> vertex_count;
    if (second == "face") words >> face_count;
  }
  std::vector<Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    float p[3] = {};
    in.read(reinterpret_cast<char*>(p), sizeof p);
    vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (std::size_t f = 0; f < face_count && in; ++f) {
    std::vector<std::int32_t> corners(std::size_t(std::max(0, in.get())), 0);
    in.read(reinterpret_cast<char*>(corners.data()), std::streamsize(4 * corners.size()));
    for (std::size_t k = 2; k < corners.size(); ++k) triangles.emplace_back(corners[0], corners[k - 1], corners[k]);
  }
  return make_target(vertices, triangles, {resolution}, {});
}

TEST(SharedTargets, ProductionGrowsLikeTheReferenceInThem) {
  const auto files = shared_targets();
  if (files.empty()) {
    std::cout << "*** SKIPPED: TRANSFORMABLES_SHARED is not set, so growth was compared on made targets only ***\n";
    GTEST_SKIP() << "TRANSFORMABLES_SHARED is not set";
  }
  // The whole sweep takes minutes (TRANSFORMABLES_SWEEP=1), and at 24 voxels it does not hold everywhere yet: docs/performance.md.
  const std::set<std::string> sample{"egg.ply", "wheel.ply", "oval.ply", "bunny.ply"};
  for (const auto& file : files) {
    if (!std::getenv("TRANSFORMABLES_SWEEP") && !sample.count(file.filename().string())) continue;
    const Target target = ply_target(file, 24);
    const Character character = reference::spider(target);
    expect_same_growth(file.filename().string(), character, target, reference::folded(character, target));
  }
}

std::vector<JointRange> from_folded_to_rest(const Character& character, const Embedding& embedding) {
  std::vector<JointRange> ranges;
  for (int b = 0; b < int(character.bones.size()); ++b)
    for (int k = 0; k < int(character.bones[b].hinges.size()); ++k) ranges.push_back({b, k, embedding.pose.angles[character.bones[b].first_angle + k], 0});
  return ranges;
}

TEST(SharedTargets, AfterTransferParentAndChildHardlyOverlapAnywhereOnTheirWay) {
  const auto files = shared_targets();
  if (files.empty()) GTEST_SKIP() << "TRANSFORMABLES_SHARED is not set";
  const std::set<std::string> sample{"egg.ply", "wheel.ply"};
  for (const auto& file : files) {
    if (!std::getenv("TRANSFORMABLES_SWEEP") && !sample.count(file.filename().string())) continue;
    SCOPED_TRACE(file.filename().string());
    const Target target = ply_target(file, 64);
    const Character character = reference::humanoid(target);
    const Embedding embedding = reference::folded(character, target);
    const auto ranges = from_folded_to_rest(character, embedding);
    const Segmentation after = transfer(grow(character, target, embedding, {}, {}), character, target, embedding, ranges, {}, {});
    int joints = 0, over = 0;
    cases::Overlap worst;
    for (const auto& joint : segmentation_inner::joints_of(character, embedding, ranges, 50)) {
      const cases::Overlap one = cases::overlap_on_the_way(after, target, joint);
      worst = {std::max(worst.whole, one.whole), std::max(worst.deep, one.deep)};
      ++joints, over += one.whole > 1e-4;
    }
    std::cout << file.filename().string() << ": " << over << " of " << joints << " joints overlap by more than 0.01 %, the worst by " << 100 * worst.whole
              << " %, deeper than half a voxel " << 100 * worst.deep << " %\n";
    EXPECT_LE(over, joints / 4);
    EXPECT_LT(worst.deep, 1e-4) << "of the target's volume, deeper than half a voxel";
  }
}

}  // namespace
}  // namespace transformables
