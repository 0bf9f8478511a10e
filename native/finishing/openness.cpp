#include "finishing/openness.h"

namespace transformables::finishing {
namespace {

constexpr double kPasses = 0.87;   ///< steps: samples further from the solid are passed through; beside nearer ones its surface may lie (half a cell's diagonal)

}  // namespace

std::vector<Eigen::Vector3d> shut_hollows(const Grid<float>& distance) {
  const GridShape& shape = distance.shape;
  std::vector<char> shut(shape.count());
  for (std::size_t n = 0; n < shut.size(); ++n) shut[n] = distance[n] > kPasses * shape.step;
  std::vector<std::size_t> front;
  const auto open = [&](std::size_t n) {
    if (!shut[n]) return;
    shut[n] = 0;
    front.push_back(n);
  };
  for (std::size_t n = 0; n < shut.size(); ++n) {
    const Eigen::Vector3i c = shape.cell(n);
    if (c.minCoeff() == 0 || (shape.size - c).minCoeff() == 1) open(n);
  }
  while (!front.empty()) {
    const Eigen::Vector3i c = shape.cell(front.back());
    front.pop_back();
    for (int axis = 0; axis < 3; ++axis)
      for (const int by : {-1, 1}) {
        Eigen::Vector3i next = c;
        next[axis] += by;
        if (shape.contains(next)) open(shape.index(next));
      }
  }
  std::vector<Eigen::Vector3d> places;
  for (std::size_t n = 0; n < shut.size(); ++n)
    if (shut[n]) places.push_back(shape.position(n));
  return places;
}

}  // namespace transformables::finishing
