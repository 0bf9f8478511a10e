#include "bindings/bindings.h"
#include "target/target.h"

namespace transformables::bindings {

void bind_target(py::module_& m) {
  py::class_<Target>(m, "Target")
      .def_readonly("scale", &Target::scale)
      .def_readonly("volume", &Target::volume)
      .def_readonly("warnings", &Target::warnings)
      .def_readonly("mirror_axis", &Target::mirror_axis)
      .def_readonly("exact_surface", &Target::exact_surface)
      .def_property_readonly("centre", [](const Target& t) { return std::vector<double>{t.centre.x(), t.centre.y(), t.centre.z()}; })
      .def_property_readonly("grid", [](const Target& t) {
        const auto& s = t.distance.shape.size;
        return std::vector<int>{s.x(), s.y(), s.z()};
      });

  m.def(
      "make_target",
      [](const py::buffer& vertices, const py::buffer& triangles, int resolution, const py::object& progress) {
        const auto points = read_points(vertices, "vertices");
        const auto faces = read_triples(triangles, "triangles");
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return make_target(points, faces, {resolution}, tell);
      },
      py::kw_only(), py::arg("vertices"), py::arg("triangles"), py::arg("resolution") = 64, py::arg("progress") = py::none(),
      "Checks, repairs and measures a target. vertices: n x 3 float64 (Blender units), triangles: m x 3 int32. Raises InvalidInput, Cancelled.");
}

}  // namespace transformables::bindings
