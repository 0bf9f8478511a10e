// From fields to meshes: outside, the target's own triangles; at interfaces, the fields' surfaces.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "finishing/carve.h"
#include "finishing/exact_cut.h"
#include "finishing/finishing.h"
#include "finishing/part_field.h"

namespace transformables::finishing {

/// Makes meshes of fields, again and again while these are carved; keeps what does not change between.
class Mesher {
 public:
  /// Refers to the scene and the target while it lives.
  Mesher(const Scene& scene, const Target& target);

  /// Parts with something inside, in order, each a closed simple solid in one piece in its bone's frame; only those named in `wanted` (a
  /// flag for each field) are made anew, others are as before.
  const std::vector<Part>& mesh(const std::vector<PartField>& fields, const std::vector<char>& wanted);

  /// From now on this bone's part is meshed from its level set. False when it is already.
  bool give_up_exact(int bone);

  /// Why surfaces, or which, are not the target's own triangles; a sentence each.
  std::vector<std::string> warnings() const;

 private:
  enum class Surface : char { kExact, kCutFailed, kGivenUp };
  Part part_of(const std::vector<PartField>& fields, std::size_t n);

  const Scene& scene_;
  std::optional<CuttableTarget> cuttable_;
  std::string obstacle_;
  std::vector<Surface> surface_;     // a bone each
  std::vector<Part> all_, kept_;
};

}  // namespace transformables::finishing
