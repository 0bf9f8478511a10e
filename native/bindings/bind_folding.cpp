#include "folding/folding.h"

#include "bindings/bindings.h"

namespace transformables::bindings {
namespace {

using TurnTuple = std::tuple<int, double, double>;

std::vector<std::vector<TurnTuple>> moves_of(const FoldPath& path) {
  std::vector<std::vector<TurnTuple>> rows;
  for (const Move& move : path.moves) {
    auto& row = rows.emplace_back();
    for (const auto& turn : move.turns) row.emplace_back(turn.angle, turn.from_rad, turn.to_rad);
  }
  return rows;
}

FoldPath path_from(const std::vector<std::vector<TurnTuple>>& rows) {
  FoldPath path;
  for (const auto& row : rows) {
    auto& move = path.moves.emplace_back();
    for (const auto& [angle, from, to] : row) move.turns.push_back({angle, from, to});
  }
  return path;
}

}  // namespace

py::list collision_dicts(const std::vector<Collision>& collisions) {
  py::list rows;
  for (const Collision& c : collisions) {
    py::dict d;
    d["bone_a"] = c.bone_a;
    d["bone_b"] = c.bone_b;
    d["move"] = c.move;
    d["fraction"] = c.fraction;
    d["volume"] = c.volume;
    d["swept"] = c.swept;
    if (c.place) d["place"] = std::vector<double>(c.place->data(), c.place->data() + 3);
    rows.append(d);
  }
  return rows;
}

void bind_folding(py::module_& m) {
  py::class_<FoldPath>(m, "FoldPath")
      .def(py::init(&path_from), py::kw_only(), py::arg("moves"))
      .def_property_readonly("moves", &moves_of)
      .def_property_readonly("collisions", [](const FoldPath& p) { return collision_dicts(p.collisions); })
      .def_readonly("overlap_volume", &FoldPath::overlap_volume)
      .def_readonly("cut_short", &FoldPath::cut_short);

  py::class_<Folding>(m, "Folding")
      .def_readonly("path", &Folding::path)
      .def_readonly("segmentation", &Folding::segmentation)
      .def_readonly("carving_before", &Folding::carving_before)
      .def_readonly("carving_after", &Folding::carving_after);

  m.def(
      "fold",
      [](const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding, int rounds,
         int expansions, double seconds, bool round_off, int threads, const py::object& progress) {
        FoldingOptions options;
        options.rounds = rounds;
        options.expansions = expansions;
        options.seconds = seconds;
        options.round_off = round_off;
        options.threads = threads;
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return fold(segmentation, character, target, embedding, options, tell);
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::kw_only(),
      py::arg("rounds") = FoldingOptions{}.rounds, py::arg("expansions") = FoldingOptions{}.expansions, py::arg("seconds") = FoldingOptions{}.seconds,
      py::arg("round_off") = FoldingOptions{}.round_off, py::arg("threads") = 0, py::arg("progress") = py::none(),
      "The order in which the joints unfold, and the segmentation made to go with it; rounds and expansions bound the search, seconds "
      "cut it short; without round_off interfaces stay rough, which is enough to compare poses. Raises InvalidInput, Cancelled.");

  m.def(
      "plan_greedy",
      [](const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding, int threads,
         const py::object& progress) {
        FoldingOptions options;
        options.threads = threads;
        options.cost = MoveCost::kNetOverlap;
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return plan_greedy(segmentation, character, target, embedding, options, tell);
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::kw_only(), py::arg("threads") = 0,
      py::arg("progress") = py::none(), "The paper's greedy order at the paper's cost (Eq. 11), to compare with. Raises InvalidInput, Cancelled.");

  m.def(
      "transfer_along",
      [](const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding, const FoldPath& path,
         int threads, const py::object& progress) {
        FoldingOptions options;
        options.threads = threads;
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return transfer_along(segmentation, character, target, embedding, path, options, tell);
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::arg("path"), py::kw_only(),
      py::arg("threads") = 0, py::arg("progress") = py::none(),
      "Hands colliding material to parts that can carry it along the path; the whole volume stays. Raises InvalidInput, Cancelled.");
}

}  // namespace transformables::bindings
