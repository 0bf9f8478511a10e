#include "finishing/certificate.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "finishing/pair_proof.h"
#include "finishing/relative_motion.h"
#include "finishing/solids.h"

namespace transformables {

using namespace finishing;

namespace {

constexpr double kRelativeRounding = 1e-6;
constexpr std::size_t kTasksAtOnce = 400;   ///< between two looks at whether to go on: a second or two

void demand(bool holds, const std::string& text) {
  if (!holds) throw InvalidInput("certificate: " + text);
}

void check_options(const CertificateOptions& o) {
  demand(std::isfinite(o.least) && o.least > 1e-8, "the distance that counts as touching must be over 1e-8");
  demand(std::isfinite(o.enough) && o.enough > o.least, "the distance that is enough must be over the one that counts as touching");
  demand(o.tolerance > 0 && o.tolerance < 1, "the tolerance must lie between 0 and 1");
  demand(o.steps > 0, "the number of steps must be positive");
  demand(o.threads >= 0, "threads must be 0 (all cores) or more");
}

void check_parts(const std::vector<Part>& parts, const Character& character) {
  std::vector<char> seen(character.bones.size(), 0);
  for (const Part& part : parts) {
    const std::string who = "the part of bone " + std::to_string(part.bone) + " ";
    demand(part.bone >= 0 && part.bone < int(character.bones.size()), who + "is not the character's; finish this character again");
    demand(!seen[part.bone], who + "is there twice; join them");
    seen[part.bone] = 1;
    demand(!part.mesh.empty(), who + "has no triangles; leave it out");
    for (const auto& v : part.mesh.vertices) demand(v.allFinite(), who + "has a vertex that is not finite");
    for (const auto& t : part.mesh.triangles)
      demand(t.minCoeff() >= 0 && t.maxCoeff() < int(part.mesh.vertices.size()), who + "has a triangle with a corner that does not exist");
  }
}

/// All angles before each move, and after the last. @throws InvalidInput when a move does not start where its hinges stand
std::vector<Eigen::VectorXd> angles_along(const FoldPath& path, const Embedding& embedding) {
  std::vector<Eigen::VectorXd> all{embedding.pose.angles};
  constexpr double kSame = 1e-6;
  for (const Move& move : path.moves) {
    Eigen::VectorXd now = all.back();
    std::vector<char> turned(std::size_t(now.size()), 0);
    for (const Move::Turn& turn : move.turns) {
      demand(turn.angle >= 0 && turn.angle < now.size(), "the path turns a hinge that the character does not have; plan again");
      demand(!turned[turn.angle], "a move of the path turns a hinge twice; make two moves of it");
      turned[turn.angle] = 1;
      demand(std::isfinite(turn.from_rad) && std::isfinite(turn.to_rad) && std::abs(turn.from_rad - now[turn.angle]) < kSame,
             "a move of the path does not start where the hinge stands; plan again");
      now[turn.angle] = turn.to_rad;
    }
    all.push_back(now);
  }
  return all;
}

/// Which pairs are wanted.
class Wanted {
 public:
  explicit Wanted(const std::vector<std::pair<int, int>>& pairs) : pairs_(pairs) { std::sort(pairs_.begin(), pairs_.end()); }
  bool pair(int a, int b) const { return pairs_.empty() || std::binary_search(pairs_.begin(), pairs_.end(), std::pair(a, b)); }
  bool part(int bone) const {
    return pairs_.empty() || std::any_of(pairs_.begin(), pairs_.end(), [&](const auto& p) { return p.first == bone || p.second == bone; });
  }

