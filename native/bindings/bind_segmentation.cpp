#include <variant>

#include "bindings/bindings.h"
#include "folding/folding.h"
#include "segmentation/segmentation.h"

namespace transformables::bindings {
namespace {

/// Inside samples of each bone times a sample's volume, cubic target units.
std::vector<double> volumes(const Segmentation& s) {
  std::vector<double> rows(s.phi.size(), 0.0);
  const double cell = s.shape.step * s.shape.step * s.shape.step;
  for (const auto owner : s.owner)
    if (owner >= 0) rows[std::size_t(owner)] += cell;
  return rows;
}

}  // namespace

void bind_segmentation(py::module_& m) {
  py::class_<Segmentation>(m, "Segmentation")
      .def_property_readonly("volumes", &volumes)
      .def_property_readonly("owner", [](const Segmentation& s) { return write_array(s.owner); })
      .def_property_readonly("size", [](const Segmentation& s) { return std::vector<int>{s.shape.size.x(), s.shape.size.y(), s.shape.size.z()}; });

  m.def(
      "grow",
      [](const Character& character, const Target& target, const Embedding& embedding, int threads, const py::object& progress) {
        SegmentationOptions options;
        options.threads = threads;
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return grow(character, target, embedding, options, tell);
      },
      py::arg("character"), py::arg("target"), py::arg("embedding"), py::kw_only(), py::arg("threads") = 0,
      py::arg("progress") = py::none(), "Grows a skin for every bone until they tile the target (Eqs. 6, 7). Raises InvalidInput, Infeasible, Cancelled.");

  m.def(
      "transfer",
      [](const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
         const std::variant<std::string, FoldPath>& ranges, int threads, const py::object& progress) {
        TransferOptions options;
        options.threads = threads;
        const FoldPath* path = std::get_if<FoldPath>(&ranges);
        if (!path && std::get<std::string>(ranges) != "straight") throw InvalidInput("ranges is 'straight' or a FoldPath");
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return transfer(segmentation, character, target, embedding, path ? ranges_of(*path, character) : straight_ranges(character, embedding),
                        options, tell);
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::kw_only(), py::arg("ranges") = "straight",
      py::arg("threads") = 0, py::arg("progress") = py::none(),
      "Mesh transfer at every joint (Eqs. 8 to 11), over the path's ranges or, without one, from the folded angle to rest. Raises InvalidInput, Cancelled.");
}

}  // namespace transformables::bindings
