// Real characters and targets, in pairs: targets are files of the folder that TRANSFORMABLES_SHARED names, and write_characters.py has written the characters.
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "character/character.h"
#include "read_ply.h"
#include "reference/cases.h"
#include "target/target.h"

namespace transformables::pairs {

struct Pair {
  std::string target, character;
};

/// All eight with TRANSFORMABLES_SWEEP, else `sample` of them; none without the shared folder.
inline std::vector<Pair> chosen(const std::vector<Pair>& sample) {
  if (!std::getenv("TRANSFORMABLES_SHARED")) return {};
  if (!std::getenv("TRANSFORMABLES_SWEEP")) return sample;
  return {{"egg", "phantomx"}, {"wheel", "phantomx"}, {"oval", "unitree_a1"}, {"car_beetle", "minitaur"}, {"bunny", "snake16"},
          {"egg", "robotis_op3"}, {"truck", "basic_human"}, {"spot_cow", "basic_quadruped"}};
}

/// A character in its own size. @throws std::runtime_error when it was not written
inline Character raw_character(const std::string& name) {
  std::ifstream in(TRANSFORMABLES_TEST_CHARACTERS);
  std::string line;
  int count = 0;
  while (count == 0 && std::getline(in, line)) {
    std::istringstream words(line);
    std::string first, second;
    if (words >> first >> second && first == "character" && second == name) words >> count;
  }
  if (count == 0)
    throw std::runtime_error(std::string(TRANSFORMABLES_TEST_CHARACTERS) + " has no '" + name + "': run tests/native/write_characters.py --shared DIR " + TRANSFORMABLES_TEST_CHARACTERS);
  std::vector<ArmatureBone> bones;
  for (; count > 0 && std::getline(in, line); --count) {
    std::istringstream words(line);
    ArmatureBone bone;
    Eigen::Vector3d x, y;
    words >> bone.name >> bone.parent;
    for (Eigen::Vector3d* v : {&bone.head, &bone.tail, &x, &y}) words >> v->x() >> v->y() >> v->z();
    bone.axes.col(1) = y.normalized();
    bone.axes.col(2) = x.cross(y).normalized();
    bone.axes.col(0) = bone.axes.col(1).cross(bone.axes.col(2));
    int hinges = 0, axis = 0;
    double low = 0, high = 0;
    for (words >> hinges; hinges > 0 && words >> axis >> low >> high; --hinges) bone.hinges.push_back({axis, low, high});
    bones.push_back(bone);
  }
  return make_character(bones);
}

inline Target ply_target(const std::filesystem::path& file, int resolution) {
  std::ifstream in(file, std::ios::binary);
  const TriangleMesh mesh = read_ply(in);
  return make_target(mesh.vertices, mesh.triangles, {resolution}, {});
}

inline reference::Case made(const Pair& pair, int resolution) {
  reference::Case made{pair.target + " x " + pair.character,
                       ply_target(std::filesystem::path(std::getenv("TRANSFORMABLES_SHARED")) / "data" / "targets" / (pair.target + ".ply"), resolution), {}};
  const Character raw = raw_character(pair.character);
  const double share = std::cbrt(made.target.volume / double(raw.bones.size()));
  made.character = fitted(raw, made.target.volume, kLongestSide, std::max(0.1 * share, 0.87 * made.target.distance.shape.step));
  return made;
}

}  // namespace transformables::pairs
