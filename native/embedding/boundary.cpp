#include "embedding/boundary.h"

#include <algorithm>
#include <bit>

#include "common/eight.h"

namespace transformables {
namespace {

constexpr std::int32_t kLanes = 32;

struct View {
  const std::uint8_t* labels;
  std::int32_t pitch, slice;
  const std::uint8_t* parents;
  std::size_t parent_count;
  const std::uint32_t* lattice;
};

/// 32 cells, of which the bits in `wanted` count. Gives those on a boundary and those that touch their parent's part, with the faces.
EIGHT_INLINE std::uint32_t look(const View& view, std::int32_t c, std::uint32_t wanted, std::uint32_t& meeting, std::uint8_t* faces_of) {
  const std::int32_t around[6] = {-1, 1, -view.pitch, view.pitch, -view.slice, view.slice};
  const Bytes outside = Bytes{} + std::uint8_t(kNoLabel);
  EIGHT_LOAD(Bytes, own, view.labels + c);
  Bytes same = outside, alone = outside;
  for (const std::int32_t step : around) {
    EIGHT_LOAD(Bytes, other, view.labels + c + step);
    const Bytes equal = Bytes(other == own);
    same &= equal;
    alone &= equal | Bytes(other == outside);
  }
  const Bytes inside = Bytes(own != outside), on_boundary = inside & ~same, beside = inside & ~alone;
  EIGHT_BITS_OF_BYTES(boundary_bits, on_boundary);
  EIGHT_BITS_OF_BYTES(beside_bits, beside);
  meeting = 0;
  if ((beside_bits & wanted) == 0) return boundary_bits & wanted;
  Bytes parent = outside;
  for (std::size_t k = 0; k < view.parent_count; k += kLanes) {
    EIGHT_LOAD(Bytes, table, view.parents + k);
    const Bytes here = Bytes((own & std::uint8_t(~(kLanes - 1))) == std::uint8_t(k));
    parent = (here & __builtin_shuffle(table, own)) | (~here & parent);
  }
  Bytes faces = {};
  for (int side = 0; side < 6; ++side) {
    EIGHT_LOAD(Bytes, other, view.labels + c + around[side]);
    faces |= Bytes(other == parent) & std::uint8_t(1 << side);
  }
  faces &= Bytes(parent != outside);
  const Bytes meets = Bytes(faces != 0);
  EIGHT_BITS_OF_BYTES(bits, meets);
  meeting = bits & wanted;
  std::memcpy(faces_of, &faces, sizeof faces);
  return boundary_bits & wanted;
}

/// Where the findings go.
struct Ends {
  Boundary::Sample* sample;
  Boundary::Interface* interface;
};

EIGHT_INLINE void look_through(const View& view, const Voxels& voxels, Ends& to) {
  const std::int32_t spacing = voxels.spacing, skipped = kLanes % spacing;
  Boundary::Sample* sample = to.sample;
  Boundary::Interface* interface = to.interface;
  std::uint8_t faces[kLanes];
  const auto rows = std::int32_t(voxels.rows.size());
  for (std::int32_t r = 0; r < rows; ++r) {
    const Voxels::Row& row = voxels.rows[std::size_t(r)];
    std::int32_t phase = row.phase;
    for (std::int32_t c = row.begin, end = row.begin + row.count; c < end; c += kLanes) {
      const std::uint32_t wanted = end - c < kLanes ? (1u << (end - c)) - 1 : ~0u, lattice = view.lattice[phase];
      std::uint32_t meeting;
      for (std::uint32_t bits = look(view, c, wanted, meeting, faces) & lattice; bits != 0; bits &= bits - 1)
        *sample++ = {c + std::countr_zero(bits), r};
      for (; meeting != 0; meeting &= meeting - 1) {
        const int k = std::countr_zero(meeting);
        *interface++ = {c + k, r, faces[k], (lattice >> k & 1) != 0};
      }
      phase -= skipped;
      phase += phase < 0 ? spacing : 0;
    }
  }
  to = {sample, interface};
}

EIGHT_INLINE void pack(const std::int32_t* field, std::uint8_t* labels, std::int32_t count) {
  for (std::int32_t k = 0; k < count; ++k) labels[k] = std::uint8_t(field[k]);
}

void look_through_plain(const View& view, const Voxels& voxels, Ends& to) { look_through(view, voxels, to); }
void pack_plain(const std::int32_t* field, std::uint8_t* labels, std::int32_t count) { pack(field, labels, count); }

EIGHT_AVX2 void look_through_avx2(const View& view, const Voxels& voxels, Ends& to) { look_through(view, voxels, to); }
EIGHT_AVX2 void pack_avx2(const std::int32_t* field, std::uint8_t* labels, std::int32_t count) { pack(field, labels, count); }

}  // namespace

Boundary::Boundary(const Character& character, const Voxels& voxels)
    : parents_((character.bones.size() + kLanes - 1) / kLanes * kLanes, std::uint8_t(kNoLabel)),
      labels_(std::size_t(voxels.cells + kLanes), std::uint8_t(kNoLabel)),
      samples_(std::make_unique_for_overwrite<Sample[]>(voxels.inside)),
      interfaces_(std::make_unique_for_overwrite<Interface[]>(voxels.inside)) {
  for (std::size_t b = 0; b < character.bones.size(); ++b)
    if (character.bones[b].parent >= 0) parents_[b] = std::uint8_t(character.bones[b].parent);
  for (int first = 0; first < voxels.spacing; ++first) {
    std::uint32_t bits = 0;
    for (int k = first; k < kLanes; k += voxels.spacing) bits |= 1u << k;
    lattice_.push_back(bits);
  }
}

void Boundary::find(const Voxels& voxels, const std::int32_t* field) {
  (has_avx2() ? pack_avx2 : pack_plain)(field, labels_.data(), voxels.cells);
  const View view{labels_.data(), voxels.pitch, voxels.slice, parents_.data(), parents_.size(), lattice_.data()};
  Ends to{samples_.get(), interfaces_.get()};
  (has_avx2() ? look_through_avx2 : look_through_plain)(view, voxels, to);
  sample_count_ = std::size_t(to.sample - samples_.get());
  interface_count_ = std::size_t(to.interface - interfaces_.get());
}

}  // namespace transformables
