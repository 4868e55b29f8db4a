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
}

}  // namespace geodesic
