// Painted regions of the target's surface as a soft term of the search.
#pragma once

#include <array>
#include <vector>

#include "embedding/embedding.h"
#include "embedding/skeleton.h"

namespace transformables {

class PaintedTerm {
 public:
  explicit PaintedTerm(const std::vector<PaintedRegion>& regions);

  /// How much nearer to the regions the bones that they are to go to would have to be, to be nearer than all others by a margin: the mean over
  /// each region's places, summed over regions; target units. A region that any one bone may have counts for the bone that lacks least. 0: all
  /// are as wished, or there are none. The segments of the skeleton's bones must be set.
  double operator()(const Skeleton& skeleton) const;

 private:
  struct Region {
    int bone;
    std::vector<Eigen::Vector3d> places;
  };
  std::vector<Region> regions_;
};

}  // namespace transformables
