#include <variant>

#include "bindings/bindings.h"
#include "folding/folding.h"
#include "segmentation/division.h"
#include "segmentation/edits.h"
#include "segmentation/seams.h"
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

EditKind kind_from(const std::string& word) {
  if (word == "remove") return EditKind::kRemove;
  if (word == "inhibit") return EditKind::kInhibit;
  if (word == "keep_whole") return EditKind::kKeepWhole;
  if (word == "assign") return EditKind::kAssign;
  if (word == "move_seam") return EditKind::kMoveSeam;
  throw InvalidInput("an edit is remove, inhibit, keep_whole, assign or move_seam, not '" + word + "'");
}

std::vector<Eigen::Vector3d> in_target_frame(const Target& target, std::vector<Eigen::Vector3d> points) {
  for (Eigen::Vector3d& p : points) p = (p - target.centre) * target.scale;
  return points;
}

py::list seam_dicts(const std::vector<Seam>& seams, const Target& target) {
  py::list rows;
  for (const Seam& seam : seams) {
    std::vector<double> numbers;
    for (const Eigen::Vector3d& p : seam.points) {
      const Eigen::Vector3d q = p / target.scale + target.centre;
      numbers.insert(numbers.end(), q.data(), q.data() + 3);
    }
    py::dict d;
    d["bone_a"] = seam.bone_a;
    d["bone_b"] = seam.bone_b;
    d["closed"] = seam.closed;
    d["points"] = write_array(numbers);
    rows.append(d);
  }
  return rows;
}

py::dict division_dict(const Division& parts, const Target& target) {
  std::vector<double> numbers;
  for (const Eigen::Vector3d& p : parts.mesh.vertices) {
    const Eigen::Vector3d q = p / target.scale + target.centre;
    numbers.insert(numbers.end(), q.data(), q.data() + 3);
  }
  std::vector<std::int32_t> corners;
  for (const Eigen::Vector3i& t : parts.mesh.triangles) corners.insert(corners.end(), t.data(), t.data() + 3);
  py::dict d;
  d["vertices"] = write_array(numbers);
  d["triangles"] = write_array(corners);
  d["bones"] = write_array(std::vector<std::int32_t>(parts.bones.begin(), parts.bones.end()));
  return d;
}

/// @param painted           triangles' corners, 9 float64 each, Blender units
/// @param from_points, to_points  3 float64 each, Blender units
Edit edit_from(const Target& target, const std::string& kind, const std::string& bone, const std::string& other, const std::string& name, double reach,
               const py::buffer& painted, const py::buffer& from_points, const py::buffer& to_points) {
  Edit edit;
  edit.kind = kind_from(kind);
  edit.bone = bone;
  edit.other = other;
  edit.name = name;
  edit.reach = reach;
  edit.from = in_target_frame(target, read_points(from_points, "from_points"));
  edit.to = in_target_frame(target, read_points(to_points, "to_points"));
  const auto numbers = read_array<double>(painted, 9, "painted");
  for (std::size_t i = 0; i < numbers.size(); i += 9) {
    auto& triangle = edit.painted.emplace_back();
    for (int k = 0; k < 3; ++k)
      triangle[k] = (Eigen::Map<const Eigen::Vector3d>(&numbers[i + 3 * std::size_t(k)]) - target.centre) * target.scale;
  }
  return edit;
}

TransferMethod method_from(const std::string& word) {
  if (word == "auto") return TransferMethod::kBetter;
  if (word == "cylinder") return TransferMethod::kCylinder;
  if (word == "exact") return TransferMethod::kExact;
  throw InvalidInput("transfer's method is 'auto', 'cylinder' or 'exact', not '" + word + "'");
}

TransferDirection direction_from(const std::string& word) {
  if (word == "to_parent") return TransferDirection::kChildToParent;
  if (word == "to_child") return TransferDirection::kParentToChild;
  throw InvalidInput("transfer's direction is 'to_parent' or 'to_child', not '" + word + "'");
}

}  // namespace

