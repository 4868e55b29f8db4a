// Helpers of the binding files: views of arrays without copies, and kernels without the lock.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "core/matrix.hpp"
#include "core/near.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace geodesic {

// Arrays of Python that are read, or written to. nanobind would silently copy one of another type,
// be it one to write to: every argument of such a type is `noconvert()`.
template <class T, int Dimensions = 1>
using In = nb::ndarray<const T, nb::ndim<Dimensions>, nb::c_contig, nb::device::cpu>;
template <class T, int Dimensions = 1>
using Out = nb::ndarray<T, nb::ndim<Dimensions>, nb::c_contig, nb::device::cpu>;
// A column, or a table of them.
using Columns = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

template <class T, class... Traits>
auto span(const nb::ndarray<T, Traits...>& array) {
  return std::span(array.data(), array.size());
}

// Throw ValueError unless an array is as long as others ask for: kernels trust it.
inline void require(bool fits, const char* what) {
  if (!fits) throw std::invalid_argument(std::string("arrays do not fit together: ") + what);
}

// Of arrays of a number of dimensions that is known.
inline Index n_rows(const auto& array) { return static_cast<Index>(array.shape(0)); }
// Of a column, which has one, or a table; nothing else may go to a kernel of columns.
inline Index n_columns(const Columns& columns) {
  require(columns.ndim() == 1 || columns.ndim() == 2, "a column, or a table of them");
  return columns.ndim() == 1 ? 1 : static_cast<Index>(columns.shape(1));
}
bool have_one_shape(const auto& one, const auto& other) {
  return one.ndim() == other.ndim() &&
         std::equal(one.shape_ptr(), one.shape_ptr() + one.ndim(), other.shape_ptr());
}

template <class Work>
auto unlocked(Work work) {
  const nb::gil_scoped_release released;
  return work();
}

// A read-only NumPy array over the memory of an object, which lives as long.
template <class T>
auto view(const Array<T>& array, nb::handle owner) {
  const std::size_t shape[] = {static_cast<std::size_t>(array.size())};
  return nb::ndarray<nb::numpy, const T>(array.data(), 1, shape, owner);
}

// A NumPy array that takes the memory over, of so many columns unless that is 0.
template <class T>
auto give(Array<T> array, Index columns = 0) {
  auto kept = std::make_unique<Array<T>>(std::move(array));
  T* const data = kept->data();
  const auto size = static_cast<std::size_t>(kept->size());
  const auto width = static_cast<std::size_t>(columns);
  const std::size_t shape[] = {columns ? size / width : size, width};
  const nb::capsule owner(kept.get(),
                          [](void* memory) noexcept { delete static_cast<Array<T>*>(memory); });
  (void)kept.release();
  return nb::ndarray<nb::numpy, T>(data, columns ? 2 : 1, shape, owner);
}

inline auto give(Matrix matrix) {
  return nb::make_tuple(give(std::move(matrix.indptr)), give(std::move(matrix.indices)),
                        give(std::move(matrix.data)));
}

inline auto give(NearRows rows) {
  return nb::make_tuple(give(std::move(rows.begins)), give(std::move(rows.vertices)),
                        give(std::move(rows.distances)));
}

// A matrix in compressed rows, whose arrays are checked against each other; their values are not
// checked.
inline Pattern pattern_of(const In<Row>& indptr, const In<Row>& indices) {
  require(indptr.size() > 0 && indptr.data()[0] == 0 &&
              indptr.data()[indptr.size() - 1] == static_cast<Row>(indices.size()),
          "indptr runs from 0 to the number of indices");
  return {span(indptr), span(indices)};
}
inline MatrixView matrix_of(const In<Row>& indptr, const In<Row>& indices, const In<double>& data) {
  require(data.size() == indices.size(), "as many data as indices");
  return {pattern_of(indptr, indices), span(data)};
}

void bind_bounds(nb::module_& module);
void bind_clouds(nb::module_& module);
void bind_errors(nb::module_& module);
void bind_graphs(nb::module_& module);
void bind_heat(nb::module_& module);
void bind_linear(nb::module_& module);
void bind_matrix(nb::module_& module);
void bind_paths(nb::module_& module);
void bind_triangles(nb::module_& module);
void bind_wavefront(nb::module_& module);
void bind_windows(nb::module_& module);

}  // namespace geodesic
