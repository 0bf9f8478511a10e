#include "bindings/bindings.h"

using namespace transformables;
namespace py = pybind11;

PYBIND11_MODULE(transformables_native, m) {
  m.doc() = "Transformables: characters that fold up into objects. The rooms of the design, one after the other.";
  m.attr("version") = TRANSFORMABLES_VERSION;
  py::register_exception<InvalidInput>(m, "InvalidInput", PyExc_ValueError);
  py::register_exception<Infeasible>(m, "Infeasible", PyExc_RuntimeError);
  py::register_exception<Cancelled>(m, "Cancelled", PyExc_RuntimeError);
  bindings::bind_character(m);
  bindings::bind_target(m);
  bindings::bind_embedding(m);
  bindings::bind_segmentation(m);
  bindings::bind_folding(m);
  bindings::bind_finishing(m);
  bindings::bind_certificate(m);
}
