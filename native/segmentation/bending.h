// The smoothest values of some samples between bounds, the others about them standing still. Inner to the room.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace transformables::segmentation_inner {

/// Numbers in a row each, the samples that move first: they are read again and again, and lie together so.
class Bending {
 public:
  /// @param count  of samples that move
  explicit Bending(std::size_t count);

  /// A sample that moves.
  void set(std::size_t k, float value, float low, float high) { value_[k] = value, low_[k] = low, high_[k] = high; }
  /// One that does not; gives its number. All are told before the first step.
  std::size_t add_still(float value);
  /// Neighbours of one that moves, six at most.
  void set_beside(std::size_t k, const std::array<std::uint32_t, 6>& beside, int count);

  /// A step down the bending energy (the Laplacian squared).
  void step();
  float operator[](std::size_t k) const { return value_[k]; }

 private:
  std::size_t count_;                                  // rounded up to eights
  std::vector<float> value_, next_, bend_;             // of all
  std::vector<float> low_, high_, neighbours_;         // of those that move; how many neighbours
  std::array<std::vector<std::int32_t>, 6> beside_;    // the same
};

}  // namespace transformables::segmentation_inner
