// Passes over triangles in Python.
#include <limits>

#include "python/bindings.hpp"
#include "triangles/flips.hpp"
#include "triangles/half_edges.hpp"
#include "triangles/measures.hpp"
#include "triangles/proper.hpp"
#include "triangles/stiffness.hpp"

namespace geodesic {
namespace {

// Throw unless tables have three columns and as many rows.
void require_triangles(const In<Index, 2>& faces, const auto&... tables) {
  require(faces.shape(1) == 3 && ((tables.size() == faces.size()) && ...),
          "three columns, and a row for each triangle");
}

}  // namespace

void bind_triangles(nb::module_& module) {
  module.def(
      "proper_faces",
      [](In<Index, 2> faces, Index n_vertices) {
        require_triangles(faces);
        require(n_vertices >= 0, "a number of vertices");
        return give(unlocked([&] { return proper_faces(span(faces), n_vertices); }));
      },
      "faces"_a.noconvert(), "n_vertices"_a);
  module.def(
      "faces_at",
      [](In<Index, 2> faces, In<bool> marked) {
        require_triangles(faces);
        return give(unlocked([&] { return faces_at(span(faces), span(marked)); }));
      },
      "faces"_a.noconvert(), "marked"_a.noconvert());
  module.def(
      "measure_triangles",
      [](In<double, 2> vertices, In<Index, 2> faces) {
        require_triangles(faces);
        require(vertices.shape(1) == 3, "three coordinates for each vertex");
        Measured its = unlocked([&] { return measure_triangles(span(vertices), span(faces)); });
        return nb::make_tuple(give(std::move(its.triangles.frames), 3),
                              give(std::move(its.triangles.areas)), its.total, its.slack);
      },
      "vertices"_a.noconvert(), "faces"_a.noconvert());
  module.def(
      "measure_lengths",
      [](In<double, 2> lengths) {
        require(lengths.shape(1) == 3, "three lengths for each triangle");
        Measures triangles = unlocked([&] { return measure_lengths(span(lengths)); });
        return nb::make_tuple(give(std::move(triangles.frames), 3),
                              give(std::move(triangles.areas)));
      },
      "lengths"_a.noconvert());
  module.def(
      "edge_lengths",
      [](In<double, 2> frames) {
        require(frames.shape(1) == 3, "three numbers for each frame");
        return give(unlocked([&] { return edge_lengths(span(frames)); }), 3);
      },
      "frames"_a.noconvert());
  nb::class_<HalfEdges>(module, "HalfEdges")
      .def_prop_ro("n_vertices", &HalfEdges::n_vertices)
      .def("twins", [](const HalfEdges& self) {
        Twins its = unlocked([&] { return twins(self); });
        return nb::make_tuple(give(std::move(its.of)), its.coherent);
      });
  module.def(
      "sorted_half_edges",
      [](In<Index, 2> faces, Index n_vertices) {
        require_triangles(faces);
        constexpr Index most = std::numeric_limits<Row>::max();
        require(Index(faces.size()) <= most && 0 <= n_vertices && n_vertices < most,
                "fewer half-edges and vertices than 32 bits count");
        return unlocked([&] { return sorted_half_edges(span(faces), n_vertices); });
      },
      "faces"_a.noconvert(), "n_vertices"_a);
  module.def(
      "edge_sums",
      [](In<Index, 2> faces, const HalfEdges& half_edges, In<double, 2> frames,
         In<double> measure) {
        require_triangles(faces, frames);
        require(measure.size() == faces.shape(0) && half_edges.halves.size() == Index(faces.size()),
                "a measure for each triangle, and their half-edges");
        EdgeSums sums = unlocked(
            [&] { return edge_sums(span(faces), half_edges, span(frames), span(measure)); });
        return nb::make_tuple(give(std::move(sums.edges)), give(std::move(sums.lumped_mass)),
                              give(std::move(sums.boundary)));
      },
      "faces"_a.noconvert(), "half_edges"_a, "frames"_a.noconvert(), "measure"_a.noconvert());
  module.def(
      "mirrored",
      [](In<Row> indptr, In<Row> indices, In<double> data) {
        const MatrixView edges = matrix_of(indptr, indices, data);
        return give(unlocked([&] { return mirrored(edges); }));
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert(), "data"_a.noconvert());
  module.def(
      "mean_edge_length",
      [](In<double, 2> vertices, In<Row> indptr, In<Row> indices) {
        const Pattern edges = pattern_of(indptr, indices);
        require(vertices.shape(1) == 3 && n_rows(vertices) == edges.size(),
                "a row for each vertex");
        return unlocked([&] { return mean_edge_length(span(vertices), edges); });
      },
      "vertices"_a.noconvert(), "indptr"_a.noconvert(), "indices"_a.noconvert());
  module.def(
      "flip_edges",
      [](Out<Index, 2> faces, Out<double, 2> lengths, Out<Index> twin, In<bool> held) {
        require(
            faces.shape(1) == 3 && lengths.size() == faces.size() && twin.size() == faces.size(),
            "a length and a twin for each half-edge");
        return unlocked(
            [&] { return flip_edges(span(faces), span(lengths), span(twin), span(held)); });
      },
      "faces"_a.noconvert(), "lengths"_a.noconvert(), "twin"_a.noconvert(), "held"_a.noconvert());
}

}  // namespace geodesic
