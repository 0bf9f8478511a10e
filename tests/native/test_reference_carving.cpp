// Production's carving against the paper to the letter (tests/reference/carving.h).
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "finishing/carve.h"
#include "finishing/cases.h"
#include "folding/cases.h"
#include "reference/carving.h"
#include "reference/dense.h"
#include "reference/folding.h"

namespace transformables {
namespace {

using finishing::PartField;

struct Case {
  std::string name;
  Made design;
  Vector3d half;   ///< of the box that the target is
};

std::vector<Case> cases() {
  std::vector<Case> made{{"two boxes", two_boxes(-kQuarter), {0.25, 0.1, 0.1}}, {"a slab in the way", slab_in_the_way(), {0.2, 0.1, 0.1}},
                         {"a lid over a board", lidded(0), {0.2, 0.1, 0.1}}, {"doors", doors(), {0.2, 0.1, 0.1}}};
  for (Case& at : made) at.design.target.mesh = box_mesh(-at.half, at.half);
  return made;
}

/// Both carve the same parts by the same gap.
struct Carved {
  finishing::Lattice lattice;
  reference::Solids before, letter;
  std::vector<PartField> production;
  std::size_t dropped = 0;   ///< samples of pieces that production's carving cut off; the letter leaves them
  FoldPath path;
};

/// What shows is worth twice as much, as in production.
reference::Solids weighed(const std::vector<PartField>& fields, const finishing::Lattice& lattice) {
  const GridShape& shape = lattice.outer.shape;
  reference::Solids solids = reference::dense(fields, shape);
  for (std::size_t v = 0; v < shape.count(); ++v) solids.worth[v] = lattice.outer[v] > -2 * shape.step ? 2 : 1;
  return solids;
}

Carved carved(const Case& at) {
  const Made& m = at.design;
  FinishingOptions options;
  options.refinement = 1;
  Carved c;
  c.path = greedy(m);
  c.lattice = finishing::make_lattice(m.target, options);
  c.production = finishing::make_part_fields(m.segmentation, m.character, m.embedding, options, c.lattice);
  c.before = c.letter = weighed(c.production, c.lattice);
  std::vector<std::size_t> dropped(c.production.size(), 0);
  finishing::carve({m.character, m.embedding, m.segmentation, c.path, options, c.lattice}, c.production, dropped, {});
  for (const std::size_t samples : dropped) c.dropped += samples;
  reference::carve(m.character, m.embedding, c.path, {c.lattice.passing, c.lattice.step() / 8}, c.letter);
  return c;
}

TEST(ReferenceCarving, ProductionLeavesWhatTheLetterLeavesButPiecesThatAreCutOff) {
  std::size_t all_taken = 0;
  for (const Case& at : cases()) {
    SCOPED_TRACE(at.name);
    const Carved c = carved(at);
    const float tolerance = 0.3f * float(c.lattice.step());
    std::size_t too_much = 0, too_little = 0;
    for (std::size_t b = 0; b < c.production.size(); ++b) {
      const PartField& field = c.production[b];
      for (std::size_t n = 0; n < field.psi.values.size(); ++n) {
        const Eigen::Vector3i place = field.corner + field.shape().cell(n);
        const float letter = c.letter.parts[b].at(place);
        all_taken += c.before.parts[b].at(place) < 0 && letter >= 0;
        too_little += field.psi[n] < -tolerance && letter >= 0;
        too_much += field.psi[n] >= 0 && letter < -tolerance;
      }
    }
    EXPECT_EQ(too_little, 0u);
    EXPECT_LE(too_much, c.dropped);
  }
  EXPECT_GT(all_taken, 5000u) << "there is hardly anything to carve";
}

TEST(ReferenceCarving, NothingThatTheLetterLeavesMeetsOnTheWay) {
  for (const Case& at : cases()) {
    SCOPED_TRACE(at.name);
    const Carved c = carved(at);
    Eigen::VectorXd angles = at.design.embedding.pose.angles;
    double before = 0, after = 0;
    for (const Move& move : c.path.moves) {
      for (const auto& moved : reference::configurations(at.design.character, at.design.embedding, move, angles, c.letter, 2 * c.lattice.step()))
        for (const auto& [a, b] : reference::pairs_turned(at.design.character, move)) {
          const Eigen::Isometry3d a_to_b = moved[b].inverse() * moved[a];
          before = std::max(before, reference::level_set_collision(c.before.parts[a], c.before.parts[b], a_to_b, 0));
          after = std::max(after, reference::level_set_collision(c.letter.parts[a], c.letter.parts[b], a_to_b, 0));
        }
      angles = reference::angles_within(move, angles, 1);
    }
    EXPECT_TRUE(before > 0.002 || at.name == "doors") << "nothing meets here at all";
    EXPECT_LE(after, 0.03 * before) << "samples next to corners apart";
  }
}

}  // namespace
}  // namespace transformables
