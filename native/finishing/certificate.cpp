#include "finishing/certificate.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <string>
#include <tuple>

#include "finishing/box_tree.h"
#include "finishing/pair_proof.h"
#include "finishing/relative_motion.h"

namespace transformables {
namespace {

using namespace finishing;

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

/// How often a closed mesh winds around a point that is not on it (van Oosterom and Strackee 1983).
double winding(const BoxTree& tree, const Eigen::Vector3d& p) {
  double sum = 0;
  for (const Triangle& t : tree.triangles) {
    const Eigen::Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

/// A point of each connected piece of a mesh.
std::vector<Eigen::Vector3d> piece_points(const TriangleMesh& mesh) {
  std::vector<int> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) root[find(t[k])] = find(t[0]);
  std::vector<Eigen::Vector3d> points;
  std::vector<char> seen(root.size(), 0);
  for (const auto& t : mesh.triangles) {
    char& flag = seen[find(t[0])];
    if (!flag) points.push_back(mesh.vertices[t[0]]);
    flag = 1;
  }
  return points;
}

/// A part ready to be compared.
struct Solid {
  int bone = 0;
  BoxTree tree;
  std::vector<Eigen::Vector3d> points;
};

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

std::vector<Solid> solids_of(const std::vector<Part>& parts, const Wanted& wanted) {
  std::vector<const Part*> chosen;
  for (const Part& part : parts)
    if (wanted.part(part.bone)) chosen.push_back(&part);
  std::vector<Solid> solids(chosen.size());
  tbb::parallel_for(std::size_t(0), solids.size(), [&](std::size_t n) {
    solids[n] = {chosen[n]->bone, box_tree(chosen[n]->mesh), piece_points(chosen[n]->mesh)};
  });
  std::sort(solids.begin(), solids.end(), [](const Solid& a, const Solid& b) { return a.bone < b.bone; });
  return solids;
}

/// Whether a piece of one lies within the other; `into_b` takes A's frame to B's.
bool holds_a_piece(const Solid& b, const Solid& a, const Eigen::Isometry3d& into_b) {
  const BoxNode& box = b.tree.nodes[0];
  return std::any_of(a.points.begin(), a.points.end(), [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d p = into_b * point;
    return (p - box.centre).norm() <= box.radius && std::abs(winding(b.tree, p)) > 0.5;
  });
}

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

Outcome prove(const Task& task, const CertificateOptions& options) {
  Outcome outcome;
  const std::size_t move = task.move;
  const int a = task.a->bone, b = task.b->bone;
  if (move == 0) {
    const Instant start = task.motion.at(0);
    Eigen::Isometry3d into_b(start.turn);
    into_b.translation() = start.shift;
    if (holds_a_piece(*task.b, *task.a, into_b) || holds_a_piece(*task.a, *task.b, into_b.inverse(Eigen::Isometry))) {
      outcome.open.push_back({move, a, b, 0, 0, Uncertified::Reason::kInside});
      return outcome;
    }
  }
  PairProof proof(task.a->tree, task.b->tree, task.motion, options);
  const bool proved = proof.run();
  outcome.steps = proof.steps();
  for (const auto& row : proof.rows())
    if (row.bound > 0) outcome.rows.push_back({move, a, b, row.t0, row.t1, row.bound});
  for (const auto& touch : proof.touches())
    outcome.open.push_back({move, a, b, touch.time, touch.distance, Uncertified::Reason::kTouching, touch.on_a, touch.on_b});
  if (!proved && outcome.open.empty())
    outcome.open.push_back({move, a, b, proof.nearest_time(), proof.nearest_distance(), Uncertified::Reason::kUnresolved});
  return outcome;
}

/// What is known of pairs already, in the order of a certificate's lists.
class Known {
 public:
  Known() = default;
  Known(const Certificate& before, const std::vector<char>& changed) : changed_(&changed) {
    for (const auto& row : before.intervals) outcomes_[{row.move, row.bone_a, row.bone_b}].rows.push_back(row);
    for (const auto& place : before.open) outcomes_[{place.move, place.bone_a, place.bone_b}].open.push_back(place);
  }
  /// Null when the pair must be looked at.
  const Outcome* of(std::size_t move, int a, int b) const {
    if (!changed_ || (*changed_)[a] || (*changed_)[b]) return nullptr;
    const auto found = outcomes_.find({move, a, b});
    return found == outcomes_.end() ? nullptr : &found->second;
  }

 private:
  const std::vector<char>* changed_ = nullptr;
  std::map<std::tuple<std::size_t, int, int>, Outcome> outcomes_;
};

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

Certificate certify_here(const std::vector<Part>& parts, const Character& character, const Embedding& embedding, const FoldPath& path,
                         const std::vector<Eigen::VectorXd>& angles, const CertificateOptions& options, const Known& known, const Progress& progress) {
  const Wanted wanted(options.pairs);
  const std::vector<Solid> solids = solids_of(parts, wanted);
  Certificate certificate;
  std::vector<Task> tasks;
  for (std::size_t m = 0; m < std::max<std::size_t>(1, path.moves.size()); ++m)
    add_tasks(tasks, solids, character, embedding, m < path.moves.size() ? path.moves[m] : Move{}, m, angles[m], wanted);
  std::vector<Outcome> outcomes(tasks.size());
  for (std::size_t done = 0; done < tasks.size(); done += kTasksAtOnce) {
    progress(double(done) / double(tasks.size()), "proving that parts stay apart");
    const tbb::blocked_range<std::size_t> some(done, std::min(done + kTasksAtOnce, tasks.size()), 1);
    tbb::parallel_for(some, [&](const auto& range) {
      for (std::size_t n = range.begin(); n != range.end(); ++n) {
        const Outcome* before = known.of(tasks[n].move, tasks[n].a->bone, tasks[n].b->bone);
        outcomes[n] = before ? *before : prove(tasks[n], options);
      }
    });
  }
  for (const Outcome& outcome : outcomes) {
    certificate.intervals.insert(certificate.intervals.end(), outcome.rows.begin(), outcome.rows.end());
    certificate.open.insert(certificate.open.end(), outcome.open.begin(), outcome.open.end());
    certificate.steps += outcome.steps;
  }
  certificate.holds = certificate.open.empty();
  if (certificate.holds) {
    certificate.gap = 1e300;
    for (const auto& row : certificate.intervals) certificate.gap = std::min(certificate.gap, row.bound);
    if (certificate.intervals.empty()) certificate.gap = options.enough;
  }
  progress(1, "parts are proved");
  return certificate;
}

Certificate certify_checked(const std::vector<Part>& parts, const Character& character, const Embedding& embedding, const FoldPath& path,
                            const CertificateOptions& options, const Known& known, const Progress& progress) {
  check_options(options);
  demand(embedding.pose.angles.size() == character.angle_count && embedding.pose.angles.allFinite() &&
             embedding.morphology.size() == Eigen::Index(character.bones.size()) && embedding.morphology.allFinite(),
         "the embedding was not made for this character; embed again");
  check_parts(parts, character);
  const std::vector<Eigen::VectorXd> angles = angles_along(path, embedding);
  tbb::task_arena arena(options.threads > 0 ? options.threads : int(tbb::task_arena::automatic));
  Certificate certificate;
  arena.execute([&] { certificate = certify_here(parts, character, embedding, path, angles, options, known, progress); });
  return certificate;
}

}  // namespace

Certificate certify(const std::vector<Part>& parts, const Character& character, const Embedding& embedding, const FoldPath& path,
                    const CertificateOptions& options, const Progress& progress) {
  return certify_checked(parts, character, embedding, path, options, {}, progress);
}

Certificate certify_again(const Certificate& before, const std::vector<char>& changed, const std::vector<Part>& parts, const Character& character,
                          const Embedding& embedding, const FoldPath& path, const CertificateOptions& options, const Progress& progress) {
  demand(changed.size() == character.bones.size(), "there must be a flag for each bone that says whether its part was changed");
  return certify_checked(parts, character, embedding, path, options, Known(before, changed), progress);
}

}  // namespace transformables
