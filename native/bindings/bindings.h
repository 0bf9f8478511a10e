// What the bindings of all rooms share: arrays and progress across the border between C++ and Python.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/progress.h"

namespace transformables::bindings {

namespace py = pybind11;

/// Copies a buffer of `T` (bytes, memoryview, array or NumPy array: anything with C-contiguous bytes) whose length is a multiple of `width`.
/// @throws InvalidInput when its length does not fit.
template <class T>
std::vector<T> read_array(const py::buffer& buffer, std::size_t width, const char* name) {
  Py_buffer view;
  if (PyObject_GetBuffer(buffer.ptr(), &view, PyBUF_C_CONTIGUOUS) != 0) throw py::error_already_set();
  const std::size_t bytes = std::size_t(view.len);
  if (bytes % (sizeof(T) * width) != 0) {
    PyBuffer_Release(&view);
    throw InvalidInput(std::string(name) + ": " + std::to_string(bytes) + " bytes are no whole number of rows of " +
                       std::to_string(width) + " values of " + std::to_string(sizeof(T)) + " bytes");
  }
  std::vector<T> values(bytes / sizeof(T));
  if (bytes) std::memcpy(values.data(), view.buf, bytes);
  PyBuffer_Release(&view);
  return values;
}

template <class T>
py::bytes write_array(const std::vector<T>& values) {
  return py::bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

inline std::vector<Eigen::Vector3d> read_points(const py::buffer& buffer, const char* name) {
  const auto flat = read_array<double>(buffer, 3, name);
  std::vector<Eigen::Vector3d> points(flat.size() / 3);
  if (!flat.empty()) std::memcpy(static_cast<void*>(points.data()), flat.data(), flat.size() * sizeof(double));
  return points;
}

inline std::vector<Eigen::Vector3i> read_triples(const py::buffer& buffer, const char* name) {
  const auto flat = read_array<std::int32_t>(buffer, 3, name);
  std::vector<Eigen::Vector3i> triples(flat.size() / 3);
  if (!flat.empty()) std::memcpy(static_cast<void*>(triples.data()), flat.data(), flat.size() * sizeof(std::int32_t));
  return triples;
}

/// A 4 x 4 matrix as 16 numbers, column-major.
inline std::vector<double> flat(const Eigen::Isometry3d& frame) {
  const Eigen::Matrix4d m = frame.matrix();
  return {m.data(), m.data() + 16};
}

inline Eigen::Isometry3d frame_from(const std::vector<double>& numbers) {
  if (numbers.size() != 16) throw InvalidInput("a frame is 16 numbers, column-major; got " + std::to_string(numbers.size()));
  Eigen::Isometry3d frame;
  frame.matrix() = Eigen::Map<const Eigen::Matrix4d>(numbers.data());
  return frame;
}

inline std::vector<double> flat(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }
inline Eigen::VectorXd vector_from(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), Eigen::Index(v.size()));
}

/// A Python callable (fraction, note) -> bool, or None, as Progress. Takes the GIL for each call: release it around the work.
inline Progress progress_from(const py::object& callback) {
  if (callback.is_none()) return {};
  // Shared, so that a room may copy its Progress without the GIL.
  return {[shared = std::make_shared<py::object>(callback)](double fraction, std::string_view note) {
    py::gil_scoped_acquire gil;
    return (*shared)(fraction, std::string(note)).cast<bool>();
  }};
}

void bind_character(py::module_& m);
void bind_target(py::module_& m);
void bind_embedding(py::module_& m);
void bind_segmentation(py::module_& m);
void bind_folding(py::module_& m);
void bind_finishing(py::module_& m);
void bind_certificate(py::module_& m);

}  // namespace transformables::bindings