 private:
  std::vector<std::pair<int, int>> pairs_;
};

/// What is to be proved: a pair in a move.
struct Task {
  const Solid *a, *b;
  RelativeMotion motion;
  std::size_t move;   ///< in the first no part may hold another; later none could without touching it
};
struct Outcome {
  std::vector<CertifiedInterval> rows;
  std::vector<Uncertified> open;
  long steps = 0;
};

/// Rows over the same time, each with the lower of two bounds.
std::vector<CertifiedInterval> lower_of(const std::vector<CertifiedInterval>& first, const std::vector<CertifiedInterval>& second) {
  std::vector<CertifiedInterval> rows;
  for (std::size_t i = 0, j = 0; i < first.size() && j < second.size();) {
    CertifiedInterval row = first[i];
    row.t0 = rows.empty() ? 0 : rows.back().t1;
    row.t1 = std::min(first[i].t1, second[j].t1);
    row.bound = std::min(first[i].bound, second[j].bound);
    if (row.t1 > row.t0) rows.push_back(row);
    const double end = row.t1;
    i += first[i].t1 <= end;
    j += second[j].t1 <= end;
  }
  return rows;
}

/// Proves two sets of triangles apart, and adds what comes of it to an outcome.
void prove_between(const BoxTree& a, const BoxTree& b, const Task& task, const CertificateOptions& options, Outcome& outcome) {
  PairProof proof(a, b, task.motion, options);
  const bool proved = proof.run();
  outcome.steps += proof.steps();
  std::vector<CertifiedInterval> rows;
  for (const auto& row : proof.rows())
    if (row.bound > 0) rows.push_back({task.move, task.a->bone, task.b->bone, row.t0, row.t1, row.bound});
  outcome.rows = outcome.rows.empty() ? std::move(rows) : lower_of(outcome.rows, rows);
  for (const auto& touch : proof.touches())
    outcome.open.push_back({task.move, task.a->bone, task.b->bone, touch.time, touch.distance, Uncertified::Reason::kTouching, touch.on_a, touch.on_b});
  if (!proved && proof.touches().empty())
    outcome.open.push_back({task.move, task.a->bone, task.b->bone, proof.nearest_time(), proof.nearest_distance(), Uncertified::Reason::kUnresolved});
}

/// @param known  what was found out before about triangles that are not fresh; null: nothing
Outcome prove(const Task& task, const CertificateOptions& options, const Outcome* known) {
  const bool all = !known || !known->open.empty();
  const Solid &a = *task.a, &b = *task.b;
  if (!all && !a.fresh && !b.fresh) return {known->rows, {}, 0};
  Outcome outcome;
  if (task.move == 0) {
    const Instant start = task.motion.at(0);
    Eigen::Isometry3d into_b(start.turn);
    into_b.translation() = start.shift;
    if (holds_a_piece(b, a, into_b) || holds_a_piece(a, b, into_b.inverse(Eigen::Isometry))) {
      outcome.open.push_back({task.move, a.bone, b.bone, 0, 0, Uncertified::Reason::kInside});
      return outcome;
    }
  }
  if (all) {
    prove_between(a.tree(), b.tree(), task, options, outcome);
    return outcome;
  }
  outcome.rows = known->rows;
  // More than the rest of the pair has would change nothing.
  CertificateOptions as_much = options;
  double lowest = options.enough;
  for (const auto& row : known->rows) lowest = std::min(lowest, row.bound);
  as_much.enough = std::max(lowest, options.least * (1 + kRelativeRounding));
  if (a.fresh) prove_between(*a.fresh, b.tree(), task, as_much, outcome);
  if (b.fresh) prove_between(a.tree(), *b.fresh, task, as_much, outcome);
  return outcome;
}

/// What is known of pairs already, by move and bones.
using Known = std::map<std::tuple<std::size_t, int, int>, Outcome>;

/// Adds the pairs to look at in a move, of those that are wanted: all in the first, those that move against each other in later ones.
void add_tasks(std::vector<Task>& tasks, const std::vector<Solid>& solids, const Character& character, const Embedding& embedding, const Move& move,
               std::size_t number, const Eigen::VectorXd& start, const Wanted& wanted) {
  for (std::size_t i = 0; i < solids.size(); ++i)
    for (std::size_t j = i + 1; j < solids.size(); ++j) {
      if (!wanted.pair(solids[i].bone, solids[j].bone)) continue;
      RelativeMotion motion(character, embedding.morphology, move, start, solids[i].bone, solids[j].bone);
      if (number == 0 || motion.moves()) tasks.push_back({&solids[i], &solids[j], std::move(motion), number});
    }
}

/// A certificate of what was found out, in order.
Certificate written(const Known& known, double enough) {
  Certificate certificate;
  for (const auto& [pair, outcome] : known) {
    certificate.intervals.insert(certificate.intervals.end(), outcome.rows.begin(), outcome.rows.end());
    certificate.open.insert(certificate.open.end(), outcome.open.begin(), outcome.open.end());
    certificate.steps += outcome.steps;
  }
  certificate.holds = certificate.open.empty();
  if (certificate.holds) {
    certificate.gap = 1e300;
    for (const auto& row : certificate.intervals) certificate.gap = std::min(certificate.gap, row.bound);
    if (certificate.intervals.empty()) certificate.gap = enough;
  }
  return certificate;
}

}  // namespace

/// What a prover knows, and of what.
class Prover::Memory {
 public:
  Memory(const Character& character, const Embedding& embedding, const FoldPath& path, const CertificateOptions& options,
         std::shared_ptr<const ReadyParts> ready)
      : character_(character), embedding_(embedding), path_(path), options_(options), wanted_(options.pairs),
        ready_(ready ? std::move(ready) : std::make_shared<const ReadyParts>()) {
    check_options(options);
    demand(embedding.pose.angles.size() == character.angle_count && embedding.pose.angles.allFinite() &&
               embedding.morphology.size() == Eigen::Index(character.bones.size()) && embedding.morphology.allFinite(),
           "the embedding was not made for this character; embed again");
    angles_ = angles_along(path, embedding);
  }

