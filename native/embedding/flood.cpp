#include "embedding/flood.h"

#include <algorithm>
#include <cstring>

#include "common/eight.h"

namespace transformables {
namespace {

// Costs of a step to a neighbour by face, edge and corner, packed as distances are.
constexpr std::int32_t kFace = 32 << kLabelBits, kEdge = 45 << kLabelBits, kCorner = 55 << kLabelBits;

#define EIGHT_LEAST(a, b) ((a) < (b) ? (a) : (b))

/// One row takes what comes from the four rows on the side that the sweep comes from, and from its own cells on that
/// side: log-step minimum within eight, then a carry. `multiple`: the row has gaps, over which nothing may be
/// carried, so its own cells are left to `carry_along_runs`.
template <bool kForward>
EIGHT_INLINE bool sweep_row(std::int32_t* row, const std::int32_t* wall, int count, int pitch, int slice, bool multiple) {
  const int dy = kForward ? -pitch : pitch, dz = kForward ? -slice : slice;
  const Eight none = Eight{} + kUnreached, ramp = kForward ? Eight{1, 2, 3, 4, 5, 6, 7, 8} : Eight{8, 7, 6, 5, 4, 3, 2, 1};
  Eight changed = {}, carried = none;
  for (int k = 0; k < count; k += 8) {
    std::int32_t* v = row + (kForward ? k : count - 8 - k);
    const std::int32_t *a = v + dy, *b = v + dz, *c = v + dz + dy, *d = v + dz - dy;
    EIGHT_LOAD(Eight, old, v);
    EIGHT_LOAD(Eight, a0, a);
    EIGHT_LOAD(Eight, b0, b);
    EIGHT_LOAD(Eight, a1, a - 1);
    EIGHT_LOAD(Eight, a2, a + 1);
    EIGHT_LOAD(Eight, b1, b - 1);
    EIGHT_LOAD(Eight, b2, b + 1);
    EIGHT_LOAD(Eight, c0, c);
    EIGHT_LOAD(Eight, d0, d);
    EIGHT_LOAD(Eight, c1, c - 1);
    EIGHT_LOAD(Eight, c2, c + 1);
    EIGHT_LOAD(Eight, d1, d - 1);
    EIGHT_LOAD(Eight, d2, d + 1);
    EIGHT_LOAD(Eight, walls, wall + (v - row));
    const Eight face = EIGHT_LEAST(a0, b0) + kFace;
    const Eight a12 = EIGHT_LEAST(a1, a2), b12 = EIGHT_LEAST(b1, b2), cd = EIGHT_LEAST(c0, d0);
    const Eight ab = EIGHT_LEAST(a12, b12), edge = EIGHT_LEAST(ab, cd) + kEdge;
    const Eight c12 = EIGHT_LEAST(c1, c2), d12 = EIGHT_LEAST(d1, d2), corner = EIGHT_LEAST(c12, d12) + kCorner;
    const Eight near = EIGHT_LEAST(face, edge), from = EIGHT_LEAST(near, corner);
    Eight now = EIGHT_LEAST(old, from);
    if (!multiple) {
      const Eight one = (kForward ? __builtin_shuffle(none, now, Eight{0, 8, 9, 10, 11, 12, 13, 14})
                                  : __builtin_shuffle(now, none, Eight{1, 2, 3, 4, 5, 6, 7, 8})) + kFace;
      now = EIGHT_LEAST(now, one);
      const Eight two = (kForward ? __builtin_shuffle(none, now, Eight{0, 1, 8, 9, 10, 11, 12, 13})
                                  : __builtin_shuffle(now, none, Eight{2, 3, 4, 5, 6, 7, 8, 9})) + 2 * kFace;
      now = EIGHT_LEAST(now, two);
      const Eight four = (kForward ? __builtin_shuffle(none, now, Eight{0, 1, 2, 3, 8, 9, 10, 11})
                                   : __builtin_shuffle(now, none, Eight{4, 5, 6, 7, 8, 9, 10, 11})) + 4 * kFace;
      now = EIGHT_LEAST(now, four);
      const Eight along = carried + ramp * kFace;
      now = EIGHT_LEAST(now, along);
      carried = kForward ? __builtin_shuffle(now, Eight{7, 7, 7, 7, 7, 7, 7, 7}) : __builtin_shuffle(now, Eight{});
    }
    now = now > walls ? now : walls;
    changed |= now ^ old;
    std::memcpy(v, &now, sizeof now);
  }
  std::int32_t any = 0;
  for (int k = 0; k < 8; ++k) any |= changed[k];
  return any != 0;
}

/// Within each run of inside cells, from each to the next.
template <bool kForward>
EIGHT_INLINE bool carry_along_runs(const Voxels& voxels, const Voxels::Row& row, std::int32_t* field) {
  std::int32_t changed = 0;
  for (int r = row.first_run; r < row.end_run; ++r) {
    const Voxels::Run run = voxels.runs[std::size_t(r)];
    std::int32_t carried = kUnreached;
    for (int k = 0; k < run.end - run.begin; ++k) {
      std::int32_t& cell = field[kForward ? run.begin + k : run.end - 1 - k];
      carried = std::min(cell, carried + kFace);
      changed |= carried ^ cell;
      cell = carried;
    }
  }
  return changed != 0;
}

/// A row is gone through when it, or one of the four rows it takes from, changed in this sweep or in the last one; all are in the
/// first sweep from each side.
/// @param changed  of each row of the box and one around it: the number of the last sweep that changed it
template <bool kForward>
EIGHT_INLINE bool sweep(const Voxels& voxels, std::int32_t* field, std::int32_t* changed, std::int32_t number) {
  bool any = false;
  const std::size_t count = voxels.rows.size();
  const std::ptrdiff_t dy = kForward ? -1 : 1, dz = dy * (voxels.size.y() + 2);
  for (std::size_t k = 0; k < count; ++k) {
    const Voxels::Row& row = voxels.rows[kForward ? k : count - 1 - k];
    std::int32_t* at = changed + (row.z + 1) * std::ptrdiff_t(voxels.size.y() + 2) + row.y + 1;
    const std::int32_t latest = std::max({at[0], at[dy], at[dz], at[dz - dy], at[dz + dy]});
    if (number > 2 && latest < number - 1) continue;
    const bool multiple = row.end_run - row.first_run > 1;
    bool now = sweep_row<kForward>(field + row.begin, voxels.wall.data() + row.begin, row.count, voxels.pitch, voxels.slice, multiple);
    if (multiple) now |= carry_along_runs<kForward>(voxels, row, field);
    if (now) *at = number;
    any |= now;
  }
  return any;
}

/// After a sweep nothing more comes from its side: the first that changes nothing, coming from the other, is the last.
EIGHT_INLINE int sweep_until_still(const Voxels& voxels, std::int32_t* field, std::int32_t* changed) {
  for (int sweeps = 1;; ++sweeps) {
    const bool any = sweeps % 2 == 1 ? sweep<true>(voxels, field, changed, sweeps) : sweep<false>(voxels, field, changed, sweeps);
    if (!any && sweeps > 1) return sweeps;
  }
}

int flood_plain(const Voxels& voxels, std::int32_t* field, std::int32_t* changed) { return sweep_until_still(voxels, field, changed); }

EIGHT_AVX2 int flood_avx2(const Voxels& voxels, std::int32_t* field, std::int32_t* changed) { return sweep_until_still(voxels, field, changed); }

}  // namespace

int flood(const Voxels& voxels, std::int32_t* field, std::vector<std::int32_t>& rows) {
  rows.assign(std::size_t(voxels.size.y() + 2) * std::size_t(voxels.size.z() + 2), 0);
  return has_avx2() ? flood_avx2(voxels, field, rows.data()) : flood_plain(voxels, field, rows.data());
}

}  // namespace transformables
