#include <gtest/gtest.h>

#include "segmentation/edits.h"
#include "segmentation/seams.h"
#include "segmentation/cases.h"

namespace transformables {
namespace {

using namespace cases;

Target egg_target(int resolution) {
  const Vector3d half(0.25, 0.18, 0.2);
  // To first order a distance near the surface, which is where it counts.
  return target_of([=](const Vector3d& p) {
    const double k = p.cwiseQuotient(half).norm();
    return k < 1e-6 ? -0.18 : k * (k - 1) / p.cwiseQuotient(half.cwiseAbs2()).norm();
  }, half, resolution);
}

double length_of(const Seam& seam) {
  double sum = seam.closed ? (seam.points.front() - seam.points.back()).norm() : 0;
  for (std::size_t k = 1; k < seam.points.size(); ++k) sum += (seam.points[k] - seam.points[k - 1]).norm();
  return sum;
}

// Distance from a point to the curve.
double away(const Vector3d& p, const std::vector<Seam>& seams) {
  double least = 1e9;
  for (const Seam& seam : seams)
    for (std::size_t k = seam.closed ? 0 : 1; k < seam.points.size(); ++k)
      least = std::min(least, distance(Segment{seam.points[k > 0 ? k - 1 : seam.points.size() - 1], seam.points[k]}, p));
  return least;
}

TEST(Seams, RunOnceRoundABarThatIsCutInHalves) {
  const Target target = box_target({0.25, 0.1, 0.08}, 48);
  const Posed posed = half_boxes(target, 0);
  const auto seams = traced_seams(cut_in_halves(posed, target), target);
  ASSERT_EQ(seams.size(), 1u);
  EXPECT_TRUE(seams[0].closed);
  EXPECT_EQ(seams[0].bone_a, 0);
  EXPECT_EQ(seams[0].bone_b, 1);
  const double h = target.distance.shape.step;
  EXPECT_NEAR(length_of(seams[0]), 4 * 0.1 + 4 * 0.08, 4 * h) << "corners of a trilinear distance are a little round";
  for (const Vector3d& p : seams[0].points) {
    ASSERT_LT(std::abs(p.x()), 0.1 * h);
    ASSERT_LT(std::abs(distance_at(target, p)), 0.1 * h);
  }
}

TEST(Seams, LieOnTheSurfaceAndOnTheInterfaceForRandomPoses) {
  const auto targets = some_targets();
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const Target& target = targets[seed % 3];
    const Posed posed = random_pose(target, seed);
    const Segmentation s = grown(posed, target);
    const double h = target.distance.shape.step;
    const auto seams = traced_seams(s, target);
    ASSERT_FALSE(seams.empty());
    for (const Seam& seam : seams) {
      ASSERT_LT(seam.bone_a, seam.bone_b);
      for (std::size_t k = 0; k < seam.points.size(); ++k) {
        ASSERT_LT(std::abs(distance_at(target, seam.points[k])), 0.1 * h);
        if (k > 0) {
          ASSERT_LT((seam.points[k] - seam.points[k - 1]).norm(), 2 * h);
        }
      }
    }
    // Nearly every place of the surface layer between two parts has a seam of these two near.
    std::size_t places = 0, missed = 0;
    for (std::size_t i : target.inside) {
      if (target.distance[i] < -0.6 * h) continue;
      const Vector3i c = s.shape.cell(i);
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t n = s.shape.index(c + Vector3i::Unit(axis));
        if (s.owner[n] < 0 || s.owner[n] == s.owner[i] || target.distance[n] < -0.6 * h) continue;
        ++places;
        missed += away(0.5 * (s.shape.position(i) + s.shape.position(n)), seams) > 3 * h;
      }
    }
    EXPECT_LT(double(missed), 0.05 * double(places)) << places;
  }
}

TEST(Seams, RefuseForeignDataAndASpacingOutOfRange) {
  const Target target = box_target({0.25, 0.1, 0.08}, 32);
  const Segmentation s = cut_in_halves(half_boxes(target, 0), target);
  EXPECT_THROW(traced_seams(s, target, 0.1), InvalidInput);
  EXPECT_THROW(traced_seams(s, target, NAN), InvalidInput);
  EXPECT_THROW(traced_seams(s, sphere_target(16)), InvalidInput);
}

// The seam of two halves moved along x by up to `by`, most at angle 0 about the x axis, and less with the distance from there.
struct Moved {
  Edit edit;
  std::vector<Vector3d> places;   // where moved points are to be
};

Vector3d onto(const Target& target, Vector3d p) {
  const double h = target.distance.shape.step;
  for (int k = 0; k < 20; ++k) {
    Vector3d g;
    for (int a = 0; a < 3; ++a) g[a] = (distance_at(target, p + 0.5 * h * Vector3d::Unit(a)) - distance_at(target, p - 0.5 * h * Vector3d::Unit(a))) / h;
    p -= g * distance_at(target, p) / std::max(g.squaredNorm(), 0.1);
  }
  return p;
}

