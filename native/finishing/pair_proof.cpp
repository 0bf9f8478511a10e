#include "finishing/pair_proof.h"

#include <algorithm>
#include <cmath>

#include "finishing/triangle_distance.h"

namespace transformables::finishing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRounding = 1e-10;   ///< taken off every bound: far more than double precision loses on lengths below 10
constexpr double kRowTravel = 0.04;   ///< a row of the certificate is a time in which no point travels further
constexpr double kShortest = 1e-9;     ///< half a span that is not halved again: nothing is proved by it that rounding does not spoil
constexpr double kOnePlace = 0.015;    ///< touches nearer to one another than this, on A, are told as one
constexpr std::size_t kMostTouches = 64;
constexpr std::size_t kKept = 20'000;  ///< halves of spans that are kept at once: 7 MB; beyond, they are made anew
constexpr double kBalance = 1.0;      ///< a time is halved while points travel further than this many radii of the boxes

/// The motion of points of one part, as seen from the other, but written in B's frame at the middle of a span.
struct Drift {
  Vector3d spin, shift;
  double loss;   ///< half the largest acceleration times the square of the time
};

/// Least value along `n` (a direction that stays with the other part) that a box's points take at a time from the middle.
class LeastOfBox {
 public:
  LeastOfBox(const Vector3d& n, const Vector3d& centre, const Eigen::Matrix3d& axes, const Vector3d& half, const Drift& drift) : half_(half) {
    const Vector3d turned = n.cross(drift.spin);
    middle_ = n.dot(centre);
    rate_ = turned.dot(centre) + n.dot(drift.shift);
    slope_.noalias() = axes.transpose() * n;
    slope_rate_.noalias() = axes.transpose() * turned;
  }
  double operator()(double time) const { return middle_ + time * rate_ - half_.dot((slope_ + time * slope_rate_).cwiseAbs()); }

 private:
  const Vector3d& half_;
  double middle_, rate_;
  Vector3d slope_, slope_rate_;   // along the box's axes
};

double least_of_triangle(const Vector3d& n, const Triangle& t, const Drift& drift, double time) {
  const Vector3d slope = n + time * n.cross(drift.spin);
  return std::min({slope.dot(t[0]), slope.dot(t[1]), slope.dot(t[2])}) + time * n.dot(drift.shift);
}

double highest(const Vector3d& n, const Triangle& t) { return std::max({n.dot(t[0]), n.dot(t[1]), n.dot(t[2])}); }

/// How far apart two triangles stay along `n`, which points from b to a.
double triangle_gap(const Vector3d& n, const Triangle& a, const Triangle& b, const Drift& of_a, const Drift& of_b, double h) {
  // The least of linear functions of time is concave, so its ends bound it. The plane stays with b, then with a.
  const double with_b = std::min(least_of_triangle(n, a, of_a, h), least_of_triangle(n, a, of_a, -h)) - highest(n, b) - of_a.loss;
  const double with_a = std::min(least_of_triangle(-n, b, of_b, h), least_of_triangle(-n, b, of_b, -h)) - highest(-n, a) - of_b.loss;
  return std::max(with_b, with_a);
}

}  // namespace

PairProof::PairProof(const BoxTree& a, const BoxTree& b, const RelativeMotion& motion, const CertificateOptions& options)
    : a_(a), b_(b), motion_(motion), options_(options), nearest_(1e300) {}

/// Proves both halves of a span.
template <class Prove>
bool PairProof::in_halves(Span& span, Prove&& prove) {
  if (span.halves < 0 && kept_.size() < kKept) {
    span.halves = int(kept_.size());
    kept_.push_back(cut(span));
  }
  if (span.halves >= 0) {
    auto& [first, second] = kept_[std::size_t(span.halves)];
    return prove(first) && prove(second);
  }
  auto [first, second] = cut(span);
  return prove(first) && prove(second);
}

bool PairProof::settle(double bound) {
  if (bound < wanted()) return false;
  lowest_ = std::min(lowest_, bound);
  return true;
}

