// The steps of the heat method between its solves, in Python.
#include "heat/filling.hpp"
#include "heat/poisson_load.hpp"
#include "python/bindings.hpp"

namespace geodesic {

void bind_heat(nb::module_& module) {
  module.def(
      "poisson_load",
      [](In<Index, 2> faces, In<double, 2> frames, In<double> measure, Columns heat,
         bool logarithmic) {
        require(faces.shape(1) == 3 && frames.size() == faces.size() &&
                    measure.size() == faces.shape(0),
                "a frame and a measure for each triangle");
        const Triangles triangles{span(faces), span(frames), span(measure)};
        const Index columns = n_columns(heat);
        Array<double> load =
            unlocked([&] { return poisson_load(triangles, span(heat), columns, logarithmic); });
        return give(std::move(load), heat.ndim() == 1 ? 0 : columns);
      },
      "faces"_a.noconvert(), "frames"_a.noconvert(), "measure"_a.noconvert(), "heat"_a.noconvert(),
      "logarithmic"_a);
  module.def(
      "fill",
      [](In<Row> indptr, In<Row> indices, In<double> data,
         nb::ndarray<double, nb::ndim<1>, nb::device::cpu> solution, Out<Row> rows) {
        const MatrixView matrix = matrix_of(indptr, indices, data);
        require(n_rows(solution) == matrix.size(), "a value for each row");
        const Index stride = solution.size() > 1 ? solution.stride(0) : 1;
        require(stride > 0, "values from first to last");
        const std::span<double> values(solution.data(),
                                       solution.size() ? 1 + (solution.size() - 1) * stride : 0);
        unlocked([&] { fill(matrix, values, stride, span(rows)); });
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "data"_a.noconvert(),
      "solution"_a.noconvert(), "rows"_a.noconvert());
}

}  // namespace geodesic
