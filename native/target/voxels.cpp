#include "target/voxels.h"

namespace transformables {
namespace {

constexpr double kLeastMirrorAgreement = 0.93;  // intersection over union; a mesh's own faceting costs a few per cent
constexpr double kTie = 0.002;                  // a round body's axes differ by that much through faceting alone

}  // namespace

InsidePiece largest_inside_piece(const Grid<float>& distance) {
  const GridShape& shape = distance.shape;
  std::vector<int> piece(distance.values.size(), -1);
  std::vector<std::size_t> sizes, queue;
  std::size_t total = 0;
  for (std::size_t start = 0; start < piece.size(); ++start) {
    if (distance[start] >= 0 || piece[start] >= 0) continue;
    const int label = int(sizes.size());
    queue.assign(1, start);
    piece[start] = label;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const Eigen::Vector3i c = shape.cell(queue[head]);
      for (int axis = 0; axis < 3; ++axis)
        for (const int d : {-1, 1}) {
          Eigen::Vector3i n = c;
          n[axis] += d;
          if (!shape.contains(n)) continue;
          const std::size_t i = shape.index(n);
          if (distance[i] >= 0 || piece[i] >= 0) continue;
          piece[i] = label;
          queue.push_back(i);
        }
    }
    sizes.push_back(queue.size());
    total += queue.size();
  }
  InsidePiece out;
  int best = -1;
  for (std::size_t p = 0; p < sizes.size(); ++p)
    if (best < 0 || sizes[p] > sizes[std::size_t(best)]) best = int(p);
  if (best < 0) return out;
  for (std::size_t i = 0; i < piece.size(); ++i)
    if (piece[i] == best) out.samples.push_back(i);
  out.share = double(out.samples.size()) / double(total);
  return out;
}

std::optional<int> find_mirror_axis(const GridShape& shape, const std::vector<std::size_t>& inside) {
  std::vector<char> mask(shape.count(), 0);
  for (const std::size_t i : inside) mask[i] = 1;
  std::optional<int> best;
  double best_agreement = kLeastMirrorAgreement - kTie;
  for (int axis = 0; axis < 3; ++axis) {
    std::size_t both = 0;
    for (const std::size_t i : inside) {
      Eigen::Vector3i c = shape.cell(i);
      c[axis] = shape.size[axis] - 1 - c[axis];
      both += std::size_t(mask[shape.index(c)]);
    }
    const double agreement = double(both) / double(2 * inside.size() - both);
    if (agreement < kLeastMirrorAgreement || agreement <= best_agreement + kTie) continue;
    best = axis;
    best_agreement = agreement;
  }
  return best;
}

}  // namespace transformables