bool PairProof::count_step(const Span& span) {
  if (++steps_ <= options_.steps) return true;
  nearest_time_ = span.middle();
  return false;
}

bool PairProof::run() {
  return go_through(span_of(0, 1)) && touches_.empty();
}

void PairProof::add_touch(const Span& span, double distance, const Vector3d& on_a, const Vector3d& on_b) {
  const Instant& now = span.now;
  const Touch touch{span.middle(), distance, now.turn.transpose() * (on_a - now.shift), on_b};
  for (Touch& known : touches_)
    if ((known.on_a - touch.on_a).norm() < kOnePlace) {
      if (distance < known.distance) known = touch;
      return;
    }
  touches_.push_back(touch);
}

bool PairProof::go_through(Span span) {
  const BoxNode &a = a_.nodes[0], &b = b_.nodes[0];
  const double speed = std::min(motion_.of_a(a.centre, a.radius).speed, motion_.of_b(b.centre, b.radius).speed);
  const double h = span.half();
  const double apart = (span.now.turn * a.centre + span.now.shift - b.centre).norm() - a.radius - b.radius;
  const double bound = apart - speed * h - kRounding;
  if (bound >= options_.enough) {
    rows_.push_back({span.t0, span.t1, bound});
    return true;
  }
  if (motion_.moves() && 2 * speed * h > kRowTravel) {
    const auto [first, second] = cut(span);
    return go_through(first) && go_through(second);
  }
  lowest_ = 1e300;
  kept_.clear();
  if (!boxes(0, 0, span)) return false;
  rows_.push_back({span.t0, span.t1, lowest_});
  return true;
}

bool PairProof::boxes(int ia, int ib, Span& span) {
  if (!count_step(span)) return false;
  const BoxNode &a = a_.nodes[ia], &b = b_.nodes[ib];
  const Instant& now = span.now;
  const double h = span.half();
  const auto reach_a = motion_.of_a(a.centre, a.radius), reach_b = motion_.of_b(b.centre, b.radius);
  const double travel = std::min(reach_a.speed, reach_b.speed) * h;
  const Vector3d centre = now.turn * a.centre + now.shift, between = centre - b.centre;
  const double apart = between.norm() - a.radius - b.radius - kRounding;
  if (settle(apart - travel)) return true;
  const Matrix3d axes = now.turn * a.axes, angles = axes.transpose() * b.axes;
  // How far apart the boxes are along each of A's and B's axes at the middle: at no other time of the span is more proved there.
  const Vector3d along_a = axes.transpose() * between, along_b = b.axes.transpose() * between;
  double gaps[6];
  Eigen::Map<Vector3d>(gaps).noalias() = along_a.cwiseAbs() - a.half - angles.cwiseAbs() * b.half;
  Eigen::Map<Vector3d>(gaps + 3).noalias() = along_b.cwiseAbs() - b.half - angles.cwiseAbs().transpose() * a.half;
  const double still = std::max(apart, *std::max_element(gaps, gaps + 6));
  for (double* best; *(best = std::max_element(gaps, gaps + 6)) >= wanted(); *best = -1) {
    const int k = int(best - gaps) % 3;
    if (best < gaps + 3) {
      const Vector3d n = (along_a[k] < 0 ? 1 : -1) * axes.col(k);
      const Drift of_b{-now.spin, -now.drift, 0.5 * reach_b.acceleration * h * h + kRounding};
      const LeastOfBox least(n, b.centre, b.axes, b.half, of_b);
      if (settle(std::min(least(h), least(-h)) - n.dot(centre) - a.half[k] - of_b.loss)) return true;
    } else {
      const Vector3d n = (along_b[k] < 0 ? -1 : 1) * b.axes.col(k);
      const Drift of_a{now.spin, now.drift, 0.5 * reach_a.acceleration * h * h + kRounding};
      const LeastOfBox least(n, centre, axes, a.half, of_a);
      if (settle(std::min(least(h), least(-h)) - n.dot(b.centre) - b.half[k] - of_a.loss)) return true;
    }
  }
  if (travel > 0 && (still - kRounding >= wanted() || travel > kBalance * std::max(a.radius, b.radius)))
    return in_halves(span, [&](Span& half) { return boxes(ia, ib, half); });
  return a.leaf() && b.leaf() ? leaves(a, b, span) : children(a, b, ia, ib, span);
}

