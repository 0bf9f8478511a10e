#include "character/mirror.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

namespace transformables {
namespace {

constexpr double kPlaceTolerance = 1e-3;  // of the character's size
constexpr double kAxisTolerance = 1e-4;   // one minus the cosine: 0.8 degrees
constexpr double kAngleTolerance = 2e-3;  // radians, of limits

/// A bone as it stands at rest, in the character frame.
struct Placed {
  Eigen::Vector3d head;
  std::vector<Segment> segments;
  std::vector<Eigen::Vector3d> axes;  ///< of its hinges
};

std::vector<Placed> place(const Character& character) {
  const Morphology ones = Morphology::Ones(character.bones.size());
  const auto frames = forward_kinematics(character, rest_pose(character, character.root_rest), ones);
  std::vector<Placed> placed(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    placed[i].head = frames[i].translation();
    for (const Segment& s : character.bones[i].segments) placed[i].segments.push_back(transformed(frames[i], s));
    for (const Hinge& h : character.bones[i].hinges) placed[i].axes.push_back(frames[i].linear().col(h.axis));
  }
  return placed;
}

class Matcher {
 public:
  Matcher(const Character& character, double size)
      : bones_(character.bones), placed_(place(character)), children_(bones_.size()),
        plane_x_(character.mirror_x), tolerance_(kPlaceTolerance * size) {
    for (int i = 1; i < int(bones_.size()); ++i) children_[bones_[i].parent].push_back(i);
  }

  /// For each hinge of bone i, the sign of its angle in bone j, its mirror image; nothing when j is not.
  std::optional<std::vector<double>> signs(int i, int j) const {
    if (!same(reflected(placed_[i].head), placed_[j].head) || !same_segments(i, j)) return std::nullopt;
    if (bones_[i].hinges.size() != bones_[j].hinges.size()) return std::nullopt;
    std::vector<double> result;
    for (std::size_t k = 0; k < bones_[i].hinges.size(); ++k) {
      const double sign = hinge_sign(i, j, k);
      if (sign == 0) return std::nullopt;
      result.push_back(sign);
    }
    return result;
  }

  /// Whether all of bone i's subtree has its image in that of bone j.
  bool subtrees_match(int i, int j) {
    const auto known = known_.find({i, j});
    if (known != known_.end()) return known->second;
    const bool match = signs(i, j).has_value() && children_match(i, j);
    return known_[{i, j}] = match;
  }

  /// The image of bone i among the children of `parent` that are not taken; -1 when there is none.
  int best_image(int i, int parent, const std::vector<int>& taken) {
    int best = -1, best_rank = 0;
    const std::string wanted = name_of_other_side(bones_[i].name);
    for (const int j : children_[parent]) {
      if (taken[j] >= 0 || !signs(i, j)) continue;
      // Names decide only between bones that geometry allows: a limb mirrored as a whole comes first.
      const int rank = 1 + 4 * subtrees_match(i, j) + 2 * (bones_[j].name == wanted) + (i == j);
      if (rank > best_rank) best = j, best_rank = rank;
    }
    return best;
  }

 private:
  Eigen::Vector3d reflected(const Eigen::Vector3d& p) const { return {2 * plane_x_ - p.x(), p.y(), p.z()}; }
  bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const { return (a - b).norm() <= tolerance_; }

  bool same_segments(int i, int j) const {
    const auto& from = placed_[i].segments;
    const auto& to = placed_[j].segments;
    if (from.size() != to.size()) return false;
    std::vector<char> used(to.size(), 0);
    for (const Segment& s : from) {
      std::size_t k = 0;
      while (k < to.size() && (used[k] || !same(reflected(s.a), to[k].a) || !same(reflected(s.b), to[k].b))) ++k;
      if (k == to.size()) return false;
      used[k] = 1;
    }
    return true;
  }

