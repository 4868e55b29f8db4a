// Passes over triangles in Python.
#include <limits>

#include "python/bindings.hpp"
#include "triangles/flips.hpp"
#include "triangles/frames.hpp"
#include "triangles/half_edges.hpp"
#include "triangles/measures.hpp"
#include "triangles/normals.hpp"
#include "triangles/proper.hpp"
#include "triangles/stiffness.hpp"

namespace geodesic {
namespace {

// Throw unless tables have three columns and as many rows.
void require_triangles(const In<Index, 2>& faces, const auto&... tables) {
  require(faces.shape(1) == 3 && ((tables.size() == faces.size()) && ...),
          "three columns, and a row for each triangle");
}

void bind_frames(nb::module_& module) {
  module.def(
      "vertex_normals",
      [](In<double, 2> vertices, In<Index, 2> faces, int n_threads) {
        require_triangles(faces);
        require(vertices.shape(1) == 3, "three coordinates for each vertex");
        require(n_threads > 0, "at least one thread");
        return give(
            unlocked([&] { return vertex_normals(span(vertices), span(faces), n_threads); }), 3);
      },
      "vertices"_a.noconvert(), "faces"_a.noconvert(), "n_threads"_a = 1);
  module.def(
      "tangent_axes",
      [](In<double, 2> normals) {
        require(normals.shape(1) == 3, "three coordinates for each normal");
        return give(unlocked([&] { return tangent_axes(span(normals)); }), 3);
      },
      "normals"_a.noconvert());
  module.def(
      "unit_vectors",
      [](In<double> angles) {
        return give(unlocked([&] { return unit_vectors(span(angles)); }), 2);
      },
      "angles"_a.noconvert());
  module.def(
      "to_space",
      [](In<double, 2> pairs, In<double, 2> x_axes, In<double, 2> y_axes) {
        require(pairs.shape(1) == 2 && x_axes.shape(1) == 3 && n_rows(x_axes) == n_rows(pairs) &&
                    have_one_shape(x_axes, y_axes),
                "two coordinates and two axes for each vector");
        return give(unlocked([&] { return to_space(span(pairs), span(x_axes), span(y_axes)); }), 3);
      },
      "pairs"_a.noconvert(), "x_axes"_a.noconvert(), "y_axes"_a.noconvert());
  module.def(
      "polar_directions",
      [](In<double, 2> vertices, In<Index, 2> faces, In<double, 2> lengths, In<Index> twin,
         In<bool> mirrored, In<double, 2> normals, In<double, 2> axes) {
        require_triangles(faces, lengths, twin);
        require(Index(mirrored.size()) == n_rows(faces) && vertices.shape(1) == 3 &&
                    have_one_shape(vertices, normals) && have_one_shape(vertices, axes),
                "a flag for each triangle, a normal and an axis for each vertex");
        Directions its = unlocked([&] {
          return polar_directions(span(vertices), span(faces), span(lengths), span(twin),
                                  span(mirrored), span(normals), span(axes));
        });
        return nb::make_tuple(give(std::move(its.angles)), give(std::move(its.scales)));
      },
      "vertices"_a.noconvert(), "faces"_a.noconvert(), "lengths"_a.noconvert(),
      "twin"_a.noconvert(), "mirrored"_a.noconvert(), "normals"_a.noconvert(),
      "axes"_a.noconvert());
  module.def(
      "bisectors",
      [](In<double, 2> lengths, In<double> angles, In<double> scales) {
        require(lengths.shape(1) == 3 && angles.size() == lengths.size() &&
                    scales.size() == lengths.size(),
                "a direction for each half-edge");
        return give(unlocked([&] { return bisectors(span(lengths), span(angles), span(scales)); }),
                    3);
      },
      "lengths"_a.noconvert(), "angles"_a.noconvert(), "scales"_a.noconvert());
  module.def(
      "triangle_turns",
      [](In<double, 2> lengths, In<double, 2> directions, In<bool> mirrored) {
        require(lengths.shape(1) == 3 && have_one_shape(lengths, directions) &&
                    Index(mirrored.size()) == n_rows(lengths),
                "a direction for each corner and a flag for each triangle");
        return give(unlocked([&] {
                      return triangle_turns(span(lengths), span(directions), span(mirrored));
                    }),
                    6);
      },
      "lengths"_a.noconvert(), "directions"_a.noconvert(), "mirrored"_a.noconvert());
  module.def(
      "space_turns",
      [](In<double, 2> places, In<Index, 2> elements, In<double, 2> normals, In<double, 2> axes,
         bool stars) {
        require(
            places.shape(1) == 3 && have_one_shape(places, normals) && have_one_shape(places, axes),
            "three coordinates, a normal and an axis for each vertex");
        const auto size = static_cast<int>(elements.shape(1));
        require(size == 2 || size == 3, "elements of two or three vertices");
        SpaceTurns its = unlocked([&] {
          return space_turns(span(places), span(elements), size, span(normals), span(axes), stars);
        });
        return nb::make_tuple(give(std::move(its.turns), 2 * size), give(std::move(its.mirrored)));
      },
      "places"_a.noconvert(), "elements"_a.noconvert(), "normals"_a.noconvert(),
      "axes"_a.noconvert(), "stars"_a);
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
  module.def(
      "flip_edges_with_directions",
      [](Out<Index, 2> faces, Out<double, 2> lengths, Out<Index> twin, In<bool> held,
         Out<double> angles, Out<double> scales) {
        require(faces.shape(1) == 3 && lengths.size() == faces.size() &&
                    twin.size() == faces.size() && angles.size() == faces.size() &&
                    scales.size() == faces.size(),
                "a length, a twin and a direction for each half-edge");
        return unlocked([&] {
          return flip_edges(span(faces), span(lengths), span(twin), span(held), span(angles),
                            span(scales));
        });
      },
      "faces"_a.noconvert(), "lengths"_a.noconvert(), "twin"_a.noconvert(), "held"_a.noconvert(),
      "angles"_a.noconvert(), "scales"_a.noconvert());
  bind_frames(module);
}

}  // namespace geodesic
