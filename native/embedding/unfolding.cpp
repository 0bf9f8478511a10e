#include "embedding/unfolding.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace transformables {
namespace {

constexpr double kFarthest = 1.5;     // times the samples' mean distance: no voxel is farther from one, or hardly any
constexpr long kTriesASample = 1000;  // a target that fills less of its box than that has fewer samples

}  // namespace

Unfolding::Unfolding(const Character& character, std::shared_ptr<const Voxels> voxels) : character_(character), voxels_(std::move(voxels)) {
  const Voxels& vox = *voxels_;
  for (long k = 1; int(samples_.size()) < kSamples && k < kTriesASample * kSamples; ++k) {
    Eigen::Vector3i c;
    for (int d = 0; d < 3; ++d) c[d] = int((kSpread[d] * double(k) - std::floor(kSpread[d] * double(k))) * vox.size[d]);
    if (vox.wall[std::size_t(vox.cell(c.x(), c.y(), c.z()))] == 0) samples_.push_back(c);
  }
  double inside = 0;
  for (const Voxels::Run& run : vox.runs) inside += run.end - run.begin;
  spacing_ = float(kFarthest * std::cbrt(inside / double(std::max<std::size_t>(1, samples_.size()))));
  const std::size_t n = character.bones.size();
  for (std::size_t b = 0; b < n; ++b) {
    const int parent = character.bones[b].parent;
    depth_.push_back(parent < 0 ? 0 : depth_[std::size_t(parent)] + 1);
    deepest_ = std::max(deepest_, depth_.back());
  }
  sorted_.resize(samples_.size());
  first_.resize(n), end_.resize(n), left_.resize(n);
  centre_.resize(n), centre_now_.resize(n), radius_.resize(n), motion_.resize(n);
}

double Unfolding::opened(bool staggered, int depth, int deepest, double done) {
  return staggered ? std::clamp(2 * done - double(depth - 1) / deepest, 0.0, 1.0) : done;
}

double Unfolding::operator()(const Skeleton& folded, const Pose& pose, const std::vector<std::int32_t>& field) {
  sort_samples(field);
  const int together = in_the_way(folded, pose, field, false, int(samples_.size()));
  return double(in_the_way(folded, pose, field, true, together)) / double(std::max<std::size_t>(1, samples_.size()));
}

/// Those that the flood has not reached are left out: nobody moves them.
void Unfolding::sort_samples(const std::vector<std::int32_t>& field) {
  const Voxels& vox = *voxels_;
  const auto bone_at = [&](const Eigen::Vector3i& c) { return std::size_t(field[std::size_t(vox.cell(c.x(), c.y(), c.z()))] & kNoLabel); };
  const std::size_t n = first_.size();
  std::fill(end_.begin(), end_.end(), 0);
  for (const Eigen::Vector3i& c : samples_)
    if (const std::size_t bone = bone_at(c); bone < n) ++end_[bone];
  for (std::size_t b = 0, start = 0; b < n; ++b) {
    first_[b] = int(start);
    start += std::size_t(end_[b]);
    end_[b] = first_[b];
  }
  for (const Eigen::Vector3i& c : samples_)
    if (const std::size_t bone = bone_at(c); bone < n) sorted_[std::size_t(end_[bone]++)] = c.cast<float>();
  for (std::size_t b = 0; b < n; ++b) {
    centre_[b].setZero();
    for (int i = first_[b]; i < end_[b]; ++i) centre_[b] += sorted_[std::size_t(i)];
    centre_[b] /= float(std::max(1, end_[b] - first_[b]));
    float square = 0;
    for (int i = first_[b]; i < end_[b]; ++i) square = std::max(square, (sorted_[std::size_t(i)] - centre_[b]).squaredNorm());
    radius_[b] = std::sqrt(square) + spacing_;
  }
}

/// Each bone's motion from the folded pose. A hinge turns about the axis that it has in that pose, after those that its bone turns by before it.
void Unfolding::place(const Skeleton& folded, const Pose& pose, bool staggered, double done) {
  for (std::size_t b = 0; b < motion_.size(); ++b) {
    const Bone& bone = character_.bones[b];
    Motion& motion = motion_[b];
    motion = bone.parent < 0 ? Motion{} : motion_[std::size_t(bone.parent)];
    if (!bone.hinges.empty()) {
      Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
      for (std::size_t k = 0; k < bone.hinges.size(); ++k) {
        const auto angle = std::size_t(bone.first_angle) + k;
        const double by = -opened(staggered, depth_[b], deepest_, done) * pose.angles[Eigen::Index(angle)];
        turn = Eigen::AngleAxisf(float(by), folded.hinge_axes[angle].cast<float>()).toRotationMatrix() * turn;
      }
      const Eigen::Vector3f head = ((folded.heads[b] - voxels_->origin) / voxels_->step).cast<float>();
      motion.move += motion.turn * (head - turn * head);
      motion.turn *= turn;
    }
    centre_now_[b] = motion.turn * centre_[b] + motion.move;
  }
}

/// How many samples are in the way on the whole; `most` when they are as many or more.
int Unfolding::in_the_way(const Skeleton& folded, const Pose& pose, const std::vector<std::int32_t>& field, bool staggered, int most) {
  left_ = end_;
  const int n = int(motion_.size()), steps = staggered ? kStaggered : kTogether;
  int count = 0;
  for (int k = 1; k <= steps; ++k) {
    place(folded, pose, staggered, double(k) / steps);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < a; ++b) {
        const float reach = radius_[std::size_t(a)] + radius_[std::size_t(b)];
        if ((centre_now_[std::size_t(a)] - centre_now_[std::size_t(b)]).squaredNorm() > reach * reach) continue;
        const bool smaller = end_[std::size_t(a)] - first_[std::size_t(a)] <= end_[std::size_t(b)] - first_[std::size_t(b)];
        count += smaller ? hit(a, b, field) : hit(b, a, field);
      }
    if (count >= most) return most;
  }
  return count;
}

/// Takes those samples of bone a out that are within bone b's now; how many.
int Unfolding::hit(int a, int b, const std::vector<std::int32_t>& field) {
  const Voxels& vox = *voxels_;
  const Motion &from = motion_[std::size_t(a)], &to = motion_[std::size_t(b)];
  const Eigen::Matrix3f turn = to.turn.transpose() * from.turn;
  const Eigen::Vector3f move = to.turn.transpose() * (from.move - to.move) + Eigen::Vector3f::Constant(1.5f);
  int count = 0;
  int& end = left_[std::size_t(a)];
  for (int i = first_[std::size_t(a)]; i < end;) {
    const Eigen::Vector3f q = turn * sorted_[std::size_t(i)] + move;
    const int x = int(q.x()) - 1, y = int(q.y()) - 1, z = int(q.z()) - 1;  // the nearest voxel; what is before the first ends there or farther
    const bool within = unsigned(x) < unsigned(vox.size.x()) && unsigned(y) < unsigned(vox.size.y()) && unsigned(z) < unsigned(vox.size.z()) &&
                        (field[std::size_t(vox.cell(x, y, z))] & kNoLabel) == b;
    if (!within) {
      ++i;
      continue;
    }
    std::swap(sorted_[std::size_t(i)], sorted_[std::size_t(--end)]);
    ++count;
  }
  return count;
}

}  // namespace transformables
