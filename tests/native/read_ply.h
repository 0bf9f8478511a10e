// The shared targets' files.
#pragma once

#include <algorithm>
#include <cstdint>
#include <istream>
#include <sstream>
#include <string>
#include <vector>

#include "common/mesh.h"

namespace transformables {

/// Binary PLY as the data set has it: float x, y, z alone, then lists of a byte and 32-bit indices.
inline TriangleMesh read_ply(std::istream& in) {
  TriangleMesh mesh;
  std::size_t vertices = 0, faces = 0;
  for (std::string line; std::getline(in, line) && line != "end_header";) {
    std::istringstream words(line);
    std::string a, b;
    words >> a >> b;
    if (b == "vertex") words >> vertices;
    if (b == "face") words >> faces;
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    float p[3];
    in.read(reinterpret_cast<char*>(p), sizeof p);
    mesh.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (std::size_t f = 0; f < faces && in; ++f) {
    const int n = std::max(0, in.get());
    std::vector<std::int32_t> c(std::size_t(n), 0);
    in.read(reinterpret_cast<char*>(c.data()), std::streamsize(c.size() * 4));
    for (int i = 2; i < n; ++i) mesh.triangles.emplace_back(c[0], c[std::size_t(i) - 1], c[std::size_t(i)]);
  }
  return mesh;
}

}  // namespace transformables
