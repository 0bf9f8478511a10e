// Production's greedy order against the paper to the letter (tests/reference/folding.h).
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "folding/cases.h"
#include "folding/costs.h"
#include "reference/cases.h"
#include "reference/folding.h"

namespace transformables {
namespace {

struct Case {
  std::string name;
  Made design;
};

Made grown(Target target, const std::function<Character(const Target&)>& character) {
  Made m;
  m.target = std::move(target);
  m.character = character(m.target);
  m.embedding = reference::folded(m.character, m.target, 1, 800);
  m.segmentation = grow(m.character, m.target, m.embedding, {}, {});
  return m;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> made{{"two boxes", two_boxes(-kQuarter)}, {"a lid over a board", lidded(-kQuarter)}, {"doors", doors()},
                                      {"a slab in the way", slab_in_the_way()}, {"snake in a U", grown(reference::u_shape(20), reference::snake)},
                                      {"spider in a ball", grown(reference::ball(16), reference::spider)}};
  return made;
}

/// The options under which production means what the paper means.
FoldingOptions like_the_letter(const Case& at) {
  FoldingOptions options;
  options.cost = MoveCost::kNetOverlap;
  options.mirrored_together = false;
  options.tolerance_steps = 0;
  options.largest_step_rad = at.design.character.bones.size() > 10 ? 0.2 : 0.1;
  return options;
}

reference::FoldingOrder letter_of(const Case& at) {
  return {at.design.segmentation, at.design.character, at.design.target, at.design.embedding, like_the_letter(at)};
}

/// Distances near edges are not quite the same, so that a cost is known to a few per cent, and to some samples.
double leeway(const Case& at, double cost) { return 0.05 * cost + 5 * std::pow(at.design.segmentation.shape.step, 3); }

TEST(ReferenceFolding, AMoveCostsWhatTheLetterSays) {
  for (const Case& at : cases()) {
    SCOPED_TRACE(at.name);
    const reference::FoldingOrder letter = letter_of(at);
    const FoldingOptions options = like_the_letter(at);
    const folding::Design design{at.design.character, at.design.segmentation, at.design.target, at.design.embedding};
    folding::Costs costs(design, options);
    const folding::State folded(costs.units().size(), std::uint8_t(folding::Unit::kFolded));
    double sum = 0;
    for (std::size_t unit = 0; unit < costs.units().size(); ++unit) {
      if (!costs.units()[unit].must_open) continue;
      const folding::Edge edge{folded, {int(unit), folding::Unit::kOpen}};
      const double expected = letter.cost(at.design.embedding.pose.angles, costs.move(edge));
      const double ours = costs.of({edge})[0] * design.sample_volume();
      EXPECT_NEAR(ours, expected, leeway(at, expected)) << "joint " << unit;
      sum += expected;
    }
    EXPECT_TRUE(sum > 0 || at.name == "doors") << "nothing meets here at all";
  }
}

TEST(ReferenceFolding, EveryJointThatGreedyPicksIsTheOneThatTheLetterPicksOrCostsAsLittle) {
  for (const Case& at : cases()) {
    SCOPED_TRACE(at.name);
    const reference::FoldingOrder letter = letter_of(at);
    const FoldPath path = greedy(at.design, like_the_letter(at)), paper = letter.greedy();
    ASSERT_EQ(path.moves.size(), paper.moves.size());
    Eigen::VectorXd angles = at.design.embedding.pose.angles;
    for (const Move& move : path.moves) {
      double least = letter.cost(angles, move), chosen = least;
      for (int joint = 0; joint < angles.size(); ++joint)
        if (angles[joint] != 0) least = std::min(least, letter.cost(angles, {{{joint, angles[joint], 0}}}));
      EXPECT_LE(chosen, least + leeway(at, least)) << "joint " << move.turns[0].angle;
      angles = reference::angles_within(move, angles, 1);
    }
    EXPECT_EQ(angles.norm(), 0);
  }
}

TEST(ReferenceFolding, TheLetterOpensTheLidBeforeTheBoardUnderItAsProductionDoes) {
  const Case at{"a lid over a board", lidded(-kQuarter)};
  const FoldPath path = greedy(at.design, like_the_letter(at)), paper = letter_of(at).greedy();
  ASSERT_EQ(paper.moves.size(), 2u);
  for (std::size_t m = 0; m < 2; ++m) EXPECT_EQ(path.moves[m].turns[0].angle, paper.moves[m].turns[0].angle);
  FoldPath other = paper;
  std::swap(other.moves[0], other.moves[1]);
  const auto costs = letter_of(at).costs(paper), worse = letter_of(at).costs(other);
  EXPECT_LT(costs[0] + costs[1], 0.5 * (worse[0] + worse[1]));
}

TEST(ReferenceFolding, TwoBoxesOverlapByWhatGeometrySays) {
  const Case at{"two boxes", two_boxes(-kQuarter)};
  const auto skins = reference::skins_of(at.design.segmentation, at.design.target);
  const auto open = reference::displacements(at.design.character, at.design.embedding, Eigen::VectorXd::Zero(1));
  // The right box of 0.25 x 0.2 x 0.2 stands upright then, 0.2 x 0.2 x 0.2 of it inside the other.
  EXPECT_NEAR(reference::level_set_collision(skins[1], skins[0], open[0].inverse() * open[1], 0), 0.008, 0.0008);
  EXPECT_EQ(reference::level_set_collision(skins[1], skins[0], Eigen::Isometry3d::Identity(), 0), 0);
}

}  // namespace
}  // namespace transformables
