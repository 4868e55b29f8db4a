// Shortest paths over triangles in Python.
#include <nanobind/stl/optional.h>

#include "paths/candidates.hpp"
#include "paths/chains.hpp"
#include "paths/shortest_loops.hpp"
#include "paths/straight.hpp"
#include "python/bindings.hpp"

namespace geodesic {
namespace {

Array<Index> array_of(const std::vector<Index>& numbers) {
  Array<Index> result(static_cast<Index>(numbers.size()));
  std::ranges::copy(numbers, result.begin());
  return result;
}

nb::tuple give(const std::vector<Crossing>& points) {
  const auto n = static_cast<Index>(points.size());
  Array<Index> faces(n), ends(2 * n);
  Array<double> shares(n);
  for (Index i = 0; i < n; ++i) {
    const Crossing& at = points[static_cast<std::size_t>(i)];
    faces[i] = at.face, ends[2 * i] = at.left, ends[2 * i + 1] = at.right, shares[i] = at.share;
  }
  return nb::make_tuple(give(std::move(faces)), give(std::move(ends), 2), give(std::move(shares)));
}

}  // namespace

void bind_paths(nb::module_& module) {
  nb::class_<Surface>(module, "Surface")
      .def(
          "__init__",
          [](Surface* self, In<double, 2> vertices, In<Index, 2> faces) {
            const Index n = n_rows(vertices);
            require(vertices.shape(1) == 3 && faces.shape(1) == 3, "three numbers in each row");
            require(std::ranges::all_of(span(faces), [n](Index v) { return 0 <= v && v < n; }),
                    "corners of faces below the number of vertices");
            unlocked([&] { new (self) Surface(span(vertices), span(faces)); });
          },
          "vertices"_a.noconvert(), "faces"_a.noconvert(), nb::keep_alive<1, 2>(),
          nb::keep_alive<1, 3>());
  module.def(
      "best_path",
      [](const Surface& surface, In<double> height, In<double> back, Index start, In<Index> ends) {
        const Index n = surface.n_vertices();
        require(n_rows(height) == n && n_rows(back) == n, "two distances for each vertex");
        const auto is_vertex = [n](Index v) { return 0 <= v && v < n; };
        require(is_vertex(start) && std::ranges::all_of(span(ends), is_vertex),
                "a start and ends below the number of vertices");
        return give(unlocked(
            [&] { return best_path(surface, span(height), span(back), start, span(ends)); }));
      },
      "surface"_a, "height"_a.noconvert(), "back"_a.noconvert(), "start"_a, "ends"_a.noconvert());
  module.def(
      "straight_lines",
      [](In<double, 2> lengths, In<Index> twin, In<Index> faces, In<double, 2> weights,
         In<double> angles, In<double> distances, Index most) {
        require(lengths.shape(1) == 3 && twin.size() == lengths.size(),
                "a twin for each half-edge");
        require(weights.shape(1) == 3 && weights.shape(0) == faces.size() &&
                    angles.size() == faces.size() && distances.size() == faces.size(),
                "a place, a direction and a length for each line");
        const Index n = n_rows(lengths);
        require(std::ranges::all_of(span(faces), [n](Index f) { return 0 <= f && f < n; }),
                "faces below their number");
        StraightLines lines = unlocked([&] {
          return straight_lines(span(lengths), span(twin), span(faces), span(weights), span(angles),
                                span(distances), most);
        });
        return nb::make_tuple(give(std::move(lines.begins)), give(std::move(lines.faces)),
                              give(std::move(lines.weights), 3), give(std::move(lines.missing)));
      },
      "lengths"_a.noconvert(), "twin"_a.noconvert(), "faces"_a.noconvert(), "weights"_a.noconvert(),
      "angles"_a.noconvert(), "distances"_a.noconvert(), "most"_a);
  module.def(
      "geodesic_through",
      [](In<double, 2> vertices, In<Index, 2> faces, In<Index> stops, bool closed, bool held,
         double min_length) {
        const Index n = n_rows(vertices);
        require(vertices.shape(1) == 3 && faces.shape(1) == 3, "three numbers in each row");
        const auto is_vertex = [n](Index v) { return 0 <= v && v < n; };
        require(stops.size() > 1 && std::ranges::all_of(span(stops), is_vertex),
                "two stops or more below the number of vertices");
        const Drawn drawn = unlocked([&] {
          const Surface surface(span(vertices), span(faces));
          return geodesic_through(
              surface, {{span(stops).begin(), span(stops).end()}, closed, held, min_length});
        });
        return nb::make_tuple(give(drawn.points), drawn.unreached);
      },
      "vertices"_a.noconvert(), "faces"_a.noconvert(), "stops"_a.noconvert(), nb::kw_only(),
      "closed"_a, "held"_a, "min_length"_a);
  module.def(
      "shortest_loop",
      [](In<double, 2> vertices, In<Index, 2> faces, std::optional<Index> vertex, double min_hole) {
        const Index n = n_rows(vertices);
        require(vertices.shape(1) == 3 && faces.shape(1) == 3, "three numbers in each row");
        require(!vertex || (0 <= *vertex && *vertex < n), "a vertex below their number");
        const ShortestLoop loop = unlocked([&] {
          const Surface surface(span(vertices), span(faces));
          return vertex ? shortest_loop_through(surface, *vertex, min_hole)
                        : shortest_loop_anywhere(surface, min_hole);
        });
        return nb::make_tuple(give(loop.line.points), loop.unclear[0], loop.unclear[1]);
      },
      "vertices"_a.noconvert(), "faces"_a.noconvert(), "vertex"_a = nb::none(), nb::kw_only(),
      "min_hole"_a = 0.0);
  module.def(
      "distinct_triangles",
      [](In<Index, 2> elements) {
        require(elements.shape(1) == 3, "three vertices for each element");
        const Distinct found = unlocked([&] { return distinct_triangles(span(elements)); });
        return nb::make_tuple(give(array_of(found.triangles), 3), give(array_of(found.stars)));
      },
      "elements"_a.noconvert());
}

}  // namespace geodesic
