#include "bindings/bindings.h"
#include "embedding/embedding.h"

namespace transformables::bindings {
namespace {

Symmetry symmetry_from(const std::string& word) {
  if (word == "auto") return Symmetry::kAuto;
  if (word == "on") return Symmetry::kOn;
  if (word == "off") return Symmetry::kOff;
  throw InvalidInput("symmetry is auto, on or off, not '" + word + "'");
}

py::dict terms_of(const Embedding& e) {
  const ObjectiveTerms& t = e.terms;
  py::dict d;
  d["compact"] = t.compact;
  d["skin"] = t.skin;
  d["skeleton"] = t.skeleton;
  d["protrude"] = t.protrude;
  d["limits"] = t.limits;
  d["morphology"] = t.morphology;
  d["total"] = t.total;
  return d;
}

}  // namespace

void bind_embedding(py::module_& m) {
  py::class_<Embedding>(m, "Embedding")
      .def(py::init([](const std::vector<double>& root, const std::vector<double>& angles, const std::vector<double>& morphology,
                       bool symmetric) {
             Embedding e;
             e.pose.root = frame_from(root);
             e.pose.angles = vector_from(angles);
             e.morphology = vector_from(morphology);
             e.symmetric = symmetric;
             return e;
           }),
           py::kw_only(), py::arg("root"), py::arg("angles"), py::arg("morphology"), py::arg("symmetric") = false)
      .def_property_readonly("root", [](const Embedding& e) { return flat(e.pose.root); })
      .def_property_readonly("angles", [](const Embedding& e) { return flat(e.pose.angles); })
      .def_property_readonly("morphology", [](const Embedding& e) { return flat(e.morphology); })
      .def_property_readonly("terms", &terms_of)
      .def_readonly("symmetric", &Embedding::symmetric)
      .def_readonly("deepest_protrusion", &Embedding::deepest_protrusion)
      .def_readonly("deepest_collision", &Embedding::deepest_collision)
      .def_readonly("evaluations", &Embedding::evaluations);

  m.def(
      "embed",
      [](const Character& character, const Target& target, std::uint64_t seed, const std::string& symmetry, bool proportions,
         int threads, const std::optional<Embedding>& start, const py::object& progress, const py::object& best) {
        EmbeddingOptions options;
        options.seed = seed;
        options.symmetry = symmetry_from(symmetry);
        options.proportions = proportions;
        options.threads = threads;
        const Progress tell = progress_from(progress);
        std::function<void(const Embedding&)> show;
        if (!best.is_none())
          show = [&best](const Embedding& e) {
            py::gil_scoped_acquire gil;
            best(e);
          };
        py::gil_scoped_release release;
        return embed(character, target, options, tell, start, show);
      },
      py::arg("character"), py::arg("target"), py::kw_only(), py::arg("seed") = 0, py::arg("symmetry") = "auto",
      py::arg("proportions") = true, py::arg("threads") = 0, py::arg("start") = py::none(), py::arg("progress") = py::none(),
      py::arg("best") = py::none(),
      "Folds the fitted character's skeleton into the target (CMA-ES). best(Embedding) hears of each better pose. Raises InvalidInput, Cancelled.");
}

}  // namespace transformables::bindings
