#include "embedding/interfaces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "common/eight.h"

namespace transformables {
namespace {

constexpr double kReach = 2.5;        // places so near to one another make its plane
constexpr double kPlain = 1e-6;       // of the squared spread of places: what tells their least direction from the next
constexpr double kOneSided = 1e-9;    // of the weight
constexpr int kNewtonSteps = 40;
// Places lie within half a voxel of their voxels' centres, so that the voxels of two that are near to one another are at most 3.5
// apart: so many along x and y of a slice that is 0, 1, 2 or 3 away.
constexpr int kWindow = 3;
constexpr std::array<std::ptrdiff_t, kWindow + 1> kWindows{3, 3, 2, 1};
constexpr double kFar = 1e6;          // where nothing is near
constexpr int kSums = 13;             // weight, first (3), second (6), to_parent (3)
constexpr std::size_t kMostNear = 7 * 7 * 7;

/// From a voxel's centre to the mean of those of its six faces that are set.
constexpr std::array<std::array<double, 3>, 64> to_faces() {
  std::array<std::array<double, 3>, 64> ways{};
  for (unsigned faces = 1; faces < 64; ++faces)
    for (unsigned side = 0; side < 6; ++side)
      if (faces >> side & 1) ways[faces][side / 2] += (side % 2 == 0 ? -0.5 : 0.5) / std::popcount(faces);
  return ways;
}
constexpr auto kToFaces = to_faces();

/// The places of the bits that are set in a byte, in front, and their number.
struct Chosen {
  std::array<std::array<std::int32_t, 8>, 256> lanes{};
  std::array<std::uint8_t, 256> count{};
};
constexpr Chosen chosen() {
  Chosen c;
  for (unsigned bits = 0; bits < 256; ++bits)
    for (unsigned k = 0; k < 8; ++k)
      if (bits >> k & 1) c.lanes[bits][c.count[bits]++] = std::int32_t(k);
  return c;
}
constexpr Chosen kChosen = chosen();

/// Appends those of the places [begin, end) whose keys are `low` to `low + span`. @return how many there are then
EIGHT_INLINE std::size_t choose(const std::int32_t* keys, std::uint32_t begin, std::uint32_t end, std::int32_t low, std::int32_t span,
                                    std::uint32_t* near, std::size_t count) {
  std::uint32_t k = begin;
  do {  // mostly there are no more than eight
    EIGHT_LOAD(Eight, key, keys + k);
    key -= low;
    const Eight within = (key >= 0) & (key <= span);
    EIGHT_BITS_OF_EIGHT(all, within);
    const std::uint32_t bits = all & ((1u << std::min(8u, end - k)) - 1);
    EIGHT_LOAD(Eight, lanes, kChosen.lanes[bits].data());
    lanes += std::int32_t(k);
    std::memcpy(near + count, &lanes, sizeof lanes);
    count += kChosen.count[bits];
    k += 8;
  } while (k < end);
  return count;
}

/// Sums over the places `near` (a multiple of four) about the place `at`: see `Moments`.
EIGHT_INLINE void sum_up(const Interfaces::Place* places, const std::uint32_t* near, std::size_t count, const double* at, double* sums) {
  const Four none = {};
  Four s0 = {}, s1 = {}, s2 = {}, s3 = {}, s4 = {}, s5 = {}, s6 = {}, s7 = {}, s8 = {}, s9 = {};
  alignas(32) double weights[kMostNear + 8];
  for (std::size_t k = 0; k < count; k += 4) {
    const Interfaces::Place &a = places[near[k]], &b = places[near[k + 1]], &c = places[near[k + 2]], &d = places[near[k + 3]];
    const Four x = Four{a.at[0], b.at[0], c.at[0], d.at[0]} - at[0], y = Four{a.at[1], b.at[1], c.at[1], d.at[1]} - at[1],
               z = Four{a.at[2], b.at[2], c.at[2], d.at[2]} - at[2];
    const Four left = 1 - (x * x + y * y + z * z) * (1 / (kReach * kReach)), within = left > none ? left : none;
    const Four w = within * within * within, wx = w * x, wy = w * y, wz = w * z;
    std::memcpy(weights + k, &w, sizeof w);
    s0 += w;
    s1 += wx;
    s2 += wy;
    s3 += wz;
    s4 += wx * x;
    s5 += wx * y;
    s6 += wx * z;
    s7 += wy * y;
    s8 += wy * z;
    s9 += wz * z;
  }
  const Four* all[10] = {&s0, &s1, &s2, &s3, &s4, &s5, &s6, &s7, &s8, &s9};
  for (int k = 0; k < 10; ++k) sums[k] = ((*all[k])[0] + (*all[k])[1]) + ((*all[k])[2] + (*all[k])[3]);
  Four side = {};
  for (std::size_t k = 0; k < count; ++k) {
    EIGHT_LOAD(Four, way, places[near[k]].to_parent);
    side += weights[k] * way;
  }
  for (int k = 0; k < 3; ++k) sums[10 + k] = side[k];
}

struct View {
  const Interfaces::Place* places;
  const std::int32_t* keys;
  const std::uint32_t* first;   // of the row of the place
  std::size_t slice;            // rows
  std::uint32_t far;            // a place that is near to none
  std::uint32_t* near;
};

EIGHT_INLINE void moments_of(const View& view, const Interfaces::Place& place, double* sums) {
  std::size_t count = 0;
  for (std::ptrdiff_t z = -kWindow; z <= kWindow; ++z) {
    const std::ptrdiff_t reach = kWindows[std::size_t(std::abs(z))];
    const std::uint32_t* row = view.first + z * std::ptrdiff_t(view.slice);
    count = choose(view.keys, row[-reach], row[reach + 1], place.key - std::int32_t(reach), 2 * std::int32_t(reach), view.near, count);
  }
  for (std::size_t k = 0; k < 3; ++k) view.near[count + k] = view.far;
  sum_up(view.places, view.near, (count + 3) / 4 * 4, place.at, sums);
}

void moments_plain(const View& view, const Interfaces::Place& place, double* sums) { moments_of(view, place, sums); }
EIGHT_AVX2 void moments_avx2(const View& view, const Interfaces::Place& place, double* sums) { moments_of(view, place, sums); }

/// Of four matrices that have no negative eigenvalue the least one, from the coefficients of det(A - x I): from below, Newton's steps
/// do not pass it.
/// @param slopes  there: the product of its distances from the other two
EIGHT_INLINE void least_of_four(const double* traces, const double* minors, const double* determinants, double* least, double* slopes) {
  EIGHT_LOAD(Four, trace, traces);
  EIGHT_LOAD(Four, minor, minors);
  EIGHT_LOAD(Four, determinant, determinants);
  const Four small = 1e-15 * trace, plain = kPlain * trace * trace;  // the slope only falls: where it is no more than `plain`, so it is at the root
  Four x = {}, slope = {};
  for (int k = 0; k < kNewtonSteps; ++k) {
    slope = (3 * x - 2 * trace) * x + minor;
    const Four step = (determinant - ((x - trace) * x + minor) * x) / slope;
    const Lanes goes_on = Lanes(step > small) & Lanes(slope > plain);
    x += Four(Lanes(step) & goes_on);
    if (!(goes_on[0] | goes_on[1] | goes_on[2] | goes_on[3])) break;
  }
  std::memcpy(least, &x, sizeof x);
  std::memcpy(slopes, &slope, sizeof slope);
}

void least_plain(const double* traces, const double* minors, const double* determinants, double* least, double* slopes) {
  least_of_four(traces, minors, determinants, least, slopes);
}
EIGHT_AVX2 void least_avx2(const double* traces, const double* minors, const double* determinants, double* least, double* slopes) {
  least_of_four(traces, minors, determinants, least, slopes);
}

/// The normal, when the least eigenvalue of the places' covariance is known.
Eigen::Vector3d normal_of(const Eigen::Matrix3d& a, const Moments& moments, double least, double slope) {
  const double side = moments.to_parent.norm(), least_side = kOneSided * moments.weight, trace = a.trace();
  if (!(side > least_side)) return Eigen::Vector3d::Zero();
  if (!(slope > kPlain * trace * trace)) return moments.to_parent / side;
  // The adjugate of A - x I is slope n n^T: its largest column is along n.
  const Eigen::Vector3d b0(a(0, 0) - least, a(1, 0), a(2, 0)), b1(a(0, 1), a(1, 1) - least, a(2, 1)), b2(a(0, 2), a(1, 2), a(2, 2) - least);
  const Eigen::Vector3d c[3] = {b1.cross(b2), b2.cross(b0), b0.cross(b1)};
  const int k = c[0][0] > c[1][1] ? (c[0][0] > c[2][2] ? 0 : 2) : (c[1][1] > c[2][2] ? 1 : 2);
  const Eigen::Vector3d normal = c[k].normalized();
  const double facing = normal.dot(moments.to_parent);
  if (!(std::abs(facing) > least_side)) return Eigen::Vector3d::Zero();
  return facing < 0 ? Eigen::Vector3d(-normal) : normal;
}

}  // namespace

void fit_normals(const std::array<Moments, 4>& moments, std::array<Eigen::Vector3d, 4>& normals) {
  Eigen::Matrix3d a[4];
  double trace[4], minors[4], determinant[4], least[4], slope[4];
  for (std::size_t k = 0; k < 4; ++k) {
    Eigen::Matrix3d& m = a[k];
    m = moments[k].second - moments[k].first * moments[k].first.transpose() / moments[k].weight;
    const double c0 = m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2), c1 = m(0, 1) * m(2, 2) - m(1, 2) * m(0, 2), c2 = m(0, 1) * m(1, 2) - m(1, 1) * m(0, 2);
    trace[k] = m.trace();
    minors[k] = c0 + m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2) + m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1);
    determinant[k] = m(0, 0) * c0 - m(0, 1) * c1 + m(0, 2) * c2;
  }
  (has_avx2() ? least_avx2 : least_plain)(trace, minors, determinant, least, slope);
  for (std::size_t k = 0; k < 4; ++k) normals[k] = normal_of(a[k], moments[k], least[k], slope[k]);
}

