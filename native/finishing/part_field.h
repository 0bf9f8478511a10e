// The parts as sampled solids on one fine lattice, each over its own box.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
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
  double passing = 0;  ///< the same, while they pass each other: less, and more than the proof of the motion asks for
  double scale = 1;    ///< target units for one Blender unit
  double cover = 0;    ///< a point moves at most this far from the nearest configuration that is looked at

  double step() const { return outer.shape.step; }
  double sample_volume() const { return step() * step() * step(); }
};

/// How far a sample is from what bounds a part. Side by side, as they are read together at any place.
struct Away {
  float inner = 0;        ///< signed distance of the interfaces: everywhere a lower bound
  float outer = 0;        ///< signed distance of the target
};

/// A part in object mode: what the interfaces leave of the target. The two bounds are kept apart, as the edge where they cross is sharp, and
/// a single field would round it off. Negative is inside, in all fields; all have the same box.
struct PartField {
  int bone = 0;
  Eigen::Vector3i corner = Eigen::Vector3i::Zero();  ///< the box's first sample, in samples of the lattice
  Grid<float> inner;      ///< the solid as if the target were everywhere: its zero is the interfaces, known to a few samples outside the target
  Grid<float> psi;        ///< the solid: the greater of `inner` and the target's signed distance
  Grid<Away> away;        ///< how far it is to both
  Grid<float> core;       ///< the skeletal shape, as if the target were everywhere: never carved for another's skin
  Grid<float> uncarved;   ///< `inner` as it was made

  const GridShape& shape() const { return psi.shape; }
  /// A lower bound of a sample's distance to the solid.
  float bound(std::size_t n) const { return std::max(away[n].inner, away[n].outer); }
};

/// Makes `psi` the part's solid, by changing `inner` where it differs.
void adopt(PartField& part, Grid<float> psi);

/// Brings `psi` and `away` up to date with `inner`, after what carving took under the target's surface was taken outside of it, too.
void refresh(PartField& part);

/// A lattice `refinement` times as fine as the target's grid, about the target with a margin.
/// @throws InvalidInput when it would be too large to hold.
Lattice make_lattice(const Target& target, const FinishingOptions& options);

/// Parts from the level sets: they stand apart by the lattice's gap at interfaces and are bounded by the target
/// elsewhere; each is united with its bone's skeletal shape, before which all others step back. One a bone, in order.
std::vector<PartField> make_part_fields(const Segmentation& segmentation, const Character& character,
                                        const Embedding& embedding, const FinishingOptions& options, const Lattice& lattice);

/// A field's solid as a signed distance (fast sweeping; Zhao 2005), first order; at most 4 steps deep inside, and 20 far away.
Grid<float> redistanced(const Grid<float>& psi);

std::size_t inside_count(const Grid<float>& psi);

}  // namespace transformables::finishing
