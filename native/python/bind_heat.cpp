// The steps of the heat method between its solves, in Python.
#include "heat/connection.hpp"
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
  module.def(
      "connection_laplacian",
      [](In<Row> indptr, In<Row> indices, In<Index, 2> elements, In<double, 2> frames,
         In<double> measure, In<double, 2> turns) {
        const Pattern pattern = pattern_of(indptr, indices);
        require(elements.shape(1) == 3 && frames.size() == elements.size() &&
                    measure.size() == elements.shape(0) && turns.size() == 2 * elements.size(),
                "a frame, a measure and three turns for each triangle");
        std::optional<Array<double>> entries = unlocked([&] {
          return connection_laplacian(pattern, span(elements), span(frames), span(measure),
                                      span(turns));
        });
        return entries ? nb::cast(give(*std::move(entries), 2)) : nb::object(nb::none());
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "elements"_a.noconvert(),
      "frames"_a.noconvert(), "measure"_a.noconvert(), "turns"_a.noconvert());
  module.def(
      "edge_turns",
      [](In<Row> indptr, In<Row> indices, In<Index, 2> elements, In<double, 2> turns) {
        const Pattern pattern = pattern_of(indptr, indices);
        require(turns.size() == 2 * elements.size(), "a turn for each corner");
        const auto size = static_cast<int>(elements.shape(1));
        return give(
            unlocked([&] { return edge_turns(pattern, span(elements), size, span(turns)); }), 2);
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "elements"_a.noconvert(),
      "turns"_a.noconvert());
  module.def(
      "real_form",
      [](In<Row> indptr, In<Row> indices, In<double, 2> entries, In<double> scale,
         In<double> diagonal) {
        const Pattern pattern = pattern_of(indptr, indices);
        require(n_rows(entries) == count(pattern.indices) && entries.shape(1) == 2 &&
                    n_rows(scale) == pattern.size() && n_rows(diagonal) == pattern.size(),
                "two numbers for each entry, and two for each row");
        return give(unlocked(
            [&] { return real_form(pattern, span(entries), span(scale), span(diagonal)); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "entries"_a.noconvert(),
      "scale"_a.noconvert(), "diagonal"_a.noconvert());
  module.def(
      "polar_form",
      [](In<double, 2> pairs) {
        require(pairs.shape(1) == 2, "two parts of each number");
        Polar its = unlocked([&] { return polar_form(span(pairs)); });
        return nb::make_tuple(give(std::move(its.sizes)), give(std::move(its.directions), 2));
      },
      "pairs"_a.noconvert());
}

}  // namespace geodesic
