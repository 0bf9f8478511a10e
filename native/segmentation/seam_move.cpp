#include "segmentation/seam_move.h"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "segmentation/contour.h"
#include "segmentation/lattice.h"
#include "segmentation/tiling.h"
#include "segmentation/ways.h"

namespace transformables::segmentation_inner {
namespace {

constexpr double kStillThere = 0.8;   // of the moved points, that must lie on a seam of these bones
constexpr double kNear = 2.5;         // steps: so near a point is on the seam, or on the surface
constexpr double kMoved = 0.25;       // steps: less is no move
constexpr double kReach = 3;          // of the largest displacement: how far into the parts it is felt. Less would fold space
constexpr double kLeastReach = 6;     // steps
constexpr double kBlend = 2;          // steps: neighbouring points' displacements are mixed within
constexpr double kLambda = 1;         // of the regularised least squares
constexpr int kSolves = 24;           // as each takes only a part of the error away
constexpr int kRounds = 3;            // of solving, and smoothing what it did
constexpr double kPinned = 2;         // steps from the seam

bool is_moved(const SeamMove& move, std::size_t k, double step) { return (move.to[k] - move.from[k]).norm() > kMoved * step; }

std::string problem_with(const Segmentation& segmentation, const Target& target, const SeamMove& move) {
  const double step = segmentation.shape.step;
  const Contour contour(segmentation, target, move.a, move.b);
  std::size_t moved = 0, there = 0, on_target = 0;
  for (std::size_t k = 0; k < move.from.size(); ++k) {
    if (!is_moved(move, k, step)) continue;
    ++moved;
    there += std::abs(contour.side(move.from[k])) < kNear * step && std::abs(contour.outside(move.from[k])) < kNear * step && !contour.is_others(move.from[k]);
    on_target += std::abs(contour.outside(move.to[k])) < kNear * step;
  }
  if (moved == 0) return "nothing of it is moved";
  if (double(there) < kStillThere * double(moved)) return "the seam is not there any more";
  if (double(on_target) < kStillThere * double(moved)) return "its new place is not on the target";
  return {};
}

// Inside samples of the two parts around the seam's old and new place, each with its distance from the new one, by ways within the parts.
struct Band {
  std::vector<std::size_t> samples;
  std::vector<double> distance;
  double reach = 0;
};

Band band_around(const Segmentation& segmentation, const Target& target, const SeamMove& move) {
  const GridShape& shape = segmentation.shape;
  double largest = 0;
  for (std::size_t k = 0; k < move.to.size(); ++k) largest = std::max(largest, (move.to[k] - move.from[k]).norm());
  Band band;
  band.reach = std::max(kReach * largest, kLeastReach * shape.step);
  const NearestPoints near = nearest_points(shape, move.to, band.reach, [&](std::size_t i) {
    return segmentation.owner[i] == move.a || segmentation.owner[i] == move.b;
  });
  for (std::size_t i : target.inside)
    if (near.point[i] >= 0) band.samples.push_back(i), band.distance.push_back(near.distance[i]);
  return band;
}

// What moves a place p to where it is: the displacements of the seam's points near it, fading into the parts.
Eigen::Vector3d displacement(const SeamMove& move, const Band& band, const Eigen::Vector3d& p, double distance, double step) {
  const double width = 2 * std::pow(kBlend * step, 2), least = distance * distance;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0;
  for (std::size_t k = 0; k < move.to.size(); ++k) {
    const double excess = (p - move.to[k]).squaredNorm() - least;
    if (excess > 6 * width) continue;
    const double w = std::exp(-std::max(excess, 0.0) / width);
    sum += w * (move.to[k] - move.from[k]), weight += w;
  }
  const double fade = 1 - std::min(distance / band.reach, 1.0);
  return weight > 0 ? Eigen::Vector3d(sum / weight * fade * fade * (3 - 2 * fade)) : Eigen::Vector3d::Zero();
}

// A level set over a box that also holds the band; new samples far on the outer side.
Grid<float> widened(const Grid<float>& phi, const GridShape& shape, const Band& band) {
  Eigen::Vector3i low = shape.size, high = Eigen::Vector3i::Zero();
  for (std::size_t i : band.samples) low = low.cwiseMin(shape.cell(i)), high = high.cwiseMax(shape.cell(i));
  Eigen::Vector3i first = Eigen::Vector3i::Zero();
  if (!phi.values.empty()) {
    first = shape.nearest(phi.shape.origin);
    low = low.cwiseMin(first), high = high.cwiseMax(first + phi.shape.size - Eigen::Vector3i::Ones());
  }
  Grid<float> wide({high - low + Eigen::Vector3i::Ones(), shape.position(low), shape.step}, float(kBand * shape.step));
  for (std::size_t i = 0; i < phi.values.size(); ++i) wide.at(phi.shape.cell(i) + first - low) = phi[i];
  return wide;
}

// The interface carried along: every sample takes the values of the place that comes to it.
void carry(Segmentation& segmentation, const Target& target, const std::vector<std::int16_t>& core, const SeamMove& move, const Band& band) {
  const GridShape& shape = segmentation.shape;
  const Segmentation& before = segmentation;
  const Contour contour(before, target, move.a, move.b);
  std::vector<float> side(band.samples.size());
  for (std::size_t k = 0; k < side.size(); ++k) {
    const Eigen::Vector3d p = shape.position(band.samples[k]);
    side[k] = float(contour.side(p - displacement(move, band, p, band.distance[k], shape.step)));
  }
  Grid<float> a = widened(segmentation.phi[move.a], shape, band), b = widened(segmentation.phi[move.b], shape, band);
  const Eigen::Vector3i first_a = shape.nearest(a.shape.origin), first_b = shape.nearest(b.shape.origin);
  const float most = float(kBand * shape.step);
  for (std::size_t k = 0; k < side.size(); ++k) {
    const std::size_t i = band.samples[k];
    if (core[i] >= 0) continue;
    const Eigen::Vector3i c = shape.cell(i);
    a.at(c - first_a) = std::clamp(side[k], -most, most);
    b.at(c - first_b) = std::clamp(-side[k], -most, most);
    segmentation.owner[i] = std::int16_t(side[k] < 0 ? move.a : move.b);
  }
  segmentation.phi[move.a] = std::move(a);
  segmentation.phi[move.b] = std::move(b);
}

// Eqs. 13 to 15: the least change of the grid's values, by regularised least squares, that makes both level sets equal at `to`. Each solve
// takes a part of the error away, as one step of growth does in the paper. (With the sign of Eq. 7 the velocity that reaches zero in a
// step is phi / dt, where Eq. 14 has -phi / dt.)
class Settling {
 public:
  Settling(const GridShape& shape, const SeamMove& move) : shape_(shape) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t row = 0; row < move.to.size(); ++row) {
      const Eigen::Vector3d q = (move.to[row] - shape.origin) / shape.step;
      const Eigen::Vector3i c = q.array().floor().matrix().cast<int>();
      const Eigen::Vector3d t = q - c.cast<double>();
      for (int k = 0; k < 8; ++k) {
        const Eigen::Vector3i o(k & 1, k >> 1 & 1, k >> 2);
        if (!shape.contains(c + o)) continue;
        double w = 1;
        for (int axis = 0; axis < 3; ++axis) w *= o[axis] ? t[axis] : 1 - t[axis];
        const auto [at, fresh] = column_.try_emplace(shape.index(c + o), int(column_.size()));
        entries.emplace_back(int(row), at->second, w);
      }
    }
    weights_.resize(Eigen::Index(move.to.size()), Eigen::Index(column_.size()));
    weights_.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseMatrix<double> identity(weights_.cols(), weights_.cols());
    identity.setIdentity();
    solver_.compute(Eigen::SparseMatrix<double>(weights_.transpose()) * weights_ + kLambda * identity);
  }

