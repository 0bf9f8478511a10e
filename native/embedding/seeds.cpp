#include "embedding/seeds.h"

#include <algorithm>
#include <cmath>

#include "common/eight.h"
#include "common/capsule.h"

namespace transformables {
namespace {

constexpr double kThinnest = 0.87;      // steps; a thinner capsule could miss every voxel's centre
// Where the nearest point of parent and child is their joint, both are equally near: a little of how far a place
// lies past a bone's end is added, so that the joint's bisector plane decides.
constexpr double kBisector = 0.1;

/// All in steps from the joint.
struct Ball {
  float reach, excess;
  float a[3], direction[3], length;     // of the segment
  std::int32_t bone;
};

/// A row of the ball. @return whether any of it was planted
EIGHT_INLINE bool plant_row(const Ball& ball, float x, float y, float z, int count, const std::int32_t* wall, std::int32_t* field) {
  const Floats ramp{0, 1, 2, 3, 4, 5, 6, 7};
  const float dy = y - ball.a[1], dz = z - ball.a[2], beside = dy * ball.direction[1] + dz * ball.direction[2], square = dy * dy + dz * dz;
  Eight any = {};
  for (int k = 0; k < count; k += 8) {
    EIGHT_LOAD(Eight, walls, wall + k);
    EIGHT_LOAD(Eight, old, field + k);
    const Floats dx = (x + float(k) - ball.a[0]) + ramp, free = dx * ball.direction[0] + beside, none = {}, end = none + ball.length;
    const Floats from = free > none ? free : none, at = from < end ? from : end, past = free - at, far = past > none ? past : -past;
    Floats off = none;  // of the nearest point from the joint, squared
    for (int d = 0; d < 3; ++d) {
      const Floats way = ball.a[d] + at * ball.direction[d];
      off += way * way;
    }
    const Floats left = dx * dx + square - at * (2 * free - at), least = left > none ? left : none;
    EIGHT_SQRT(distance, least);
    const Floats units = float(kUnitsPerStep) * (distance + float(kBisector) * far + ball.excess) + 0.5f;
    const Eight packed = __builtin_convertvector(units, Eight) << kLabelBits | ball.bone;
    const Eight lanes{0, 1, 2, 3, 4, 5, 6, 7};
    const Eight within = (off <= ball.reach * ball.reach) & (walls == 0) & (lanes < count - k) & (packed < old);
    any |= within;
    const Eight now = within ? packed : old;
    std::memcpy(field + k, &now, sizeof now);
  }
  std::int32_t planted = 0;
  for (int k = 0; k < 8; ++k) planted |= any[k];
  return planted != 0;
}

EIGHT_INLINE bool plant_ball(const Voxels& voxels, const Ball& ball, const Eigen::Vector3d& joint, std::int32_t* field) {
  const double reach = double(ball.reach);
  const auto first = [&](int d, double half) { return std::max(0, int(std::ceil(joint[d] - half))); };
  const auto last = [&](int d, double half) { return std::min(voxels.size[d] - 1, int(std::floor(joint[d] + half))); };
  bool any = false;
  for (int z = first(2, reach); z <= last(2, reach); ++z) {
    const double dz = z - joint.z();
    for (int y = first(1, reach); y <= last(1, reach); ++y) {
      const double dy = y - joint.y(), half = std::sqrt(std::max(0.0, reach * reach - dz * dz - dy * dy));
      const int begin = first(0, half), count = last(0, half) + 1 - begin;
      if (count <= 0) continue;
      const std::int32_t cell = voxels.cell(begin, y, z);
      any |= plant_row(ball, float(begin - joint.x()), float(dy), float(dz), count, voxels.wall.data() + cell, field + cell);
    }
  }
  return any;
}

bool plant_ball_plain(const Voxels& voxels, const Ball& ball, const Eigen::Vector3d& joint, std::int32_t* field) { return plant_ball(voxels, ball, joint, field); }

EIGHT_AVX2 bool plant_ball_avx2(const Voxels& voxels, const Ball& ball, const Eigen::Vector3d& joint, std::int32_t* field) {
  return plant_ball(voxels, ball, joint, field);
}

}  // namespace

// Goes along the capsule slice by slice of its steepest axis. Within a slice it covers no more than sqrt 2 radii about the axis.
bool plant_capsule(const Voxels& vox, const Seeded& seeded, std::int32_t* field) {
  const Skeleton::PosedSegment& segment = seeded.segment;
  const Eigen::Vector3d a = (segment.a - vox.origin) / vox.step;
  const double length = segment.length / vox.step, thick = std::max(seeded.radius / vox.step, kThinnest), excess = seeded.excess / vox.step;
  const Eigen::Vector3d along = length * segment.direction;
  int m;
  segment.direction.cwiseAbs().maxCoeff(&m);
  const int u = (m + 1) % 3, v = (m + 2) % 3;
  const double low = std::min(a[m], a[m] + along[m]) - thick, high = std::max(a[m], a[m] + along[m]) + thick;
  const int first = std::max(0, int(std::ceil(low))), last = std::min(vox.size[m] - 1, int(std::floor(high)));
  const double half = 1.4143 * thick;
  const int strides[3] = {1, vox.pitch, vox.slice};
  bool any = false;
  for (int k = first; k <= last; ++k) {
    const double t = std::abs(along[m]) > 1e-9 ? std::clamp((k - a[m]) / along[m], 0.0, 1.0) : 0.0;
    const double cu = a[u] + t * along[u], cv = a[v] + t * along[v];
    const int u0 = std::max(0, int(std::ceil(cu - half))), u1 = std::min(vox.size[u] - 1, int(std::floor(cu + half)));
    const int v0 = std::max(0, int(std::ceil(cv - half))), v1 = std::min(vox.size[v] - 1, int(std::floor(cv + half)));
    for (int j = v0; j <= v1; ++j) {
      std::int32_t cell = vox.cell(0, 0, 0) + k * strides[m] + j * strides[v] + u0 * strides[u];
      for (int i = u0; i <= u1; ++i, cell += strides[u]) {
        const double dm = k - a[m], du = i - a[u], dv = j - a[v];
        const double free = dm * segment.direction[m] + du * segment.direction[u] + dv * segment.direction[v];
        const double at = std::clamp(free, 0.0, length);
        const double square = dm * dm + du * du + dv * dv - at * (2 * free - at);
        if (square > thick * thick || vox.wall[std::size_t(cell)] != 0) continue;
        const double value = std::sqrt(std::max(0.0, square)) + kBisector * std::abs(free - at) + excess;
        const std::int32_t packed = (std::int32_t(kUnitsPerStep * value + 0.5) << kLabelBits) | seeded.bone;
        field[cell] = std::min(field[cell], packed);
        any = true;
      }
    }
  }
  return any;
}

bool plant_about_joint(const Voxels& voxels, const Seeded& seeded, const Eigen::Vector3d& joint, double reach, std::int32_t* field) {
  const Skeleton::PosedSegment& segment = seeded.segment;
  if (distance(Segment{segment.a, segment.a + segment.length * segment.direction}, joint) > reach) return false;
  Ball ball{float(reach / voxels.step), float(seeded.excess / voxels.step), {}, {}, float(segment.length / voxels.step), seeded.bone};
  for (int d = 0; d < 3; ++d) {
    ball.a[d] = float((segment.a[d] - joint[d]) / voxels.step);
    ball.direction[d] = float(segment.direction[d]);
  }
  return (has_avx2() ? plant_ball_avx2 : plant_ball_plain)(voxels, ball, (joint - voxels.origin) / voxels.step, field);
}

}  // namespace transformables
