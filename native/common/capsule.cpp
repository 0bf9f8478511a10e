#include "common/capsule.h"

namespace transformables {

double distance(const Segment& s, const Segment& t) {
  const Eigen::Vector3d d1 = s.b - s.a, d2 = t.b - t.a, r = s.a - t.a;
  const double a = d1.squaredNorm(), e = d2.squaredNorm();
  if (!(a > 0)) return distance(t, s.a);
  if (!(e > 0)) return distance(s, t.a);
  const double f = d2.dot(r), b = d1.dot(d2), c = d1.dot(r), denominator = a * e - b * b;
  // Parallel to within rounding: every u has its v at the same distance, so any will do. Before that rounding spoils u, by
  // no more than 1e-7 of a length in the distance, since the distance then hardly depends on u.
  double u = denominator > 0 ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
  double v = (b * u + f) / e;
  if (v < 0) {
    v = 0;
    u = std::clamp(-c / a, 0.0, 1.0);
  } else if (v > 1) {
    v = 1;
    u = std::clamp((b - c) / a, 0.0, 1.0);
  }
  return (s.a + u * d1 - t.a - v * d2).norm();
}

}  // namespace transformables
