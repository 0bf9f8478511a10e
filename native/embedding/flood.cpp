#include "embedding/flood.h"

#include <algorithm>
#include <cstring>

namespace transformables {
namespace {

// Costs of a step to a neighbour by face, edge and corner, packed as distances are.
constexpr std::int32_t kFace = 32 << kLabelBits, kEdge = 45 << kLabelBits, kCorner = 55 << kLabelBits;

// Eight cells at once. The same code is compiled twice below: for every machine, and for those (nearly all) whose
// registers hold eight numbers. No eight is passed to or from a function that is not inlined.
#define EMBEDDING_INLINE inline __attribute__((always_inline))
typedef std::int32_t Eight __attribute__((vector_size(32)));

// Macros, since a vector handed to a function, inlined or not, changes the binary interface with the machine.
#define EMBEDDING_LOAD(name, from) \
  Eight name;                      \
  std::memcpy(&name, from, sizeof name)
#define EMBEDDING_LEAST(a, b) ((a) < (b) ? (a) : (b))

/// One row takes what comes from the four rows on the side that the sweep comes from, and from its own cells on that
/// side: log-step minimum within eight, then a carry. `multiple`: the row has gaps, over which nothing may be
/// carried, so its own cells are left to `carry_along_runs`.
template <bool kForward>
EMBEDDING_INLINE bool sweep_row(std::int32_t* row, const std::int32_t* wall, int count, int pitch, int slice, bool multiple) {
  const int dy = kForward ? -pitch : pitch, dz = kForward ? -slice : slice;
  const Eight none = Eight{} + kUnreached, ramp = kForward ? Eight{1, 2, 3, 4, 5, 6, 7, 8} : Eight{8, 7, 6, 5, 4, 3, 2, 1};
  Eight changed = {}, carried = none;
  for (int k = 0; k < count; k += 8) {
    std::int32_t* v = row + (kForward ? k : count - 8 - k);
    const std::int32_t *a = v + dy, *b = v + dz, *c = v + dz + dy, *d = v + dz - dy;
    EMBEDDING_LOAD(old, v);
    EMBEDDING_LOAD(a0, a);
    EMBEDDING_LOAD(b0, b);
    EMBEDDING_LOAD(a1, a - 1);
    EMBEDDING_LOAD(a2, a + 1);
    EMBEDDING_LOAD(b1, b - 1);
    EMBEDDING_LOAD(b2, b + 1);
    EMBEDDING_LOAD(c0, c);
    EMBEDDING_LOAD(d0, d);
    EMBEDDING_LOAD(c1, c - 1);
    EMBEDDING_LOAD(c2, c + 1);
    EMBEDDING_LOAD(d1, d - 1);
    EMBEDDING_LOAD(d2, d + 1);
    EMBEDDING_LOAD(walls, wall + (v - row));
    const Eight face = EMBEDDING_LEAST(a0, b0) + kFace;
    const Eight a12 = EMBEDDING_LEAST(a1, a2), b12 = EMBEDDING_LEAST(b1, b2), cd = EMBEDDING_LEAST(c0, d0);
    const Eight ab = EMBEDDING_LEAST(a12, b12), edge = EMBEDDING_LEAST(ab, cd) + kEdge;
    const Eight c12 = EMBEDDING_LEAST(c1, c2), d12 = EMBEDDING_LEAST(d1, d2), corner = EMBEDDING_LEAST(c12, d12) + kCorner;
    const Eight near = EMBEDDING_LEAST(face, edge), from = EMBEDDING_LEAST(near, corner);
    Eight now = EMBEDDING_LEAST(old, from);
    if (!multiple) {
      const Eight one = (kForward ? __builtin_shuffle(none, now, Eight{0, 8, 9, 10, 11, 12, 13, 14})
                                  : __builtin_shuffle(now, none, Eight{1, 2, 3, 4, 5, 6, 7, 8})) + kFace;
      now = EMBEDDING_LEAST(now, one);
      const Eight two = (kForward ? __builtin_shuffle(none, now, Eight{0, 1, 8, 9, 10, 11, 12, 13})
                                  : __builtin_shuffle(now, none, Eight{2, 3, 4, 5, 6, 7, 8, 9})) + 2 * kFace;
      now = EMBEDDING_LEAST(now, two);
      const Eight four = (kForward ? __builtin_shuffle(none, now, Eight{0, 1, 2, 3, 8, 9, 10, 11})
                                   : __builtin_shuffle(now, none, Eight{4, 5, 6, 7, 8, 9, 10, 11})) + 4 * kFace;
      now = EMBEDDING_LEAST(now, four);
      const Eight along = carried + ramp * kFace;
      now = EMBEDDING_LEAST(now, along);
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
EMBEDDING_INLINE bool carry_along_runs(const Voxels& voxels, const Voxels::Row& row, std::int32_t* field) {
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

template <bool kForward>
EMBEDDING_INLINE bool sweep(const Voxels& voxels, std::int32_t* field) {
  bool changed = false;
  const std::size_t count = voxels.rows.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Voxels::Row& row = voxels.rows[kForward ? k : count - 1 - k];
    const bool multiple = row.end_run - row.first_run > 1;
    changed |= sweep_row<kForward>(field + row.begin, voxels.wall.data() + row.begin, row.count, voxels.pitch, voxels.slice, multiple);
    if (multiple) changed |= carry_along_runs<kForward>(voxels, row, field);
  }
  return changed;
}

/// After a sweep nothing more comes from its side: the first that changes nothing, coming from the other, is the last.
EMBEDDING_INLINE int sweep_until_still(const Voxels& voxels, std::int32_t* field) {
  for (int sweeps = 1;; ++sweeps) {
    const bool changed = sweeps % 2 == 1 ? sweep<true>(voxels, field) : sweep<false>(voxels, field);
    if (!changed && sweeps > 1) return sweeps;
  }
}

int flood_plain(const Voxels& voxels, std::int32_t* field) { return sweep_until_still(voxels, field); }

#if defined(__x86_64__)
__attribute__((target("avx2"))) int flood_avx2(const Voxels& voxels, std::int32_t* field) {
  return sweep_until_still(voxels, field);
}
bool has_avx2() { return __builtin_cpu_supports("avx2"); }
#else
int flood_avx2(const Voxels& voxels, std::int32_t* field) { return flood_plain(voxels, field); }
bool has_avx2() { return false; }
#endif

}  // namespace

int flood(const Voxels& voxels, std::int32_t* field) {
  return has_avx2() ? flood_avx2(voxels, field) : flood_plain(voxels, field);
}

}  // namespace transformables
