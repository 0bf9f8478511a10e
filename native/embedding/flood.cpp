#include "embedding/flood.h"

#include <algorithm>

namespace transformables {
namespace {

// Costs of a step to a neighbour by face, edge and corner, packed as distances are.
constexpr std::int32_t kFace = 32 << kLabelBits, kEdge = 45 << kLabelBits, kCorner = 55 << kLabelBits;

#if defined(__GNUC__)
#define EMBEDDING_INLINE inline __attribute__((always_inline))
#define EMBEDDING_NO_OVERLAP _Pragma("GCC ivdep")  // a loop writes one row and reads others
#else
#define EMBEDDING_INLINE inline
#define EMBEDDING_NO_OVERLAP
#endif

EMBEDDING_INLINE std::int32_t least(std::int32_t a, std::int32_t b) { return a < b ? a : b; }

/// Takes to a row what comes from the four rows on one side of it (`dy`, `dz` lead to the rows above and before).
EMBEDDING_INLINE std::int32_t pull_from_rows(std::int32_t* v, const std::int32_t* wall, int count, int dy, int dz) {
  const std::int32_t *a = v + dy, *b = v + dz, *c = v + dz + dy, *d = v + dz - dy;
  std::int32_t changed = 0;
  EMBEDDING_NO_OVERLAP
  for (int i = 0; i < (count & ~7); ++i) {
    const std::int32_t face = least(a[i], b[i]);
    const std::int32_t edge = least(least(least(a[i - 1], a[i + 1]), least(b[i - 1], b[i + 1])), least(c[i], d[i]));
    const std::int32_t corner = least(least(c[i - 1], c[i + 1]), least(d[i - 1], d[i + 1]));
    const std::int32_t from = least(least(face + kFace, edge + kEdge), corner + kCorner);
    const std::int32_t old = v[i], now = std::max(wall[i], least(old, from));
    changed |= now ^ old;
    v[i] = now;
  }
  return changed;
}

EMBEDDING_INLINE std::int32_t sweep_forward(const Voxels& voxels, std::int32_t* field) {
  std::int32_t changed = 0;
  for (const Voxels::Row& row : voxels.rows) {
    changed |= pull_from_rows(field + row.begin, voxels.wall.data() + row.begin, row.count, -voxels.pitch, -voxels.slice);
    for (int r = row.first_run; r < row.end_run; ++r) {
      std::int32_t carried = kUnreached;
      for (int c = voxels.runs[std::size_t(r)].begin; c < voxels.runs[std::size_t(r)].end; ++c) {
        const std::int32_t old = field[c];
        carried = least(old, carried + kFace);
        changed |= carried ^ old;
        field[c] = carried;
      }
    }
  }
  return changed;
}

EMBEDDING_INLINE std::int32_t sweep_backward(const Voxels& voxels, std::int32_t* field) {
  std::int32_t changed = 0;
  for (std::size_t k = voxels.rows.size(); k-- > 0;) {
    const Voxels::Row& row = voxels.rows[k];
    changed |= pull_from_rows(field + row.begin, voxels.wall.data() + row.begin, row.count, voxels.pitch, voxels.slice);
    for (int r = row.end_run; r-- > row.first_run;) {
      std::int32_t carried = kUnreached;
      for (int c = voxels.runs[std::size_t(r)].end; c-- > voxels.runs[std::size_t(r)].begin;) {
        const std::int32_t old = field[c];
        carried = least(old, carried + kFace);
        changed |= carried ^ old;
        field[c] = carried;
      }
    }
  }
  return changed;
}

EMBEDDING_INLINE int sweep_until_still(const Voxels& voxels, std::int32_t* field) {
  for (int sweeps = 1;; ++sweeps) {
    // After a sweep nothing more comes from its side; the first that changes nothing from the other one ends it.
    const std::int32_t changed = sweeps % 2 == 1 ? sweep_forward(voxels, field) : sweep_backward(voxels, field);
    if (changed == 0 && sweeps > 1) return sweeps;
  }
}

EMBEDDING_INLINE void mark(const std::int32_t* v, int count, int dy, int dz, std::uint8_t* marks) {
  EMBEDDING_NO_OVERLAP
  for (int i = 0; i < (count & ~7); ++i) {
    const std::int32_t differs = (v[i] ^ v[i - 1]) | (v[i] ^ v[i + 1]) | (v[i] ^ v[i - dy]) | (v[i] ^ v[i + dy]) |
                                 (v[i] ^ v[i - dz]) | (v[i] ^ v[i + dz]);
    marks[i] = std::uint8_t(differs & kNoLabel);
  }
}

// The same code twice: once for every machine, once for those (nearly all) with vectors of eight.
int flood_plain(const Voxels& voxels, std::int32_t* field) { return sweep_until_still(voxels, field); }
void mark_plain(const std::int32_t* v, int count, int dy, int dz, std::uint8_t* marks) { mark(v, count, dy, dz, marks); }

#if defined(__GNUC__) && defined(__x86_64__)
__attribute__((target("avx2"))) int flood_avx2(const Voxels& voxels, std::int32_t* field) {
  return sweep_until_still(voxels, field);
}
__attribute__((target("avx2"))) void mark_avx2(const std::int32_t* v, int count, int dy, int dz, std::uint8_t* marks) {
  mark(v, count, dy, dz, marks);
}
bool has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2");
  return has;
}
#else
int flood_avx2(const Voxels& voxels, std::int32_t* field) { return flood_plain(voxels, field); }
void mark_avx2(const std::int32_t* v, int count, int dy, int dz, std::uint8_t* marks) { mark_plain(v, count, dy, dz, marks); }
bool has_avx2() { return false; }
#endif

}  // namespace

int flood(const Voxels& voxels, std::int32_t* field) {
  return has_avx2() ? flood_avx2(voxels, field) : flood_plain(voxels, field);
}

void mark_boundary(const Voxels& voxels, const std::int32_t* field, const Voxels::Row& row, std::uint8_t* marks) {
  (has_avx2() ? mark_avx2 : mark_plain)(field + row.begin, row.count, voxels.pitch, voxels.slice, marks);
}

}  // namespace transformables
