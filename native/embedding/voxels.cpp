#include "embedding/voxels.h"

#include <cmath>

#include "common/error.h"

namespace transformables {
namespace {

constexpr double kPaperStep = 0.01;

}  // namespace

int Voxels::stride_of(const Target& target, int most) {
  return std::max(1, int(std::ceil(kLongestSide / target.distance.shape.step / most - 0.01)));
}

Voxels::Voxels(const Target& target, int most, std::size_t few) {
  const GridShape& shape = target.distance.shape;
  stride = stride_of(target, most);
  std::vector<Eigen::Vector3i> taken;
  for (const std::size_t i : target.inside) {
    const Eigen::Vector3i c = shape.cell(i);
    if (c.x() % stride == 0 && c.y() % stride == 0 && c.z() % stride == 0) taken.push_back(c / stride);
  }
  step = shape.step * stride;
  origin = shape.origin;
  lay_out(taken, few);
}

Voxels::Voxels(const Target& target, double own_step, const Eigen::Vector3d& shift, std::size_t few) {
  const GridShape& shape = target.distance.shape;
  step = own_step;
  origin = shape.origin + step * shift;
  const Eigen::Vector3i last = ((shape.position(shape.size - Eigen::Vector3i::Ones()) - origin) / step).array().floor().matrix().cast<int>();
  std::vector<Eigen::Vector3i> taken;
  for (int z = 0; z <= last.z(); ++z)
    for (int y = 0; y <= last.y(); ++y)
      for (int x = 0; x <= last.x(); ++x)
        if (sample(target.distance, position(x, y, z)) < 0) taken.push_back({x, y, z});
  lay_out(taken, few);
}

/// The box of the voxels that were taken, its rows and runs. Until then `origin` is where voxel (0, 0, 0) of the whole grid is.
void Voxels::lay_out(const std::vector<Eigen::Vector3i>& taken, std::size_t few) {
  if (taken.empty()) throw InvalidInput("the target has no voxels inside at this resolution: raise the resolution");
  inside = taken.size();
  Eigen::Vector3i low = taken.front(), high = taken.front();
  for (const auto& c : taken) {
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  }
  size = high - low + Eigen::Vector3i::Ones();
  first_sample = low * stride;
  origin += step * low.cast<double>();
  pitch = (size.x() + 7) / 8 * 8 + kPad;
  slice = pitch * (size.y() + 2);
  cells = slice * (size.z() + 2) + 2 * kPad;
  wall.assign(std::size_t(cells), kUnreached);
  for (const auto& c : taken) wall[std::size_t(cell(c.x() - low.x(), c.y() - low.y(), c.z() - low.z()))] = 0;

  // One voxel in five, a knight's move apart: every plane of voxels has its fifth. One in three does the same.
  spacing = inside < few ? 1 : inside / 2 < few ? 3 : 5;
  samples_weight = spacing * (step / kPaperStep) * (step / kPaperStep);
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y) {
      Row row;
      row.y = y;
      row.z = z;
      row.first_run = std::int32_t(runs.size());
      for (std::int32_t c = cell(0, y, z), end = c + size.x(); c < end; ++c) {
        if (wall[std::size_t(c)] != 0) continue;
        const std::int32_t begin = c;
        while (wall[std::size_t(c)] == 0) ++c;  // the padding ends it
        runs.push_back({begin, c});
      }
      row.end_run = std::int32_t(runs.size());
      if (row.first_run == row.end_run) continue;
      const std::int32_t start = cell(0, y, z), first = runs[std::size_t(row.first_run)].begin;
      row.begin = start + (first - start) / 8 * 8;
      row.count = (runs.back().end - row.begin + 7) / 8 * 8;
      row.phase = (spacing + (start + first_sampled(y, z) - row.begin) % spacing) % spacing;
      rows.push_back(row);
    }
}

}  // namespace transformables