  // For an error at each point the change of each sample that takes it away, as far as it can.
  std::vector<std::pair<std::size_t, double>> change(Eigen::VectorXd error) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(weights_.cols());
    for (int k = 0; k < kSolves; ++k) {
      const Eigen::VectorXd x = solver_.solve(weights_.transpose() * error);
      sum += x;
      error -= weights_ * x;
    }
    std::vector<std::pair<std::size_t, double>> result;
    for (const auto& [sample, column] : column_) result.emplace_back(sample, sum[column]);
    return result;
  }

 private:
  GridShape shape_;
  std::map<std::size_t, int> column_;
  Eigen::SparseMatrix<double> weights_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

void add(Grid<float>& phi, const GridShape& shape, std::size_t sample, double by) {
  const Eigen::Vector3i c = shape.cell(sample) - shape.nearest(phi.shape.origin);
  if (!phi.values.empty() && phi.shape.contains(c)) phi.at(c) += float(by);
}

// Owners made a tiling, level sets made to agree with them and continued outside the target.
void tile(Segmentation& segmentation, const Target& target, const Surfaces& surfaces, const std::vector<std::int16_t>& core, int threads) {
  std::vector<char> growing;
  for (int bone = 0; bone < int(segmentation.phi.size()) && !segmentation.inhibited.empty(); ++bone) growing.push_back(segmentation.may_grow(bone));
  make_tiling(target, core, int(segmentation.phi.size()), segmentation.owner, growing);
  surfaces.settle(segmentation, {}, threads);
}

