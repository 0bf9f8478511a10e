#include "target/target.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "target/mend.h"
#include "target/soup.h"
#include "target/solid.h"
#include "target/voxels.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

constexpr int kLeastResolution = 16, kLargestResolution = 512;
constexpr int kPadding = 4;                   // samples around the box
constexpr double kLeastDepth = 0.75;          // voxels, at the deepest place: less is a sheet or a hollow skin
constexpr double kLargestLostShare = 0.01;    // of the volume, in pieces that do not hang together, before we say so

void add_soup_warnings(const SoupReport& report, std::vector<std::string>& warnings) {
  const auto dropped = [&](std::size_t n, const char* why) {
    if (n) warnings.push_back("Left out " + count_of(n, "face ", "faces ") + why + ".");
  };
  dropped(report.non_finite, "with a corner that is not a number");
  dropped(report.degenerate, "without area");
  dropped(report.duplicates, "that repeated another");
}

/// Moves the mesh into the target frame.
void normalise(TriangleMesh& mesh, Target& target) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  const double longest = box.sizes().maxCoeff();
  if (!std::isfinite(longest) || !(longest > 0) || !std::isfinite(kLongestSide / longest))
    throw InvalidInput("The target mesh has no usable size: scale it to between 1e-30 and 1e30 units.");
  target.centre = box.min() / 2 + box.max() / 2;
  target.scale = kLongestSide / longest;
  for (Vector3d& v : mesh.vertices) v = (v - target.centre) * target.scale;
}

/// Samples in the middle of voxels, symmetric about the origin, so that a mirrored sample is a sample too.
GridShape grid_around(const TriangleMesh& mesh, double voxel) {
  GridShape shape;
  shape.step = voxel;
  for (int k = 0; k < 3; ++k) {
    double reach = 0;
    for (const Vector3d& v : mesh.vertices) reach = std::max(reach, std::abs(v[k]));
    // A wrap stands out by a tenth of a voxel; that is no reason for one more sample on each side.
    shape.size[k] = std::max(1, int(std::ceil(2 * reach / voxel - 0.25))) + 2 * kPadding;
    shape.origin[k] = -(shape.size[k] - 1) * voxel / 2;
  }
  return shape;
}

void find_inside(Target& target) {
  InsidePiece piece = largest_inside_piece(target.distance);
  const float deepest = *std::min_element(target.distance.values.begin(), target.distance.values.end());
  if (piece.samples.empty() || -deepest < kLeastDepth * target.distance.shape.step)
    throw InvalidInput("The target mesh has no volume at this resolution: it is thinner than about two voxels everywhere. "
                       "Give it thickness, close its holes, or raise the resolution.");
  if (piece.share < 1 - kLargestLostShare)
    target.warnings.push_back("The target is in several pieces at this resolution: only the largest, " +
                              std::to_string(int(std::lround(100 * piece.share))) + " % of the volume, is filled.");
  target.inside = std::move(piece.samples);
}

}  // namespace

Target make_target(const std::vector<Vector3d>& vertices, const std::vector<Eigen::Vector3i>& triangles,
                   const TargetOptions& options, const Progress& progress) {
  if (options.resolution < kLeastResolution || options.resolution > kLargestResolution)
    throw InvalidInput("The resolution is " + std::to_string(options.resolution) + ": choose one from " +
                       std::to_string(kLeastResolution) + " to " + std::to_string(kLargestResolution) + ".");
  progress(0, "checking the target");
  Target target;
  SoupReport report;
  TriangleMesh soup = clean_soup(vertices, triangles, report);
  add_soup_warnings(report, target.warnings);
  normalise(soup, target);

  const double voxel = kLongestSide / options.resolution;
  const Progress solid_progress{[&](double fraction, std::string_view note) {
    return !progress.tell || progress.tell(0.1 + 0.6 * fraction, note);
  }};
  Solid solid = make_solid(soup, voxel, solid_progress, target.warnings);
  target.mesh = std::move(solid.mesh);
  target.exact_surface = solid.exact_surface;
  target.volume = signed_volume(target.mesh);

  progress(0.7, "measuring distances");
  target.distance = signed_distance(target.mesh, grid_around(target.mesh, voxel));
  progress(0.9, "finding the inside");
  find_inside(target);
  target.mirror_axis = find_mirror_axis(target.distance.shape, target.inside);
  progress(1, "target ready");
  return target;
}

double distance_at(const Target& target, const Vector3d& p) {
  const GridShape& s = target.distance.shape;
  const Vector3d far_corner = s.position(Eigen::Vector3i(s.size.array() - 1));
  const Vector3d on_border = p.cwiseMax(s.origin).cwiseMin(far_corner);
  return double(sample(target.distance, on_border)) + (p - on_border).norm();
}

}  // namespace transformables
