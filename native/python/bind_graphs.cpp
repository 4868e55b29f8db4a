// Fronts across the corners of graphs in Python.
#include "graphs/fronts.hpp"
#include "python/bindings.hpp"

namespace geodesic {
namespace {

void require_sets(const In<Index>& begins, const In<Index>& vertices, const In<double>& starts,
                  Index n_sets, Index n_vertices) {
  require(n_rows(begins) == n_sets + 1, "a row for each set");
  require(vertices.size() == starts.size(), "a start for each vertex");
  const auto order = span(begins);
  require(std::ranges::is_sorted(order) && order.front() == 0 && order.back() == n_rows(vertices),
          "begins run from 0 to the number of vertices");
  require(std::ranges::all_of(span(vertices), [=](Index v) { return 0 <= v && v < n_vertices; }),
          "vertices below their number");
}

}  // namespace

void bind_graphs(nb::module_& module) {
  nb::class_<GraphCorners>(module, "GraphCorners")
      .def(
          "__init__",
          [](GraphCorners* self, Index n_vertices, In<Index, 2> edges, In<double> lengths) {
            require(edges.shape(1) == 2 && edges.shape(0) == lengths.shape(0),
                    "two ends and a length for each edge");
            require(
                std::ranges::all_of(span(edges), [=](Index v) { return 0 <= v && v < n_vertices; }),
                "edges between vertices below their number");
            require(std::ranges::all_of(span(lengths), [](double length) { return length > 0; }),
                    "positive lengths");
            const nb::gil_scoped_release released;
            new (self) GraphCorners(corners_of(n_vertices, span(edges), span(lengths)));
          },
          "n_vertices"_a, "edges"_a.noconvert(), "lengths"_a.noconvert())
      .def_prop_ro(
          "n_corners",
          [](const GraphCorners& self) { return static_cast<Index>(self.other.size()) / 2; })
      .def_prop_ro("covered", [](const GraphCorners& self) { return self.covered; })
      .def_prop_ro("growth", [](const GraphCorners& self) { return self.growth; })
      .def_prop_ro("closed", [](const GraphCorners& self) { return self.closed; })
      .def_prop_ro("lattice", [](const GraphCorners& self) { return self.lattice; })
      .def_prop_ro("nbytes",
                   [](const GraphCorners& self) {
                     const auto bytes = [](const auto& values) {
                       return values.size() * sizeof(values[0]);
                     };
                     return bytes(self.starts) + bytes(self.ends) + bytes(self.lengths) +
                            bytes(self.back) + bytes(self.begins) + bytes(self.other) +
                            bytes(self.across) + bytes(self.reaches);
                   })
      .def(
          "cross",
          [](const GraphCorners& self, In<Index> begins, In<Index> vertices, In<double> starts,
             Out<double, 2> distances, int n_threads) {
            const Index n = self.n_vertices();
            require(static_cast<Index>(distances.shape(1)) == n, "a column for each vertex");
            require_sets(begins, vertices, starts, n_rows(distances), n);
            unlocked([&] {
              cross_corners(self, span(begins), span(vertices), span(starts), span(distances),
                            n_threads);
            });
          },
          "begins"_a.noconvert(), "vertices"_a.noconvert(), "starts"_a.noconvert(),
          "distances"_a.noconvert(), "n_threads"_a)
      .def(
          "cross_near",
          [](const GraphCorners& self, In<Index> begins, In<Index> vertices, In<double> starts,
             In<double> limits, int n_threads) {
            require_sets(begins, vertices, starts, n_rows(limits), self.n_vertices());
            return give(unlocked([&] {
              return cross_corners_near(self, span(begins), span(vertices), span(starts),
                                        span(limits), n_threads);
            }));
          },
          "begins"_a.noconvert(), "vertices"_a.noconvert(), "starts"_a.noconvert(),
          "limits"_a.noconvert(), "n_threads"_a);
}

}  // namespace geodesic
