#include "embedding/difference.h"

#include <algorithm>

namespace transformables {

PartitionDifference::PartitionDifference(const Character& character, const Target& target, const Voxels& voxels) {
  if (!character.mirrored || !target.mirror_axis) return;
  for (const Bone& bone : character.bones) mirror_bone_.push_back(std::int16_t(bone.mirror));
  std::vector<std::int32_t> place(std::size_t(voxels.cells), -1);
  std::int32_t count = 0;
  for (const Voxels::Run& run : voxels.runs)
    for (std::int32_t c = run.begin; c < run.end; ++c) place[std::size_t(c)] = count++;
  mirror_voxel_.reserve(std::size_t(count));
  for (const Voxels::Row& row : voxels.rows) {
    const std::int32_t start = voxels.cell(0, row.y, row.z);
    for (int r = row.first_run; r < row.end_run; ++r)
      for (std::int32_t c = voxels.runs[std::size_t(r)].begin; c < voxels.runs[std::size_t(r)].end; ++c) {
        Eigen::Vector3d p = voxels.position(c - start, row.y, row.z);
        p[*target.mirror_axis] *= -1;
        const Eigen::Vector3i v = ((p - voxels.origin) / voxels.step).array().round().matrix().cast<int>();
        const bool in_box = (v.array() >= 0).all() && (v.array() < voxels.size.array()).all();
        mirror_voxel_.push_back(in_box ? place[std::size_t(voxels.cell(v.x(), v.y(), v.z()))] : -1);
      }
  }
}

double PartitionDifference::operator()(const Partition& a, const Partition& b) const {
  if (a.empty()) return 0;
  std::size_t direct = 0, mirrored = 0, compared = 0;
  for (std::size_t i = 0; i < a.size(); ++i) direct += a[i] != b[i];
  const double straight = double(direct) / double(a.size());
  for (std::size_t i = 0; i < mirror_voxel_.size(); ++i) {
    if (mirror_voxel_[i] < 0) continue;
    ++compared;
    mirrored += mirror_bone_[std::size_t(a[i])] != b[std::size_t(mirror_voxel_[i])];
  }
  return compared == 0 ? straight : std::min(straight, double(mirrored) / double(compared));
}

}  // namespace transformables
