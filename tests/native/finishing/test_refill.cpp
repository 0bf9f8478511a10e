#include "finishing/refill.h"

#include <gtest/gtest.h>

#include "finishing/cases.h"

namespace transformables {
namespace {

using namespace finishing;

/// Two halves that are carved for a turn, and then lose a layer more than the turn needs.
struct Bitten {
  Design design = halves();
  Lattice lattice;
  std::vector<PartField> fields;
  std::size_t carved = 0, bitten = 0;   // samples inside

  Bitten() {
    design.turn(0, 0.7);
    lattice = make_lattice(design.target, design.options);
    fields = make_part_fields(design.segmentation, design.character, design.embedding, design.options, lattice);
    std::vector<std::size_t> dropped(fields.size(), 0);
    carve(scene(), fields, dropped, {});
    for (PartField& field : fields) refresh(field);
    carved = inside();
    for (PartField& field : fields) {
      Grid<float> psi = field.psi;
      for (std::size_t n = 0; n < psi.values.size(); ++n) psi[n] = std::max(psi[n], field.away[n].inner + 1.5f * float(lattice.step()));
      for (std::size_t n = 0; n < psi.values.size(); ++n) psi[n] = std::min(psi[n], std::max(field.psi[n], field.core[n]));
      adopt(field, std::move(psi));
      refresh(field);
    }
    bitten = inside();
  }
  Scene scene() const { return {design.character, design.embedding, design.segmentation, design.path, design.options, lattice}; }
  std::size_t inside() const { return inside_count(fields[0].psi) + inside_count(fields[1].psi); }
};

TEST(Refill, WinsBackWhatNothingPassesAndMeetsNothing) {
  Bitten b;
  ASSERT_LT(b.bitten, b.carved);
  refill(b.scene(), b.fields, {});
  EXPECT_GT(double(b.inside() - b.bitten), 0.5 * double(b.carved - b.bitten));
  const Measured after = measure(b.scene(), b.fields, {});
  EXPECT_TRUE(after.collisions.empty());
  EXPECT_GT(after.least_gap, -0.1 * b.lattice.step()) << "distances on samples are of first order; the proof is on the meshes";
}

TEST(Refill, LeavesBonesAloneThatMayNotGrow) {
  Bitten b;
  b.design.segmentation.inhibited = {1, 1};
  refill(b.scene(), b.fields, {});
  EXPECT_EQ(b.inside(), b.bitten);
}

TEST(Refill, GivesNobodyWhatTheArtistGaveToAnother) {
  Bitten b;
  b.design.segmentation.pinned.assign(b.design.segmentation.owner.size(), 1);
  const std::size_t before = inside_count(b.fields[1].psi);
  for (auto& owner : b.design.segmentation.owner) owner = 0;
  refill(b.scene(), b.fields, {});
  EXPECT_EQ(inside_count(b.fields[1].psi), before);
  EXPECT_GT(b.inside(), b.bitten);
}

}  // namespace
}  // namespace transformables