bool PairProof::children(const BoxNode& a, const BoxNode& b, int ia, int ib, Span& span) {
  const bool split_a = !a.leaf() && (b.leaf() || a.radius >= b.radius);
  const int first = split_a ? a.children : b.children;
  const Instant& now = span.now;
  const auto apart = [&](int child) {
    const BoxNode &p = split_a ? a_.nodes[child] : a, &q = split_a ? b : b_.nodes[child];
    return (now.turn * p.centre + now.shift - q.centre).norm() - p.radius - q.radius;
  };
  // The nearer first: it may show that the rest need not be proved to the same gap.
  const int swap = apart(first) <= apart(first + 1) ? 0 : 1;
  for (const int child : {first + swap, first + 1 - swap})
    if (!(split_a ? boxes(child, ib, span) : boxes(ia, child, span))) return false;
  return true;
}

bool PairProof::leaves(const BoxNode& a, const BoxNode& b, Span& span) {
  for (int n = a.first; n < a.first + a.count; ++n) {
    const Instant& now = span.now;
    Triangle moved;
    for (int k = 0; k < 3; ++k) moved[k] = now.turn * a_.triangles[n][k] + now.shift;
    for (int m = b.first; m < b.first + b.count; ++m)
      if (!triangles(moved, a_.triangles[n], b_.triangles[m], span)) return false;
  }
  return true;
}

bool PairProof::triangles(const Triangle& moved, const Triangle& a, const Triangle& b, Span& span) {
  if (!count_step(span)) return false;
  const Instant& now = span.now;
  const double h = span.half();
  const auto arm = [](const Triangle& t) { return (t[0] + t[1] + t[2]) / 3; };
  const auto radius = [&](const Triangle& t, const Vector3d& c) { return std::max({(t[0] - c).norm(), (t[1] - c).norm(), (t[2] - c).norm()}); };
  const Vector3d centre_a = arm(a), centre_b = arm(b), between = arm(moved) - centre_b;
  const double radius_a = radius(a, centre_a), radius_b = radius(b, centre_b);
  const auto reach_a = motion_.of_a(centre_a, radius_a), reach_b = motion_.of_b(centre_b, radius_b);
  if (settle(between.norm() - radius_a - radius_b - std::min(reach_a.speed, reach_b.speed) * h - kRounding)) return true;
  const Drift of_a{now.spin, now.drift, 0.5 * reach_a.acceleration * h * h + kRounding};
  const Drift of_b{-now.spin, -now.drift, 0.5 * reach_b.acceleration * h * h + kRounding};
  for (const Triangle* face : {&b, &moved}) {
    const Vector3d across = ((*face)[1] - (*face)[0]).cross((*face)[2] - (*face)[0]);
    const double length = across.norm();
    if (!(length > 0)) continue;
    const Vector3d n = across / (between.dot(across) < 0 ? -length : length);
    if (settle(triangle_gap(n, moved, b, of_a, of_b, h))) return true;
  }
  const Nearest found = nearest(moved, b);
  if (found.distance < nearest_) {
    nearest_ = found.distance;
    nearest_time_ = span.middle();
  }
  if (found.distance < options_.least) {
    add_touch(span, found.distance, found.on_a, found.on_b);
    return options_.to_the_end && touches_.size() < kMostTouches;  // what is beyond it may still be proved, or touch, too
  }
  if (settle(triangle_gap((found.on_a - found.on_b) / found.distance, moved, b, of_a, of_b, h))) return true;
  if (!motion_.moves() || h < kShortest) {
    nearest_time_ = span.middle();
    return false;
  }
  return in_halves(span, [&](Span& half) {
    Triangle next;
    for (int k = 0; k < 3; ++k) next[k] = half.now.turn * a[k] + half.now.shift;
    return triangles(next, a, b, half);
  });
}

}  // namespace transformables::finishing