  /// A reflection turns "about a by t" into "about -(a - 2 (a.n) n) by t": axes are pseudo-vectors. 0: no image.
  double hinge_sign(int i, int j, std::size_t k) const {
    const Eigen::Vector3d& a = placed_[i].axes[k];
    const double cosine = Eigen::Vector3d(a.x(), -a.y(), -a.z()).dot(placed_[j].axes[k]);
    if (std::abs(cosine) < 1 - kAxisTolerance) return 0;
    const Hinge& from = bones_[i].hinges[k];
    const Hinge& to = bones_[j].hinges[k];
    const double low = cosine > 0 ? from.min_rad : -from.max_rad;
    const double high = cosine > 0 ? from.max_rad : -from.min_rad;
    if (std::abs(low - to.min_rad) > kAngleTolerance || std::abs(high - to.max_rad) > kAngleTolerance) return 0;
    return cosine > 0 ? 1 : -1;
  }

  bool children_match(int i, int j) {
    if (children_[i].size() != children_[j].size()) return false;
    std::vector<char> used(children_[j].size(), 0);
    for (const int child : children_[i]) {
      std::size_t k = 0;
      while (k < used.size() && (used[k] || !subtrees_match(child, children_[j][k]))) ++k;
      if (k == used.size()) return false;
      used[k] = 1;
    }
    return true;
  }

  const std::vector<Bone>& bones_;
  std::vector<Placed> placed_;
  std::vector<std::vector<int>> children_;
  double plane_x_, tolerance_;
  std::map<std::pair<int, int>, bool> known_;
};

std::vector<int> images(const Character& character, Matcher& matcher) {
  std::vector<int> mirror(character.bones.size(), -1);
  if (!matcher.signs(0, 0)) return mirror;
  mirror[0] = 0;
  for (int i = 1; i < int(mirror.size()); ++i) {
    const int parent_image = mirror[character.bones[i].parent];
    if (mirror[i] >= 0 || parent_image < 0) continue;
    const int j = matcher.best_image(i, parent_image, mirror);
    if (j >= 0) mirror[i] = j, mirror[j] = i;
  }
  return mirror;
}

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kSides{
    {{"l", "r"}, {"L", "R"}, {"left", "right"}, {"Left", "Right"}, {"LEFT", "RIGHT"}}};

std::string other_word(const std::string& word) {
  for (const auto& [l, r] : kSides)
    for (const auto& [from, to] : {std::pair{l, r}, std::pair{r, l}}) {
      if (word == from) return std::string(to);
      if (from.size() == 1 || word.size() <= from.size()) continue;
      if (word.compare(0, from.size(), from) == 0) return std::string(to) + word.substr(from.size());
      const std::size_t at = word.size() - from.size();
      if (word.compare(at, from.size(), from) == 0) return word.substr(0, at) + std::string(to);
    }
  return word;
}

}  // namespace

std::string name_of_other_side(const std::string& name) {
  constexpr std::string_view kSeparators = "._- :";
  for (std::size_t start = 0; start < name.size();) {
    const std::size_t found = name.find_first_of(kSeparators, start);
    const std::size_t end = found == std::string::npos ? name.size() : found;
    const std::string word = name.substr(start, end - start), other = other_word(word);
    if (other != word) return name.substr(0, start) + other + name.substr(end);
    start = end + 1;
  }
  return name;
}

void find_mirror(Character& character, double size) {
  Matcher matcher(character, size);
  const std::vector<int> mirror = images(character, matcher);
  character.mirrored = true;
  for (std::size_t i = 0; i < mirror.size(); ++i) {
    character.bones[i].mirror = mirror[i];
    character.mirrored = character.mirrored && mirror[i] >= 0;
  }
  if (!character.mirrored) return;
  character.mirror_angle.resize(character.angle_count);
  character.mirror_sign.resize(character.angle_count);
  for (int i = 0; i < int(mirror.size()); ++i) {
    const std::vector<double> signs = *matcher.signs(i, mirror[i]);
    for (std::size_t k = 0; k < signs.size(); ++k) {
      const int to = character.bones[mirror[i]].first_angle + int(k);
      character.mirror_angle[to] = character.bones[i].first_angle + int(k);
      character.mirror_sign[to] = signs[k];
    }
  }
}

}  // namespace transformables
