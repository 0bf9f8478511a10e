// Certificates of parts that a prover has seen before, in whole or in part.
#include <gtest/gtest.h>

#include "certificate_cases.h"

namespace transformables {
namespace {

using Eigen::Vector3d;

/// A prover that has seen a case's parts already, and then those of others.
struct Seen {
  Case c;
  Prover prover{c.character, c.embedding, c.path, c.options};

  explicit Seen(const Case& first) : c(first) { prover.certify(c.parts, {}); }
  Certificate then(const Case& other) { return prover.certify(other.parts, {}); }
};

TEST(Certificate, OfPartsOfWhichSomeWereChangedIsThatOfAllOfThem) {
  const Case touching = fin_and_wall(0.22, 0.2);
  Case c = touching;
  c.parts[0].mesh = box_mesh({0.2, 0.3, -0.05}, {0.24, 0.4, 0.05});
  const Certificate whole = c.certified(), mended = Seen(touching).then(c);
  EXPECT_EQ(mended.holds, whole.holds);
  EXPECT_EQ(mended.gap, whole.gap);
  EXPECT_EQ(mended.intervals.size(), whole.intervals.size());
  EXPECT_FALSE(Seen(c).then(touching).holds) << "what is changed back is looked at again";
  EXPECT_EQ(Seen(c).then(c).steps, 0) << "what was not changed is not";
}

TEST(Certificate, OfPartsWithSomeNewTrianglesComparesTheseOnly) {
  const Case c = fin_and_wall(0.2, 0.2 + 2 * kVoxel);
  const Certificate before = c.certified();
  ASSERT_TRUE(before.holds);
  const auto with_box = [&](const Vector3d& low, const Vector3d& high) {
    Case more = c;
    const TriangleMesh box = box_mesh(low, high);
    TriangleMesh& mesh = more.parts[0].mesh;
    const int first = int(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), box.vertices.begin(), box.vertices.end());
    for (const auto& t : box.triangles) mesh.triangles.push_back(t.array() + first);
    return more;
  };
  const Case far = with_box({0.2, 0.3, -0.05}, {0.24, 0.4, 0.05}), near = with_box({0.1, -0.01, -0.01}, {0.12, 0.01, 0.01});
  const Certificate still = Seen(c).then(far);
  EXPECT_TRUE(still.holds);
  EXPECT_EQ(still.gap, before.gap);
  EXPECT_LT(still.steps, far.certified().steps);
  EXPECT_FALSE(Seen(c).then(near).holds) << "the fin passes through the new box";
  double reached = 0;
  for (const auto& row : still.intervals) {
    EXPECT_EQ(row.t0, reached);
    reached = row.t1;
  }
  EXPECT_EQ(reached, 1);
}

TEST(Certificate, OfAPartThatWasGoneForAWhileIsMadeAnew) {
  const Case c = fin_and_wall(0.22, 0.2);
  Case without = c;
  without.parts.pop_back();
  Seen seen(c);
  EXPECT_TRUE(seen.then(without).holds);
  EXPECT_FALSE(seen.then(c).holds);
}

TEST(Certificate, OfPartsThatAreReadyForAnotherPathIsThatOfPartsThatAreNot) {
  const Case c = fin_and_wall(0.2, 0.2 + 2 * kVoxel);
  Case other = c;
  other.path.moves = {{{{0, -1.0, 0.5}}}};
  Prover first(c.character, c.embedding, c.path, c.options);
  first.certify(c.parts, {});
  const Certificate anew = other.certified(), ready = Prover(other.character, other.embedding, other.path, other.options, first.ready()).certify(other.parts, {});
  EXPECT_EQ(ready.gap, anew.gap);
  EXPECT_EQ(ready.steps, anew.steps) << "what was proved for one path says nothing of another";
  const Case touching = fin_and_wall(0.22, 0.2);
  EXPECT_FALSE(Prover(c.character, c.embedding, c.path, c.options, first.ready()).certify(touching.parts, {}).holds) << "parts that are others are made ready anew";
}

}  // namespace
}  // namespace transformables
