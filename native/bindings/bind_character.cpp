#include "bindings/bindings.h"
#include "character/character.h"
#include "target/target.h"

namespace transformables::bindings {
namespace {

using HingeTuple = std::tuple<int, double, double>;

Character from_lists(const std::vector<std::string>& names, const std::vector<int>& parents, const py::buffer& heads,
                     const py::buffer& tails, const py::buffer& axes, const std::vector<std::vector<HingeTuple>>& hinges) {
  const auto head = read_points(heads, "heads"), tail = read_points(tails, "tails");
  const auto axis = read_array<double>(axes, 9, "axes");
  const std::size_t n = names.size();
  if (parents.size() != n || head.size() != n || tail.size() != n || axis.size() != 9 * n || hinges.size() != n)
    throw InvalidInput("a character's names, parents, heads, tails, axes and hinges must have one row a bone");
  std::vector<ArmatureBone> bones(n);
  for (std::size_t i = 0; i < n; ++i) {
    bones[i].name = names[i];
    bones[i].parent = parents[i];
    bones[i].head = head[i];
    bones[i].tail = tail[i];
    bones[i].axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&axis[9 * i]);
    for (const auto& [a, low, high] : hinges[i]) bones[i].hinges.push_back({a, low, high});
  }
  return make_character(bones);
}

template <class T, class F>
std::vector<T> per_bone(const Character& c, F&& value) {
  std::vector<T> rows;
  for (const Bone& bone : c.bones) rows.push_back(value(bone));
  return rows;
}

std::vector<HingeTuple> hinge_tuples(const Bone& bone) {
  std::vector<HingeTuple> rows;
  for (const Hinge& h : bone.hinges) rows.emplace_back(h.axis, h.min_rad, h.max_rad);
  return rows;
}

}  // namespace

void bind_character(py::module_& m) {
  py::class_<Character>(m, "Character")
      .def_property_readonly("names", [](const Character& c) { return per_bone<std::string>(c, [](const Bone& b) { return b.name; }); })
      .def_property_readonly("parents", [](const Character& c) { return per_bone<int>(c, [](const Bone& b) { return b.parent; }); })
      .def_property_readonly("members", [](const Character& c) { return per_bone<std::vector<int>>(c, [](const Bone& b) { return b.members; }); })
      .def_property_readonly("hinges", [](const Character& c) { return per_bone<std::vector<HingeTuple>>(c, hinge_tuples); })
      .def_property_readonly("first_angle", [](const Character& c) { return per_bone<int>(c, [](const Bone& b) { return b.first_angle; }); })
      .def_property_readonly("radii", [](const Character& c) { return per_bone<double>(c, [](const Bone& b) { return b.radius; }); })
      .def_readonly("angle_count", &Character::angle_count)
      .def_readonly("mirrored", &Character::mirrored)
      .def_readonly("scale", &Character::scale);

  m.def("make_character", &from_lists, py::kw_only(), py::arg("names"), py::arg("parents"), py::arg("heads"), py::arg("tails"),
        py::arg("axes"), py::arg("hinges"),
        "The character of an armature. heads, tails: n x 3 float64, axes: n x 9 float64 (3 x 3 row-major, columns are the bone's X, Y, Z), "
        "all in the character's frame; hinges: for each bone a list of (axis 0..2, least, largest angle in radians). Raises InvalidInput.");
  m.def(
      "fitted",
      [](const Character& character, const Target& target, double least_radius, double scale) {
        return fitted(character, target.volume, kLongestSide, least_radius, scale);
      },
      py::arg("character"), py::arg("target"), py::kw_only(), py::arg("least_radius"), py::arg("scale") = 0.0,
      "The character scaled as a whole for the target (scale 0: chosen), radii in target units. Raises InvalidInput.");
}

}  // namespace transformables::bindings