Moved dragged(const Target& target, const Seam& seam, double by, double width) {
  Moved moved;
  moved.edit.kind = EditKind::kMoveSeam, moved.edit.bone = "left", moved.edit.other = "right";
  const Vector3d top = *std::max_element(seam.points.begin(), seam.points.end(), [](const auto& a, const auto& b) { return a.z() < b.z(); });
  for (const Vector3d& p : seam.points) {
    const double t = std::max(0.0, 1 - (p - top).norm() / width);
    const Vector3d to = onto(target, p + Vector3d(by * t * t * (3 - 2 * t), 0, 0));
    moved.edit.from.push_back(p);
    moved.edit.to.push_back(to);
    moved.places.push_back(to);
  }
  return moved;
}

Segmentation replayed(const Segmentation& s, const Posed& posed, const Target& target, const std::vector<Edit>& edits, EditReport* report = nullptr) {
  return edited(s, posed.character, target, posed.embedding, edits, report);
}

TEST(SeamEdits, PutTheSeamWithinHalfAVoxelOfWhereItWasDragged) {
  for (const Target& target : {box_target({0.25, 0.1, 0.1}, 64), egg_target(64)}) {
    const double h = target.distance.shape.step;
    const Posed posed = half_boxes(target, 0);
    const Segmentation before = cut_in_halves(posed, target);
    const auto seams = traced_seams(before, target);
    ASSERT_EQ(seams.size(), 1u);
    for (double voxels : {5.0, -5.0, 1.0}) {
      for (double width : {0.15, 2.0}) {
        SCOPED_TRACE(testing::Message() << voxels << " voxels, width " << width);
        const Moved moved = dragged(target, seams[0], voxels * h, width);
        EditReport report;
        const Segmentation after = replayed(before, posed, target, {moved.edit}, &report);
        ASSERT_TRUE(report.empty()) << report[0];
        expect_tiling(after, posed, target);
        const auto now = traced_seams(after, target, 0.5);
        ASSERT_FALSE(now.empty());
        double worst = 0;
        for (const Vector3d& p : moved.places) worst = std::max(worst, away(p, now));
        EXPECT_LT(worst, 0.5 * h) << worst / h << " voxels";
      }
    }
  }
}

TEST(SeamEdits, LeaveWhatIsFarFromTheSeamAsItWas) {
  const Target target = box_target({0.25, 0.1, 0.1}, 48);
  const double h = target.distance.shape.step;
  const Posed posed = half_boxes(target, 0);
  const Segmentation before = cut_in_halves(posed, target);
  const Moved moved = dragged(target, traced_seams(before, target).at(0), 4 * h, 0.15);
  const Segmentation after = replayed(before, posed, target, {moved.edit});
  std::size_t changed = 0;
  for (std::size_t i : target.inside) {
    changed += after.owner[i] != before.owner[i];
    if (std::abs(before.shape.position(i).x()) > 14 * h) {
      ASSERT_EQ(after.owner[i], before.owner[i]);
    }
  }
  EXPECT_GT(changed, 50u);
}

TEST(SeamEdits, HoldThroughTransfer) {
  const Target target = box_target({0.25, 0.1, 0.1}, 48);
  const double h = target.distance.shape.step;
  const Posed posed = half_boxes(target, 0);
  const Segmentation before = cut_in_halves(posed, target);
  const Moved moved = dragged(target, traced_seams(before, target).at(0), 5 * h, 0.15);
  const Segmentation after = transfer(replayed(before, posed, target, {moved.edit}), posed.character, target, posed.embedding, {{1, 0, 0, 1.5}}, {}, {});
  expect_tiling(after, posed, target);
  const auto now = traced_seams(after, target, 0.5);
  for (std::size_t k = 0; k < moved.places.size(); ++k)
    if ((moved.edit.to[k] - moved.edit.from[k]).norm() > 2 * h) {
      ASSERT_LT(away(moved.places[k], now), 1.5 * h);
    }
}

TEST(SeamEdits, ThatMakeNoSenseAnyMoreAreLeftOutAndTold) {
  const Target target = box_target({0.25, 0.1, 0.1}, 32);
  const double h = target.distance.shape.step;
  const Posed posed = half_boxes(target, 0);
  const Segmentation before = cut_in_halves(posed, target);
  const Moved moved = dragged(target, traced_seams(before, target).at(0), 4 * h, 0.15);
  const auto told = [&](Edit edit, const std::string& words) {
    EditReport report;
    const Segmentation after = replayed(before, posed, target, {edit}, &report);
    ASSERT_EQ(report.size(), 1u) << words;
    EXPECT_NE(report[0].find(words), std::string::npos) << report[0];
    EXPECT_EQ(after.owner, before.owner);
  };
  Edit edit = moved.edit;
  edit.other = "tail";
  told(edit, "no bone 'tail'");
  edit = moved.edit;
  for (auto* points : {&edit.from, &edit.to})
    for (Vector3d& p : *points) p.x() += 8 * h;
  told(edit, "not there any more");
  edit = moved.edit;
  for (Vector3d& p : edit.to) p.z() += 0.2;
  told(edit, "not on the target");
  edit = moved.edit;
  edit.to = edit.from;
  told(edit, "nothing of it is moved");
  edit = moved.edit;
  edit.to.pop_back();
  EXPECT_THROW(replayed(before, posed, target, {edit}), InvalidInput);
  edit = moved.edit;
  edit.to[0].x() = NAN;
  EXPECT_THROW(replayed(before, posed, target, {edit}), InvalidInput);
}

}  // namespace
}  // namespace transformables
