// The term for unfolding.
#include <algorithm>
#include <cmath>
#include <utility>

#include "reference/objective.h"

namespace transformables::reference {

using Eigen::Vector3i;

// Not in the paper: what share of the voxels is in the way of the joints when they all open at once, or those nearer the root ahead.
double Objective::unfold(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded) const {
  return std::min(in_the_way(pose, morphology, flooded, false), in_the_way(pose, morphology, flooded, true));
}

std::vector<std::size_t> Objective::unfolded() const {
  if (options_.unfolded == 0) return voxels_;
  std::vector<std::size_t> chosen;
  const Vector3i size = high_ - low_ + Vector3i::Ones();
  for (long k = 1; int(chosen.size()) < options_.unfolded; ++k) {
    Vector3i c;
    for (int d = 0; d < 3; ++d) {
      const double place = double(k) * std::pow(1.2207440846057596, -1 - d);  // the root of x^4 = x + 1
      c[d] = low_[d] + int((place - std::floor(place)) * size[d]);
    }
    if (inside_[shape_.index(c)]) chosen.push_back(shape_.index(c));
  }
  return chosen;
}

// A voxel goes along with the bone it belongs to, and is in the way once it is where another bone's voxel has gone, that bone having more.
double Objective::in_the_way(const Pose& pose, const Morphology& morphology, const std::vector<Flooded>& flooded, bool staggered) const {
  const auto folded = forward_kinematics(character_, pose, morphology);
  const int n = int(folded.size()), steps = staggered ? 6 : 5;
  std::vector<int> depth;
  for (const Bone& bone : character_.bones) depth.push_back(bone.parent < 0 ? 0 : depth[std::size_t(bone.parent)] + 1);
  const int deepest = *std::max_element(depth.begin(), depth.end());
  const std::vector<std::size_t> moved = unfolded();
  std::vector<int> has(std::size_t(n), 0);
  for (const std::size_t v : moved)
    if (flooded[v].bone >= 0) ++has[std::size_t(flooded[v].bone)];
  std::vector<char> hit(moved.size(), 0);
  for (int k = 1; k <= steps; ++k) {
    Pose now = pose;
    for (int b = 0; b < n; ++b)
      for (std::size_t h = 0; h < character_.bones[std::size_t(b)].hinges.size(); ++h) {
        const double done = double(k) / steps;
        const double opened = staggered ? std::clamp(2 * done - double(depth[std::size_t(b)] - 1) / deepest, 0.0, 1.0) : done;
        now.angles[character_.bones[std::size_t(b)].first_angle + Eigen::Index(h)] *= 1 - opened;
      }
    const auto frames = forward_kinematics(character_, now, morphology);
    for (std::size_t i = 0; i < moved.size(); ++i)
      for (int a = flooded[moved[i]].bone, b = 0; a >= 0 && b < n; ++b) {
        const auto mine = std::pair(has[std::size_t(a)], -a), other = std::pair(has[std::size_t(b)], -b);
        if (a == b || hit[i] || mine > other) continue;
        const Eigen::Isometry3d into = folded[std::size_t(b)] * frames[std::size_t(b)].inverse() * frames[std::size_t(a)] * folded[std::size_t(a)].inverse();
        const Vector3i cell = shape_.nearest(into * shape_.position(moved[i]));
        hit[i] = shape_.contains(cell) && flooded[shape_.index(cell)].bone == b;
      }
  }
  return double(std::count(hit.begin(), hit.end(), 1)) / double(moved.size());
}

}  // namespace transformables::reference
