#include "bindings/bindings.h"
#include "finishing/finishing.h"

namespace transformables::bindings {

py::list collision_dicts(const std::vector<Collision>& collisions);

namespace {

py::list part_dicts(const Parts& parts) {
  py::list rows;
  for (const Part& part : parts.parts) {
    std::vector<double> vertices;
    std::vector<std::int32_t> triangles;
    for (const auto& v : part.mesh.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
    for (const auto& t : part.mesh.triangles) triangles.insert(triangles.end(), t.data(), t.data() + 3);
    py::dict d;
    d["bone"] = part.bone;
    d["vertices"] = write_array(vertices);
    d["triangles"] = write_array(triangles);
    d["source"] = write_array(part.source);
    d["volume"] = part.volume;
    rows.append(d);
  }
  return rows;
}

}  // namespace

void bind_finishing(py::module_& m) {
  py::class_<Parts>(m, "Parts")
      .def_property_readonly("parts", &part_dicts)
      .def_property_readonly("collisions", [](const Parts& p) { return collision_dicts(p.collisions); })
      .def_readonly("certificate", &Parts::certificate)
      .def_readonly("minimum_clearance", &Parts::minimum_clearance)
      .def_readonly("carved_volume_pct", &Parts::carved_volume_pct)
      .def_readonly("filled_volume_pct", &Parts::filled_volume_pct)
      .def_readonly("pinned", &Parts::pinned)
      .def_readonly("warnings", &Parts::warnings);

  m.def(
      "finish",
      [](const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding, const FoldPath& path,
         double clearance, const std::string& style, double wall, int threads, bool exact_surface, bool hinges,
         const py::object& progress) {
        FinishingOptions options;
        options.exact_surface = exact_surface;
        options.hinges = hinges;
        options.clearance = clearance;
        options.wall = wall;
        options.threads = threads;
        if (style != "solid" && style != "shell") throw InvalidInput("style is solid or shell, not '" + style + "'");
        options.style = style == "shell" ? Style::kShell : Style::kSolid;
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return finish(segmentation, character, target, embedding, path, options, tell);
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::arg("path"), py::kw_only(),
      py::arg("clearance"), py::arg("style") = "solid", py::arg("wall") = 0.004, py::arg("threads") = 0, py::arg("exact_surface") = true,
      py::arg("hinges") = true, py::arg("progress") = py::none(),
      "Clearance, carving along the path, meshes, checks, proof. clearance and wall: target units. Raises InvalidInput, Cancelled.");

  m.def(
      "certify",
      [](const Parts& parts, const Character& character, const Embedding& embedding, const FoldPath& path, double enough, double least,
         double tolerance, long steps, std::vector<std::pair<int, int>> pairs, bool to_the_end, int threads, const py::object& progress) {
        CertificateOptions options;
        options.pairs = std::move(pairs);
        options.enough = enough;
        options.least = least;
        options.tolerance = tolerance;
        options.steps = steps;
        options.to_the_end = to_the_end;
        options.threads = threads;
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return Prover(character, embedding, path, options, parts.ready).certify(parts.parts, tell);
      },
      py::arg("parts"), py::arg("character"), py::arg("embedding"), py::arg("path"), py::kw_only(), py::arg("enough"), py::arg("least"),
      py::arg("tolerance") = CertificateOptions{}.tolerance, py::arg("steps") = CertificateOptions{}.steps,
      py::arg("pairs") = std::vector<std::pair<int, int>>{}, py::arg("to_the_end") = true, py::arg("threads") = 0, py::arg("progress") = py::none(),
      "The proof that finished parts, or only some pairs of bones (lesser first), stay apart, for another path from the embedding's pose. enough: target units, beyond which nobody looks closer; "
      "least: nearer ones touch; tolerance: share by which what is proved may fall short; steps: comparisons for one pair in one move, at most; to_the_end: false gives up where the first proof fails, and tells no place. Raises InvalidInput, Cancelled.");
}

}  // namespace transformables::bindings