  Certificate certify(const std::vector<Part>& parts, const Progress& progress) {
    check_parts(parts, character_);
    tbb::task_arena arena(options_.threads > 0 ? options_.threads : int(tbb::task_arena::automatic));
    bool finished = false;
    arena.execute([&] { finished = find_out(parts, progress); });
    progress(1, "parts are proved");
    return finished ? written(known_, options_.enough) : Certificate{};
  }
  const std::shared_ptr<const ReadyParts>& ready() const { return ready_; }

 private:
  /// @return false when a proof failed, and not all are wanted
  bool find_out(const std::vector<Part>& parts, const Progress& progress) {
    std::vector<const Part*> chosen;
    for (const Part& part : parts)
      if (wanted_.part(part.bone)) chosen.push_back(&part);
    const std::vector<Solid> solids = solids_of(chosen, *ready_, !known_.empty());
    std::vector<Task> tasks;
    for (std::size_t m = 0; m < std::max<std::size_t>(1, path_.moves.size()); ++m)
      add_tasks(tasks, solids, character_, embedding_, m < path_.moves.size() ? path_.moves[m] : Move{}, m, angles_[m], wanted_);
    std::vector<Outcome> outcomes(tasks.size());
    std::atomic<bool> given_up = false;
    for (std::size_t done = 0; done < tasks.size() && !given_up; done += kTasksAtOnce) {
      progress(double(done) / double(tasks.size()), "proving that parts stay apart");
      const tbb::blocked_range<std::size_t> some(done, std::min(done + kTasksAtOnce, tasks.size()), 1);
      tbb::parallel_for(some, [&](const auto& range) {
        for (std::size_t n = range.begin(); n != range.end() && !given_up; ++n) {
          const auto known = known_.find(key_of(tasks[n]));
          outcomes[n] = prove(tasks[n], options_, known == known_.end() ? nullptr : &known->second);
          if (!options_.to_the_end && !outcomes[n].open.empty()) given_up = true;
        }
      });
    }
    known_.clear();
    for (std::size_t n = 0; n < tasks.size() && !given_up; ++n) known_.emplace_hint(known_.end(), key_of(tasks[n]), std::move(outcomes[n]));
    auto ready = std::make_shared<ReadyParts>();
    for (const Solid& solid : solids) ready->of[solid.bone] = solid.part;
    ready_ = std::move(ready);
    return !given_up;
  }
  static Known::key_type key_of(const Task& task) { return {task.move, task.a->bone, task.b->bone}; }

  const Character& character_;
  const Embedding& embedding_;
  const FoldPath& path_;
  const CertificateOptions options_;
  const Wanted wanted_;
  std::vector<Eigen::VectorXd> angles_;
  std::shared_ptr<const ReadyParts> ready_;   // those of the last certificate
  Known known_;                               // the same
};

Prover::Prover(const Character& character, const Embedding& embedding, const FoldPath& path, const CertificateOptions& options,
               std::shared_ptr<const ReadyParts> ready)
    : memory_(std::make_unique<Memory>(character, embedding, path, options, std::move(ready))) {}

Prover::~Prover() = default;

Certificate Prover::certify(const std::vector<Part>& parts, const Progress& progress) { return memory_->certify(parts, progress); }

std::shared_ptr<const ReadyParts> Prover::ready() const { return memory_->ready(); }

Certificate certify(const std::vector<Part>& parts, const Character& character, const Embedding& embedding, const FoldPath& path,
                    const CertificateOptions& options, const Progress& progress) {
  return Prover(character, embedding, path, options).certify(parts, progress);
}

}  // namespace transformables
