// Production's part fields as the letter has parts: dense, over the whole lattice.
#pragma once

#include <algorithm>
#include <vector>

#include "finishing/part_field.h"
#include "reference/carving.h"

namespace transformables::reference {

inline Solids dense(const std::vector<finishing::PartField>& fields, const GridShape& shape) {
  Solids solids{{}, {}, Grid<float>(shape, 1)};
  for (const auto& field : fields) {
    Grid<float> part(shape, 1), core(shape, 1);
    for (std::size_t n = 0; n < field.psi.values.size(); ++n) {
      const Eigen::Vector3i c = field.corner + field.shape().cell(n);
      part.at(c) = field.bound(n), core.at(c) = std::max(field.core[n], field.away[n].outer);
    }
    solids.parts.push_back(std::move(part)), solids.cores.push_back(std::move(core));
  }
  return solids;
}

}  // namespace transformables::reference
