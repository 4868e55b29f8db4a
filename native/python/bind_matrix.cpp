// Passes over a stiffness in Python.
#include "matrix/checks.hpp"
#include "python/bindings.hpp"

namespace geodesic {

void bind_matrix(nb::module_& module) {
  module.def(
      "components",
      [](In<Row> indptr, In<Row> indices) {
        const Pattern edges = pattern_of(indptr, indices);
        return give(unlocked([&] { return components(edges); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert());
  module.def(
      "components_of_edges",
      [](In<Index, 2> edges, Index n_vertices) {
        require(edges.shape(1) == 2, "two ends for each edge");
        for (const Index end : span(edges))
          require(0 <= end && end < n_vertices, "ends are vertices");
        return give(unlocked([&] { return components(span(edges), n_vertices); }));
      },
      "edges"_a.noconvert(), "n_vertices"_a);
  module.def(
      "is_sound",
      [](In<Row> indptr, In<Row> indices, In<double> data) {
        const MatrixView stiffness = matrix_of(indptr, indices, data);
        return unlocked([&] { return is_sound(stiffness); });
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "data"_a.noconvert());
  module.def(
      "obtuse_excess",
      [](In<Row> indptr, In<Row> indices, In<double> data, In<double> mass, Index rings) {
        const MatrixView stiffness = matrix_of(indptr, indices, data);
        require(n_rows(mass) == stiffness.size(), "a mass for each row");
        return give(unlocked([&] { return obtuse_excess(stiffness, span(mass), rings); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "data"_a.noconvert(), "mass"_a.noconvert(),
      "rings"_a);
  module.def(
      "diagonal_places",
      [](In<Row> indptr, In<Row> indices) {
        const Pattern pattern = pattern_of(indptr, indices);
        return give(unlocked([&] { return diagonal_places(pattern); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert());
  module.def(
      "plus_diagonal",
      [](In<Row> indptr, In<Row> indices, In<double> data, In<Index> places, In<double> scales,
         In<double> diagonal) {
        const MatrixView matrix = matrix_of(indptr, indices, data);
        require(n_rows(places) == matrix.size() && n_rows(diagonal) == matrix.size() &&
                    (scales.size() == 1 || n_rows(scales) == matrix.size()),
                "a place and a number for each row, and a scale for each or for all");
        return give(unlocked(
            [&] { return plus_diagonal(matrix, span(places), span(scales), span(diagonal)); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "data"_a.noconvert(), "places"_a.noconvert(),
      "scales"_a.noconvert(), "diagonal"_a.noconvert());
  module.def(
      "row_sums",
      [](In<Row> indptr, In<Row> indices, In<double> data) {
        const MatrixView matrix = matrix_of(indptr, indices, data);
        return give(unlocked([&] { return row_sums(matrix); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "data"_a.noconvert());
}

}  // namespace geodesic
