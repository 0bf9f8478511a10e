// Two parts in one move: the proof that they stay apart, by boxes, triangles and planes over shorter and shorter times.
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "finishing/box_tree.h"
#include "finishing/certificate.h"
#include "finishing/relative_motion.h"

namespace transformables::finishing {

class PairProof {
 public:
  PairProof(const BoxTree& a, const BoxTree& b, const RelativeMotion& motion, const CertificateOptions& options);

  struct Row {
    double t0, t1, bound;
  };
  /// Goes through the whole move, past places where the parts touch. @return whether all of it is proved.
  bool run();
  const std::vector<Row>& rows() const { return rows_; }

  /// A place where the parts touch.
  struct Touch {
    double time, distance;
    Eigen::Vector3d on_a, on_b;   ///< each in its own part's frame
  };
  const std::vector<Touch>& touches() const { return touches_; }
  /// Where the parts were found nearest, or where the steps ran out.
  double nearest_distance() const { return nearest_; }
  double nearest_time() const { return nearest_time_; }
  long steps() const { return steps_; }

 private:
  /// A piece of the move, halved as needed; what it needs at its middle.
  struct Span {
    double t0, t1;
    Instant now;
    int halves = -1;  // index of both, where they are kept
    double middle() const { return 0.5 * (t0 + t1); }
    double half() const { return 0.5 * (t1 - t0); }
  };
  Span span_of(double t0, double t1) const { return {t0, t1, motion_.at(0.5 * (t0 + t1))}; }
  std::array<Span, 2> cut(const Span& span) const { return {span_of(span.t0, span.middle()), span_of(span.middle(), span.t1)}; }
  template <class Prove>
  bool in_halves(Span& span, Prove&& prove);
  /// What must be proved for a pair of boxes or triangles.
  double wanted() const { return std::min(options_.enough, (1 - options_.tolerance) * std::max(nearest_, options_.least)); }
  bool settle(double bound);
  bool count_step(const Span& span);
  void add_touch(const Span& span, double distance, const Eigen::Vector3d& on_a, const Eigen::Vector3d& on_b);

  bool go_through(Span span);
  bool boxes(int a, int b, Span& span);
  bool children(const BoxNode& a, const BoxNode& b, int ia, int ib, Span& span);
  bool leaves(const BoxNode& a, const BoxNode& b, Span& span);
  bool triangles(const Triangle& moved, const Triangle& a, const Triangle& b, Span& span);

  const BoxTree &a_, &b_;
  const RelativeMotion& motion_;
  const CertificateOptions& options_;
  std::deque<std::array<Span, 2>> kept_;   // halves of the row at work, for other boxes that need them
  std::vector<Row> rows_;
  double lowest_ = 0;   // bound of the row at work
  double nearest_;      // of all places looked at: an upper bound of the least distance
  double nearest_time_ = 0;
  std::vector<Touch> touches_;
  long steps_ = 0;
};

}  // namespace transformables::finishing
