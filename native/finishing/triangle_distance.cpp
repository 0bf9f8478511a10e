#include "finishing/triangle_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace transformables::finishing {
namespace {

using Eigen::Vector3d;

void keep(Nearest& best, const Vector3d& on_a, const Vector3d& on_b) {
  const double d = (on_a - on_b).norm();
  if (d < best.distance) best = {on_a, on_b, d};
}

double clamped(double x) { return std::clamp(x, 0.0, 1.0); }

/// Nearest points of two segments p + s u, q + t v, with s and t from 0 to 1.
void edges(Nearest& best, const Vector3d& p, const Vector3d& u, const Vector3d& q, const Vector3d& v) {
  const Vector3d r = p - q;
  const double a = u.dot(u), e = v.dot(v), f = v.dot(r), c = u.dot(r), b = u.dot(v);
  const double denominator = a * e - b * b;
  double s = denominator > 1e-14 * a * e ? clamped((b * f - c * e) / denominator) : 0;
  double t = e > 0 ? (b * s + f) / e : 0;
  if (t < 0 || t > 1) {
    t = clamped(t);
    s = a > 0 ? clamped((b * t - c) / a) : 0;
  }
  keep(best, p + s * u, q + t * v);
}

/// The foot of a corner on a triangle's plane, when it falls inside.
bool foot(const Triangle& t, const Vector3d& normal, double square, const Vector3d& p, Vector3d& out) {
  const Vector3d q = p - (normal.dot(p - t[0]) / square) * normal;
  for (int n = 0; n < 3; ++n)
    if (normal.dot((t[(n + 1) % 3] - t[n]).cross(q - t[n])) < 0) return false;
  out = q;
  return true;
}

/// Corners of `a` against the face of `b`, and edges of `a` that pierce it.
template <class Keep>
void face(const Triangle& a, const Triangle& b, Keep keep_pair) {
  const Vector3d normal = (b[1] - b[0]).cross(b[2] - b[0]);
  const double square = normal.squaredNorm();
  if (!(square > 0)) return;  // its edges say all
  double height[3];
  for (int n = 0; n < 3; ++n) height[n] = normal.dot(a[n] - b[0]);
  Vector3d q;
  for (int n = 0; n < 3; ++n) {
    if (foot(b, normal, square, a[n], q)) keep_pair(a[n], q);
    const int m = (n + 1) % 3;
    if ((height[n] < 0) == (height[m] < 0)) continue;
    const Vector3d p = a[n] + height[n] / (height[n] - height[m]) * (a[m] - a[n]);
    if (foot(b, normal, square, p, q)) keep_pair(q, q);
  }
}

}  // namespace

Nearest nearest(const Triangle& a, const Triangle& b) {
  Nearest best;
  best.distance = 1e300;
  for (int n = 0; n < 3; ++n)
    for (int m = 0; m < 3; ++m) edges(best, a[n], a[(n + 1) % 3] - a[n], b[m], b[(m + 1) % 3] - b[m]);
  face(a, b, [&](const Vector3d& on_a, const Vector3d& on_b) { keep(best, on_a, on_b); });
  face(b, a, [&](const Vector3d& on_b, const Vector3d& on_a) { keep(best, on_a, on_b); });
  return best;
}

}  // namespace transformables::finishing
