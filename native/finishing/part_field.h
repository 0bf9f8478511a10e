// The parts as sampled solids on one fine lattice, each over its own box.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "character/character.h"
#include "common/grid.h"
#include "embedding/embedding.h"
#include "finishing/finishing.h"
#include "segmentation/segmentation.h"
#include "target/target.h"

namespace transformables::finishing {

/// What all parts share: where samples are, the target there, and the gaps.
struct Lattice {
  Grid<float> outer;   ///< signed distance of the target, negative inside; its shape is the lattice
  double gap = 0;      ///< between two parts as measured at configurations, target units
  double cover = 0;    ///< a point moves at most this far from the nearest configuration that is looked at

  double step() const { return outer.shape.step; }
  double sample_volume() const { return step() * step() * step(); }
};

/// A part in object mode. Negative is inside, in all fields; all have the same box.
struct PartField {
  int bone = 0;
  Eigen::Vector3i corner = Eigen::Vector3i::Zero();  ///< the box's first sample, in samples of the lattice
  Grid<float> psi;        ///< the solid: its zero is the surface
  Grid<float> distance;   ///< the same solid as a distance, everywhere a lower bound
  Grid<float> core;       ///< the skeletal shape's share of the target: never carved for another's skin

  const GridShape& shape() const { return psi.shape; }
};

/// A lattice `refinement` times as fine as the target's grid, about the target with a margin.
/// @throws InvalidInput when it would be too large to hold.
Lattice make_lattice(const Target& target, const FinishingOptions& options);

/// Parts from the level sets: they stand apart by the lattice's gap at interfaces and are bounded by the target
/// elsewhere; each is united with its bone's skeletal shape, before which all others step back. One a bone, in order.
std::vector<PartField> make_part_fields(const Segmentation& segmentation, const Character& character,
                                        const Embedding& embedding, const FinishingOptions& options, const Lattice& lattice);

/// A field's solid as a signed distance (fast sweeping; Zhao 2005), first order, on the whole grid.
Grid<float> redistanced(const Grid<float>& psi);

std::size_t inside_count(const Grid<float>& psi);

}  // namespace transformables::finishing