void bind_segmentation(py::module_& m) {
  py::class_<Segmentation>(m, "Segmentation")
      .def_property_readonly("volumes", &volumes)
      .def_property_readonly("pinned", [](const Segmentation& s) { return write_array(s.pinned); })
      .def_property_readonly("inhibited", [](const Segmentation& s) { return std::vector<bool>(s.inhibited.begin(), s.inhibited.end()); })
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
         const std::variant<std::string, FoldPath>& ranges, const std::string& method, const std::map<int, std::string>& direction_of, bool round_off,
         int threads, const py::object& progress) {
        TransferOptions options;
        options.round_off = round_off;
        options.threads = threads;
        options.method = method_from(method);
        for (const auto& [bone, word] : direction_of) options.direction_of[bone] = direction_from(word);
        const FoldPath* path = std::get_if<FoldPath>(&ranges);
        if (!path && std::get<std::string>(ranges) != "straight") throw InvalidInput("ranges is 'straight' or a FoldPath");
        const Progress tell = progress_from(progress);
        py::gil_scoped_release release;
        return transfer(segmentation, character, target, embedding, path ? ranges_of(*path, character) : straight_ranges(character, embedding), options, tell);
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::kw_only(), py::arg("ranges") = "straight",
      py::arg("method") = "auto", py::arg("direction_of") = std::map<int, std::string>{}, py::arg("round_off") = TransferOptions{}.round_off, py::arg("threads") = 0,
      py::arg("progress") = py::none(),
      "Mesh transfer at every joint (Eqs. 8 to 11), over the path's ranges or, without one, from the folded angle to rest. method: 'auto' (the better), 'cylinder' or "
      "'exact'; direction_of: 'to_parent' or 'to_child' by the joint's child, else whichever moves less; without round_off interfaces stay rough. Raises InvalidInput, Cancelled.");

  py::class_<Edit>(m, "Edit").def_readonly("bone", &Edit::bone).def_readonly("name", &Edit::name);
  m.def("make_edit", &edit_from, py::arg("target"), py::kw_only(), py::arg("kind"), py::arg("bone") = "", py::arg("other") = "",
        py::arg("name") = "", py::arg("reach") = 0.0, py::arg("painted") = py::bytes(), py::arg("from_points") = py::bytes(),
        py::arg("to_points") = py::bytes(),
        "An artist's edit: remove, inhibit (reach: target units), keep_whole, assign (painted: n x 9 float64, corners of triangles in Blender units) or "
        "move_seam (from_points, to_points: n x 3 float64, Blender units). Raises InvalidInput.");
  m.def(
      "seams",
      [](const Segmentation& segmentation, const Target& target) {
        std::vector<Seam> seams;
        {
          py::gil_scoped_release release;
          seams = traced_seams(segmentation, target);
        }
        return seam_dicts(seams, target);
      },
      py::arg("segmentation"), py::arg("target"),
      "Where parts meet on the target's surface (Eq. 12): dicts of bone_a, bone_b, closed, points (n x 3 float64, Blender units). Raises InvalidInput.");
  m.def(
      "division",
      [](const Segmentation& segmentation, const Target& target, double spacing) {
        Division parts;
        {
          py::gil_scoped_release release;
          parts = division(segmentation, target, spacing);
        }
        return division_dict(parts, target);
      },
      py::arg("segmentation"), py::arg("target"), py::kw_only(), py::arg("spacing") = 1.0,
      "The target's surface, no edge longer than the spacing (steps of the grid), and the bone at each vertex or -1: a dict of vertices (n x 3 float64, "
      "Blender units), triangles (m x 3 int32), bones (n int32). Raises InvalidInput.");
  m.def(
      "edited",
      [](const Segmentation& segmentation, const Character& character, const Target& target, const Embedding& embedding,
         const std::vector<Edit>& edits, int threads) {
        EditReport report;
        py::gil_scoped_release release;
        Segmentation result = edited(segmentation, character, target, embedding, edits, &report, threads);
        return std::pair(std::move(result), std::move(report));
      },
      py::arg("segmentation"), py::arg("character"), py::arg("target"), py::arg("embedding"), py::arg("edits"), py::kw_only(), py::arg("threads") = 0,
      "The segmentation with edits replayed on it, and a list of lines on what could not be done. Raises InvalidInput.");
}

}  // namespace transformables::bindings