void settle(Segmentation& segmentation, const Target& target, const Surfaces& surfaces, const std::vector<std::int16_t>& core, const SeamMove& move,
            int threads) {
  const GridShape& shape = segmentation.shape;
  const Settling settling(shape, move);
  const std::vector<char> inside = inside_flags(target);
  for (int round = 0; round < kRounds; ++round) {
    const Contour contour(segmentation, target, move.a, move.b);
    Eigen::VectorXd error(Eigen::Index(move.to.size()));
    for (std::size_t k = 0; k < move.to.size(); ++k) error[Eigen::Index(k)] = contour.is_others(move.to[k]) ? 0 : -contour.side(move.to[k]);
    for (const auto& [sample, by] : settling.change(error)) {
      add(segmentation.phi[move.a], shape, sample, by);
      add(segmentation.phi[move.b], shape, sample, -by);
      const bool theirs = segmentation.owner[sample] == move.a || segmentation.owner[sample] == move.b;
      if (!inside[sample] || !theirs || core[sample] >= 0) continue;
      segmentation.owner[sample] = std::int16_t(contour.side(shape.position(sample)) < 0 ? move.a : move.b);
    }
    tile(segmentation, target, surfaces, core, threads);
  }
}

}  // namespace

std::string move_seam(Segmentation& segmentation, const Target& target, const Surfaces& surfaces, const std::vector<std::int16_t>& core,
                      const SeamMove& move, int threads) {
  const std::string problem = problem_with(segmentation, target, move);
  if (!problem.empty()) return problem;
  carry(segmentation, target, core, move, band_around(segmentation, target, move));
  tile(segmentation, target, surfaces, core, threads);
  settle(segmentation, target, surfaces, core, move, threads);
  return {};
}

std::vector<std::size_t> beside_seam(const Segmentation& segmentation, const SeamMove& move) {
  const GridShape& shape = segmentation.shape;
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < move.to.size(); ++k) {
    if (!is_moved(move, k, shape.step)) continue;
    const Eigen::Vector3i c = shape.nearest(move.to[k]);
    for (int o = 0; o < 125; ++o) {
      const Eigen::Vector3i n = c + Eigen::Vector3i(o % 5 - 2, o / 5 % 5 - 2, o / 25 - 2);
      if (!shape.contains(n)) continue;
      const std::size_t i = shape.index(n);
      const int owner = segmentation.owner[i];
      if ((owner == move.a || owner == move.b) && (shape.position(i) - move.to[k]).norm() < kPinned * shape.step) found.push_back(i);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace transformables::segmentation_inner
