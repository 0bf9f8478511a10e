// Where the parts of bones meet those of their parents: the places and normals of Eq. 3.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "embedding/voxels.h"

namespace transformables {

/// Sums over the places about one, each weighed by how near it is: what moving least squares need.
struct Moments {
  double weight = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();        ///< of the offsets
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Eigen::Vector3d to_parent = Eigen::Vector3d::Zero();    ///< of the ways from child to parent
};

/// The normals of the planes that fit the places best (four at a time, for speed), on the side that `to_parent` is on. Where places make
/// no plane (a line, a point, a ball) it is that side itself, and zero where they have no side.
void fit_normals(const std::array<Moments, 4>& moments, std::array<Eigen::Vector3d, 4>& normals);

/// One object a thread. Lengths are in voxels. All room is made beforehand.
class Interfaces {
 public:
  explicit Interfaces(const Voxels& voxels);

  void clear();
  /// A voxel of a child's part that touches its parent's. They meet at the mean of the faces between.
  /// In the order of the grid, z slowest.
  /// @param voxel    x, y, z
  /// @param faces    bit f for the side f of -x, x, -y, y, -z, z
  /// @param sampled  whether Eq. 3 sums over it; the others only help to find the normals
  void add(int child, const Eigen::Vector3i& voxel, int faces, bool sampled);

  /// Calls visit(child, place, normal) for each sample. The normal is a unit vector from child to parent, or zero.
  template <class Visit>
  void for_each_sample(const Visit& visit) {
    finish();
    std::array<Moments, 4> moments_of;
    std::array<Eigen::Vector3d, 4> normals;
    for (std::size_t k = 0; k < sampled_.size(); k += 4) {
      const std::size_t count = std::min<std::size_t>(4, sampled_.size() - k);
      for (std::size_t i = 0; i < count; ++i) moments_of[i] = moments(places_[sampled_[k + i]]);
      fit_normals(moments_of, normals);
      for (std::size_t i = 0; i < count; ++i) {
        const Place& place = places_[sampled_[k + i]];
        visit(place.key >> kChildBit, Eigen::Vector3d(place.at[0], place.at[1], place.at[2]), normals[i]);
      }
    }
  }

  struct alignas(64) Place {
    double at[3];
    std::int32_t key;                    ///< child and x
    std::uint32_t row;
    double to_parent[4];                 ///< the last one 0
  };

 private:
  static constexpr int kChildBit = 16;   ///< of a key; x is below it
  void end_rows(std::size_t row);
  void finish();
  Moments moments(const Place& place);

  std::size_t row_pitch_ = 0, rows_ = 0;
  std::vector<Place> places_;            ///< and at last one that is far from all
  std::vector<std::int32_t> keys_;       ///< of the places, again: this is what is searched
  std::vector<std::uint32_t> sampled_;   ///< places
  std::vector<std::uint32_t> first_;     ///< place of each row, with empty rows around the grid's
  std::vector<std::uint32_t> near_;
};

}  // namespace transformables
