#include <gtest/gtest.h>

#include "segmentation/edits.h"
#include "segmentation/cases.h"

namespace transformables {
namespace {

using namespace cases;
using Corners = std::array<Vector3d, 3>;

std::vector<Corners> rectangle(const Vector3d& corner, const Vector3d& a, const Vector3d& b) {
  return {{corner, corner + a, corner + a + b}, {corner, corner + a + b, corner + b}};
}

Edit of_bone(EditKind kind, const std::string& bone, double reach = 0) {
  Edit edit;
  edit.kind = kind, edit.bone = bone, edit.reach = reach;
  return edit;
}

Edit painted(EditKind kind, const std::string& name, const std::vector<Corners>& faces, const std::string& bone = "") {
  Edit edit;
  edit.kind = kind, edit.name = name, edit.painted = faces, edit.bone = bone;
  return edit;
}

Segmentation replayed(const Segmentation& s, const Posed& posed, const Target& target, const std::vector<Edit>& edits, EditReport* report = nullptr) {
  return edited(s, posed.character, target, posed.embedding, edits, report);
}

// Three bones in a row along x, in a box.
struct Row {
  Target target = box_target({0.25, 0.1, 0.1}, 48);
  Posed posed = as_given({bone("left", -1, {-0.22, 0, 0}, {-0.08, 0, 0}, Vector3d::UnitY()), bone("middle", 0, {-0.08, 0, 0}, {0.08, 0, 0}, Vector3d::UnitY()),
                          bone("right", 1, {0.08, 0, 0}, {0.22, 0, 0}, Vector3d::UnitY())}, target);
  Segmentation grown_ = grown(posed, target);
  // Owners of the samples right under a rectangle of the top face.
  std::set<int> owners_under(const Segmentation& s, double x0, double x1, double y0, double y1) const {
    std::set<int> found;
    for (std::size_t i : target.inside) {
      const Vector3d p = s.shape.position(i);
      if (p.z() > 0.1 - 1.5 * s.shape.step && p.x() > x0 && p.x() < x1 && p.y() > y0 && p.y() < y1) found.insert(s.owner[i]);
    }
    return found;
  }
};

std::vector<Corners> top(double x0, double x1, double y0, double y1) { return rectangle({x0, y0, 0.1}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}); }

TEST(Edits, OfAnEmptyListChangeNothing) {
  const Row row;
  EditReport report;
  const Segmentation after = replayed(row.grown_, row.posed, row.target, {}, &report);
  EXPECT_EQ(after.owner, row.grown_.owner);
  EXPECT_TRUE(after.pinned.empty() && after.inhibited.empty() && report.empty());
}

TEST(Edits, ThatRemoveASkinLeaveItsPlaceToTheNeighbours) {
  const Row row;
  EditReport report;
  const Segmentation after = replayed(row.grown_, row.posed, row.target, {of_bone(EditKind::kRemove, "middle")}, &report);
  expect_tiling(after, row.posed, row.target, {1});
  EXPECT_TRUE(report.empty());
}

TEST(Edits, ThatRemoveEverySkinKeepTheLastOne) {
  const Row row;
  EditReport report;
  const Segmentation after = replayed(row.grown_, row.posed, row.target,
                                      {of_bone(EditKind::kRemove, "middle"), of_bone(EditKind::kRemove, "left"), of_bone(EditKind::kRemove, "right")}, &report);
  expect_tiling(after, row.posed, row.target, {0, 1});
  ASSERT_EQ(report.size(), 1u);
  EXPECT_NE(report[0].find("'right'"), std::string::npos);
}

TEST(Edits, ThatInhibitABoneKeepItToItsSkeletonAndReach) {
  const Row row;
  const double h = row.target.distance.shape.step;
  for (double reach : {0.0, 3 * h}) {
    EditReport report;
    const Segmentation after = replayed(row.grown_, row.posed, row.target, {of_bone(EditKind::kInhibit, "middle", reach)}, &report);
    expect_tiling(after, row.posed, row.target);
    EXPECT_TRUE(report.empty());
    EXPECT_FALSE(after.may_grow(1));
    const auto skeleton = segmentation_inner::skeleton_on_lattice(row.posed.character, row.target, row.posed.embedding);
    std::size_t kept = 0;
    for (std::size_t i : row.target.inside)
      if (after.owner[i] == 1) {
        ++kept;
        ASSERT_LT(segmentation_inner::distance_to_bone(skeleton, 1, after.shape.position(i)), reach + 2 * h);
      }
    EXPECT_GT(kept, 20u);
    EXPECT_LT(kept, std::size_t(std::count(row.grown_.owner.begin(), row.grown_.owner.end(), 1)) / (reach > 0 ? 2 : 4));
  }
}

TEST(Edits, ThatKeepARegionWholeGiveItToThePartThatHoldsMostOfIt) {
  const Row row;
  ASSERT_GT(row.owners_under(row.grown_, -0.15, 0.05, -0.05, 0.05).size(), 1u) << "the region is split before";
  EditReport report;
  const Segmentation after = replayed(row.grown_, row.posed, row.target, {painted(EditKind::kKeepWhole, "lid", top(-0.15, 0.05, -0.05, 0.05))}, &report);
  expect_tiling(after, row.posed, row.target);
  EXPECT_TRUE(report.empty()) << report[0];
  EXPECT_EQ(row.owners_under(after, -0.15, 0.05, -0.05, 0.05), std::set<int>{1});
}

TEST(Edits, ThatAssignARegionGiveItToTheNamedBone) {
  const Row row;
  EditReport report;
  const Segmentation after = replayed(row.grown_, row.posed, row.target, {painted(EditKind::kAssign, "lid", top(-0.15, 0.05, -0.05, 0.05), "left")}, &report);
  expect_tiling(after, row.posed, row.target);
  EXPECT_TRUE(report.empty()) << report[0];
  EXPECT_EQ(row.owners_under(after, -0.15, 0.05, -0.05, 0.05), std::set<int>{0});
}

TEST(Edits, ReachARegionFarFromTheNamedBoneByAWayThroughOthers) {
  const Row row;
  EditReport report;
  const Segmentation after = replayed(row.grown_, row.posed, row.target, {painted(EditKind::kAssign, "lid", top(0.1, 0.2, -0.05, 0.05), "left")}, &report);
  expect_tiling(after, row.posed, row.target);
  EXPECT_TRUE(report.empty()) << report[0];
  EXPECT_EQ(row.owners_under(after, 0.1, 0.2, -0.05, 0.05), std::set<int>{0});
}

TEST(Edits, PinWhatTheyGiveWithAWayToTheBonesOwnCore) {
  const Row row;
  const Segmentation after = replayed(row.grown_, row.posed, row.target, {painted(EditKind::kAssign, "lid", top(0.1, 0.2, -0.05, 0.05), "left")});
  const auto skeleton = segmentation_inner::skeleton_of_edited(row.posed.character, row.target, row.posed.embedding, after);
  Segmentation held = after;
  held.owner = skeleton.core;
  EXPECT_EQ(pieces_of(held, row.target, 0), 1);
  EXPECT_GT(std::count(after.pinned.begin(), after.pinned.end(), 1), 100);
}

TEST(Edits, SurviveTransferAndRetiling) {
  const Row row;
  const Segmentation after = replayed(row.grown_, row.posed, row.target,
                                      {painted(EditKind::kAssign, "lid", top(-0.15, 0.05, -0.05, 0.05), "left"), of_bone(EditKind::kInhibit, "right")});
  const std::vector<JointRange> ranges{{1, 0, 0, 1.5}, {2, 0, 0, -1.5}};
  std::vector<TransferResult> results;
  const Segmentation moved = transfer(after, row.posed.character, row.target, row.posed.embedding, ranges, {}, {}, &results);
  EXPECT_GT(results[0].moved_volume + results[1].moved_volume, 0);
  for (const Segmentation& s : {moved, retiled(moved, row.posed.character, row.target, row.posed.embedding)}) {
    expect_tiling(s, row.posed, row.target);
    EXPECT_EQ(row.owners_under(s, -0.15, 0.05, -0.05, 0.05), std::set<int>{0});
    EXPECT_LT(std::count(s.owner.begin(), s.owner.end(), 2), 1.1 * double(std::count(after.owner.begin(), after.owner.end(), 2)));
  }
}

TEST(Edits, ThatMakeNoSenseAnyMoreAreLeftOutAndTold) {
  const Row row;
  const auto told = [&](const std::vector<Edit>& edits, const std::string& words) {
    EditReport report;
    const Segmentation after = replayed(row.grown_, row.posed, row.target, edits, &report);
    ASSERT_EQ(report.size(), 1u) << words;
    EXPECT_NE(report[0].find(words), std::string::npos) << report[0];
    EXPECT_NE(report[0].find("left out"), std::string::npos) << report[0];
    if (edits.size() == 1) {
      EXPECT_EQ(after.owner, row.grown_.owner) << words;
    }
  };
  told({of_bone(EditKind::kRemove, "tail")}, "no bone 'tail'");
  told({of_bone(EditKind::kInhibit, "tail")}, "no bone 'tail'");
  told({painted(EditKind::kAssign, "lid", top(-0.1, 0, -0.05, 0.05), "tail")}, "no bone 'tail'");
  told({painted(EditKind::kKeepWhole, "lid", {})}, "no face");
  told({painted(EditKind::kKeepWhole, "lid", rectangle({-0.1, -0.05, 0.3}, {0.1, 0, 0}, {0, 0.1, 0}))}, "not on the target");
  told({of_bone(EditKind::kRemove, "left"), painted(EditKind::kAssign, "lid", top(-0.1, 0, -0.05, 0.05), "left")}, "'left' has no skin");
  told({of_bone(EditKind::kInhibit, "left"), of_bone(EditKind::kInhibit, "middle"), of_bone(EditKind::kInhibit, "right")}, "no part would be left");
}

// A bone that stands across a slim bar, with one on each side.
TEST(Edits, ThatWouldCutAnotherPartInTwoAreLeftOut) {
  const Target target = box_target({0.25, 0.1, 0.1}, 48);
  const Posed posed = as_given({bone("stub", -1, {-0.22, 0, 0}, {-0.19, 0, 0}, Vector3d::UnitY()), bone("far", 0, {-0.19, 0, 0}, {-0.16, 0, 0}, Vector3d::UnitY())}, target);
  const Segmentation before = grown(posed, target);
  // A band about the whole bar, nearer to "far"'s bone than to the bar's other end: what lies beyond would come off.
  std::vector<Corners> band;
  for (const auto& part : {rectangle({-0.1, -0.1, 0.1}, {0.06, 0, 0}, {0, 0.2, 0}), rectangle({-0.1, -0.1, -0.1}, {0.06, 0, 0}, {0, 0.2, 0}),
                           rectangle({-0.1, 0.1, -0.1}, {0.06, 0, 0}, {0, 0, 0.2}), rectangle({-0.1, -0.1, -0.1}, {0.06, 0, 0}, {0, 0, 0.2})})
    band.insert(band.end(), part.begin(), part.end());
  EditReport report;
  const Segmentation after = replayed(before, posed, target, {painted(EditKind::kAssign, "band", band, "stub")}, &report);
  ASSERT_EQ(report.size(), 1u);
  EXPECT_NE(report[0].find("cut the part of 'far' in two"), std::string::npos) << report[0];
  EXPECT_EQ(after.owner, before.owner);
}

TEST(Edits, LeaveASkeletonThatLiesUnderThePaintAndTellIt) {
  const Target target = box_target({0.25, 0.1, 0.1}, 48);
  const double h = target.distance.shape.step;
  const Posed posed = as_given({bone("low", -1, {-0.2, 0, -0.05}, {0, 0, -0.05}, Vector3d::UnitY()), bone("high", 0, {-0.1, 0, 0.1 - h}, {0.1, 0, 0.1 - h}, Vector3d::UnitY())}, target);
  EditReport report;
  const Segmentation after = replayed(grown(posed, target), posed, target, {painted(EditKind::kAssign, "lid", top(-0.15, 0.15, -0.06, 0.06), "low")}, &report);
  expect_tiling(after, posed, target);
  ASSERT_EQ(report.size(), 1u);
  EXPECT_NE(report[0].find("'high'"), std::string::npos) << report[0];
}

TEST(Edits, StayOnOneSideOfAGap) {
  const Target target = u_target(48);
  const Posed posed = as_given({bone("foot", -1, {0, 0, -0.2}, {0.14, 0, -0.2}, Vector3d::UnitY()), bone("left", 0, {-0.14, 0, -0.2}, {-0.14, 0, 0.2}, Vector3d::UnitY()),
                                bone("right", 0, {0.14, 0, -0.2}, {0.14, 0, 0.2}, Vector3d::UnitY())}, target);
  const Segmentation before = grown(posed, target);
  // The left arm's face along the gap.
  const Segmentation after = replayed(before, posed, target, {painted(EditKind::kAssign, "wall", rectangle({-0.03, -0.05, 0}, {0, 0.1, 0}, {0, 0, 0.15}), "left")});
  expect_tiling(after, posed, target);
  for (std::size_t i : target.inside)
    if (after.shape.position(i).x() > 0.03 && after.shape.position(i).z() > 0) {
      ASSERT_EQ(after.owner[i], before.owner[i]);
    }
}

TEST(Edits, OfRandomPosesLeaveATilingThatHoldsThem) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    const std::string removed = "b" + std::to_string(1 + seed % 6), still = "b" + std::to_string(1 + (seed + 2) % 6);
    const Segmentation before = grown(posed, target);
    // Flat triangles on the lower face; of the ball they miss the surface, and are told of.
    const double z = seed % 3 == 0 ? -0.25 : seed % 3 == 1 ? -0.25 : -0.25;
    EditReport report;
    const Segmentation after = replayed(before, posed, target,
                                        {of_bone(EditKind::kRemove, removed), of_bone(EditKind::kInhibit, still),
                                         painted(EditKind::kKeepWhole, "floor", rectangle({-0.1, -0.05, z}, {0.2, 0, 0}, {0, 0.1, 0}))}, &report);
    int gone = -1;
    for (std::size_t b = 0; b < posed.character.bones.size(); ++b)
      if (posed.character.bones[b].name == removed) gone = int(b);
    expect_tiling(after, posed, target, {gone});
    for (std::size_t i : target.inside)
      if (after.is_pinned(i)) {
        ASSERT_TRUE(after.may_grow(after.owner[i]));
      }
    EXPECT_EQ(after.owner, edited(before, posed.character, target, posed.embedding,
                                  {of_bone(EditKind::kRemove, removed), of_bone(EditKind::kInhibit, still),
                                   painted(EditKind::kKeepWhole, "floor", rectangle({-0.1, -0.05, z}, {0.2, 0, 0}, {0, 0.1, 0}))}, nullptr, 1).owner);
  }
}

