#include "finishing/along_path.h"

#include <tbb/parallel_for.h>

namespace transformables::finishing {

std::vector<std::pair<int, int>> near_pairs(const MoveMotion& motion, const std::vector<PartField>& parts, double reach) {
  const int count = int(parts.size());
  std::vector<char> near(std::size_t(count) * count, 0);
  tbb::parallel_for(0, count * count, [&](int n) {
    const int i = n / count, j = n % count;
    // The smaller one's ball is the tighter one.
    if (i < j)
      near[n] = parts[i].shape().count() < parts[j].shape().count()
                    ? PairConfigurations::can_meet(motion, parts[i], parts[j], reach)
                    : PairConfigurations::can_meet(motion, parts[j], parts[i], reach);
  });
  std::vector<std::pair<int, int>> pairs;
  for (int n = 0; n < count * count; ++n)
    if (near[n]) pairs.emplace_back(n / count, n % count);
  return pairs;
}

std::vector<Bricks> all_bricks(const std::vector<PartField>& parts, double reach) {
  std::vector<Bricks> bricks(parts.size());
  tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t n) { bricks[n] = bricks_of(parts[n], reach); });
  return bricks;
}

}  // namespace transformables::finishing