Interfaces::Interfaces(const Voxels& voxels) : row_pitch_(std::size_t(voxels.size.y()) + 2 * kWindow) {
  places_.reserve(voxels.inside + 1);
  keys_.reserve(voxels.inside + 8);
  sampled_.reserve(voxels.inside + 3);
  first_.assign(row_pitch_ * (std::size_t(voxels.size.z()) + 2 * kWindow) + 1, 0);
  near_.assign(kMostNear + 8, 0);
}

void Interfaces::clear() {
  places_.clear();
  keys_.clear();
  sampled_.clear();
  rows_ = 0;
}

/// From the last row on up to this one there is nothing.
void Interfaces::end_rows(std::size_t row) {
  for (; rows_ <= row; ++rows_) first_[rows_] = std::uint32_t(places_.size());
}

void Interfaces::add(int child, const Eigen::Vector3i& voxel, int faces, bool sampled) {
  const std::size_t row = std::size_t(voxel.z() + kWindow) * row_pitch_ + std::size_t(voxel.y() + kWindow);
  end_rows(row);
  if (sampled) sampled_.push_back(std::uint32_t(places_.size()));
  const auto& way = kToFaces[std::size_t(faces)];
  const std::int32_t key = child << kChildBit | voxel.x();
  places_.push_back({{voxel.x() + way[0], voxel.y() + way[1], voxel.z() + way[2]}, key, std::uint32_t(row), {way[0], way[1], way[2], 0}});
  keys_.push_back(key);
}

void Interfaces::finish() {
  end_rows(first_.size() - 1);
  keys_.resize(places_.size() + 8);  // they are read by eights
  places_.push_back({{kFar, kFar, kFar}, 0, 0, {}});
}

Moments Interfaces::moments(const Place& place) {
  const View view{places_.data(), keys_.data(), first_.data() + place.row, row_pitch_, std::uint32_t(places_.size() - 1), near_.data()};
  std::array<double, kSums> s;
  (has_avx2() ? moments_avx2 : moments_plain)(view, place, s.data());
  Moments result;
  result.weight = s[0];
  result.first << s[1], s[2], s[3];
  result.second << s[4], s[5], s[6], s[5], s[7], s[8], s[6], s[8], s[9];
  result.to_parent << s[10], s[11], s[12];
  return result;
}

}  // namespace transformables
