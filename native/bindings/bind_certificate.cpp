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
    if (u.reason == Uncertified::Reason::kTouching) d["place"] = std::vector<double>(u.on_a.data(), u.on_a.data() + 3);
    rows.append(d);
  }
  return rows;
}

}  // namespace

void bind_certificate(py::module_& m) {
  py::class_<Certificate>(m, "Certificate")
      .def_readonly("holds", &Certificate::holds)
      .def_readonly("gap", &Certificate::gap)
      .def_readonly("steps", &Certificate::steps)
      .def_property_readonly("intervals", &interval_rows)
      .def_property_readonly("open", &open_dicts);
}

}  // namespace transformables::bindings