TEST(Edits, RefuseNumbersThatAreNoneAndForeignData) {
  const Row row;
  EXPECT_THROW(replayed(row.grown_, row.posed, row.target, {of_bone(EditKind::kInhibit, "left", NAN)}), InvalidInput);
  EXPECT_THROW(replayed(row.grown_, row.posed, row.target, {of_bone(EditKind::kInhibit, "left", -1)}), InvalidInput);
  EXPECT_THROW(replayed(row.grown_, row.posed, row.target, {painted(EditKind::kKeepWhole, "x", top(NAN, 0.1, 0, 0.1))}), InvalidInput);
  EXPECT_THROW(replayed(row.grown_, row.posed, sphere_target(16), {}), InvalidInput);
  EXPECT_THROW(edited(row.grown_, row.posed.character, row.target, row.posed.embedding, {}, nullptr, -1), InvalidInput);
  Segmentation wrong = row.grown_;
  wrong.pinned.assign(3, 0);
  EXPECT_THROW(retiled(wrong, row.posed.character, row.target, row.posed.embedding), InvalidInput);
  wrong = row.grown_;
  wrong.inhibited.assign(1, 0);
  EXPECT_THROW(retiled(wrong, row.posed.character, row.target, row.posed.embedding), InvalidInput);
}

}  // namespace
}  // namespace transformables
