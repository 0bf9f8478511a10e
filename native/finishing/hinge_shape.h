// A hinge as solids: a pin along the axis, a clevis (two ears that carry it), and a tongue between them that turns on it.
// All lie within the ball of the child's joint housing, which turning does not move: what parts that ball between the two bones
// can't come nearer to any third. Frame: origin at the joint, Z along the axis; target units.
#pragma once

#include <vector>

#include "common/mesh.h"

namespace transformables::finishing {

/// Measures of one hinge, from the housing's radius and the gap (its faces lie that far apart).
struct HingeSize {
  double outer = 0;        ///< the ball that is parted: the child's housing and half the gap about it
  double inner = 0;        ///< radius of what the parent brings into it
  double gap = 0;
  double pin = 0;          ///< radius
  double half_tongue = 0;  ///< half the tongue's thickness

  double hole() const { return pin + gap; }
  double ear_face() const { return half_tongue + gap; }
};

/// @param room  how far the target reaches about the joint: the parent's share stays within it
/// @return false when pin, ears or ring of the tongue would be too weak
bool hinge_size(double housing, double gap, double room, HingeSize& size);

/// Two ears with the pin between them: the ball of radius `ball` without the slab |z| < `face` further than `radius` from the axis.
TriangleMesh spool(double ball, double face, double radius);

/// A disc with a hole: what `spool` leaves of the ball.
TriangleMesh ring(double ball, double face, double radius);

/// What joins the parent's share to its body: a piece of a spherical layer.
struct Block {
  double from = 0, to = 0;                       ///< radii
  double polar_from = 0, polar_to = 0;           ///< angles from +Z, in (0, pi)
  double azimuth_from = 0, azimuth_to = 0;       ///< from +X towards +Y; a whole turn closes it to a band
};
TriangleMesh block(const Block& block);

}  // namespace transformables::finishing
