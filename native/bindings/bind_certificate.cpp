#include "bindings/bindings.h"
#include "finishing/certificate.h"

namespace transformables::bindings {
namespace {

py::list interval_rows(const Certificate& certificate) {
  py::list rows;
  for (const CertifiedInterval& i : certificate.intervals) rows.append(py::make_tuple(i.move, i.bone_a, i.bone_b, i.t0, i.t1, i.bound));
  return rows;
}

const char* word(Uncertified::Reason reason) {
  switch (reason) {
    case Uncertified::Reason::kTouching: return "touching";
    case Uncertified::Reason::kInside: return "inside";
    case Uncertified::Reason::kUnresolved: return "unresolved";
  }
  return "";
}

py::list open_dicts(const Certificate& certificate) {
  py::list rows;
  for (const Uncertified& u : certificate.open) {
    py::dict d;
    d["bone_a"] = u.bone_a;
    d["bone_b"] = u.bone_b;
    d["move"] = u.move;
    d["fraction"] = u.fraction;
    d["distance"] = u.distance;
    d["reason"] = word(u.reason);
    rows.append(d);
  }
  return rows;
}

/// Parts that were made elsewhere: (bone, vertices, triangles) each.
Parts parts_from(const std::vector<std::tuple<int, py::buffer, py::buffer>>& rows) {
  Parts parts;
  for (const auto& [bone, vertices, triangles] : rows) {
    Part& part = parts.parts.emplace_back();
    part.bone = bone;
    part.mesh = {read_points(vertices, "vertices of a part"), read_triples(triangles, "triangles of a part")};
  }
  return parts;
}

Certificate certified(const Parts& parts, const Character& character, const Embedding& embedding, const FoldPath& path, double enough,
                      double least, double tolerance, int threads, const py::object& progress) {
  const CertificateOptions defaults;
  const CertificateOptions options{enough, least, tolerance, defaults.steps, threads};
  const Progress tell = progress_from(progress);
  py::gil_scoped_release release;
  return certify(parts, character, embedding, path, options, tell);
}

}  // namespace

void bind_certificate(py::module_& m) {
  py::class_<Certificate>(m, "Certificate")
      .def_readonly("holds", &Certificate::holds)
      .def_readonly("gap", &Certificate::gap)
      .def_readonly("steps", &Certificate::steps)
      .def_property_readonly("intervals", &interval_rows)
      .def_property_readonly("open", &open_dicts);

  const CertificateOptions o;
  const char* doc =
      "Proves that parts stay apart at all times of a path. intervals: (move, bone_a, bone_b, t0, t1, bound); enough, least: target "
      "units. Raises InvalidInput, Cancelled.";
  m.def("certify", &certified, py::arg("parts"), py::arg("character"), py::arg("embedding"), py::arg("path"), py::kw_only(),
        py::arg("enough") = o.enough, py::arg("least") = o.least, py::arg("tolerance") = o.tolerance, py::arg("threads") = 0,
        py::arg("progress") = py::none(), doc);
  m.def(
      "certify",
      [](const std::vector<std::tuple<int, py::buffer, py::buffer>>& parts, const Character& character, const Embedding& embedding,
         const FoldPath& path, double enough, double least, double tolerance, int threads, const py::object& progress) {
        return certified(parts_from(parts), character, embedding, path, enough, least, tolerance, threads, progress);
      },
      py::arg("parts"), py::arg("character"), py::arg("embedding"), py::arg("path"), py::kw_only(), py::arg("enough") = o.enough,
      py::arg("least") = o.least, py::arg("tolerance") = o.tolerance, py::arg("threads") = 0, py::arg("progress") = py::none(), doc);
}

}  // namespace transformables::bindings
