#include "segmentation/seams.h"

#include <cmath>
#include <deque>
#include <map>
#include <set>

#include "segmentation/contour.h"
#include "segmentation/lattice.h"

namespace transformables {
namespace {

using namespace segmentation_inner;

constexpr std::size_t kLongest = 20000;   // points of a contour
constexpr std::size_t kLeastPoints = 4;

// One pair's contours, and where they have been traced already.
class Tracer {
 public:
  Tracer(const Segmentation& segmentation, const Target& target, int a, int b, double spacing)
      : contour_(segmentation, target, a, b), step_(segmentation.shape.step), spacing_(spacing), a_(a), b_(b) {}

  void from(const Eigen::Vector3d& seed, std::vector<Seam>& seams) {
    const auto start = contour_.projected(seed);
    if (!start || contour_.is_others(*start) || is_known(*start)) return;
    std::deque<Eigen::Vector3d> points{*start};
    const bool closed = follow(points, 1);
    if (!closed) follow(points, -1);
    for (const auto& p : points) known_.insert(cell(p));
    if (points.size() >= kLeastPoints) seams.push_back({a_, b_, closed, {points.begin(), points.end()}});
  }

 private:
  using Cell = std::array<int, 3>;
  Cell cell(const Eigen::Vector3d& p) const {
    const Eigen::Vector3i c = (p / step_).array().floor().matrix().cast<int>();
    return {c.x(), c.y(), c.z()};
  }
  bool is_known(const Eigen::Vector3d& p) const {
    const Cell c = cell(p);
    for (int k = 0; k < 27; ++k)
      if (known_.count({c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1})) return true;
    return false;
  }

  // Eq. 12, with a shorter step where the full one leads astray.
  std::optional<Eigen::Vector3d> next(const Eigen::Vector3d& p, const Eigen::Vector3d& along) const {
    for (double h = spacing_; h > 0.1 * spacing_; h /= 2) {
      const auto q = contour_.projected(p + h * along);
      if (q && !contour_.is_others(*q) && (*q - p).norm() > 0.3 * h && (*q - p).norm() < 2 * h && (*q - p).dot(along) > 0) return q;
    }
    return {};
  }

  // Adds points at the deque's end (or, backwards, at its front); true when the contour came back to its beginning.
  bool follow(std::deque<Eigen::Vector3d>& points, int way) const {
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    while (points.size() < kLongest) {
      const Eigen::Vector3d p = way > 0 ? points.back() : points.front();
      Eigen::Vector3d along = way * contour_.normal(p).cross(contour_.side_slope(p));
      if (along.norm() < 1e-6) return false;
      along.normalize();
      if (last.dot(along) < -0.5) along = -along;   // at a sharp edge gradients may turn over
      const auto q = next(p, along);
      if (!q) return false;
      last = (*q - p).normalized();
      if (way > 0 && points.size() > 3 && (*q - points.front()).norm() < 0.75 * spacing_) return true;
      // A contour that runs into its own middle has lost its way.
      if (points.size() > 8 && way > 0 && (*q - points[points.size() - 4]).norm() < 0.5 * spacing_) return false;
      way > 0 ? points.push_back(*q) : points.push_front(*q);
    }
    return false;
  }

  Contour contour_;
  double step_, spacing_;
  int a_, b_;
  std::set<Cell> known_;
};

}  // namespace

std::vector<Seam> traced_seams(const Segmentation& segmentation, const Target& target, double spacing_steps) {
  if (!(spacing_steps >= 0.25 && spacing_steps <= 4)) throw InvalidInput("seams: the spacing must be 0.25 to 4 steps of the grid");
  if (!(segmentation.shape == target.distance.shape) || segmentation.owner.size() != segmentation.shape.count())
    throw InvalidInput("seams: the segmentation belongs to another target or resolution; segment again");
  const GridShape& shape = segmentation.shape;
  std::map<std::pair<int, int>, Tracer> tracers;
  std::vector<Seam> seams;
  const double layer = 1.2 * shape.step;
  for (std::size_t i : target.inside) {
    if (target.distance[i] < -layer) continue;
    for_neighbours(shape, i, [&](std::size_t n) {
      const int a = segmentation.owner[i], b = segmentation.owner[n];
      if (b <= a || target.distance[n] < -layer) return;
      const auto [at, fresh] = tracers.try_emplace({a, b}, segmentation, target, a, b, spacing_steps * shape.step);
      at->second.from(0.5 * (shape.position(i) + shape.position(n)), seams);
    });
  }
  return seams;
}

}  // namespace transformables
