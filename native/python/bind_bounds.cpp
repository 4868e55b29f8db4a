// Bounds of distances in Python.
#include "bounds/bounds.hpp"
#include "core/threads.hpp"
#include "python/bindings.hpp"

namespace geodesic {
namespace {

// A surface in space, with the arrays that it is made of.
struct Bounds {
  In<double, 2> vertices;
  In<Row> indptr, indices;
  EdgeBounds edge_bounds;

  Bounds(In<double, 2> places, In<Row> begins, In<Row> ends)
      : vertices(places), indptr(begins), indices(ends), edge_bounds(span(places), checked()) {}

  Pattern checked() const {
    const Pattern edges = pattern_of(indptr, indices);
    require(vertices.shape(1) == 3, "three coordinates for each vertex");
    require(edges.size() == n_rows(vertices), "the edges of each vertex");
    return edges;
  }

  void hold(In<Index> begins, In<double, 2> places, In<double> starts, Out<double, 2> distances,
            int n_threads) const {
    const Index n_sets = n_rows(distances), n_vertices = n_rows(vertices);
    require(static_cast<Index>(distances.shape(1)) == n_vertices,
            "a distance for each vertex and each set of sources");
    require_places(begins, places, starts, n_sets);
    require(n_threads > 0, "at least one thread");
    unlocked([&] {
      in_pieces(n_sets, 1, n_threads, [&](Index set, Index) {
        const std::span row(distances.data() + set * n_vertices,
                            static_cast<std::size_t>(n_vertices));
        raise_to_straight_line(span(vertices), values_of(set, begins, places, starts), row);
        edge_bounds.lower(row);
      });
    });
  }

  auto hold_near(In<Index> begins, In<double, 2> places, In<double> starts, In<Index> row_begins,
                 In<Index> near, Out<double> distances, In<double> limits) const {
    const Index n_sets = n_rows(limits), n_vertices = n_rows(vertices);
    require_places(begins, places, starts, n_sets);
    require(n_rows(row_begins) == n_sets + 1 && row_begins.data()[0] == 0 &&
                row_begins.data()[n_sets] == n_rows(near) && near.size() == distances.size() &&
                std::ranges::is_sorted(span(row_begins)),
            "the near vertices of each set, and their distances");
    require(std::ranges::all_of(span(near), [=](Index v) { return 0 <= v && v < n_vertices; }),
            "vertices below their number");
    return give(unlocked([&] {
      Array<bool> are_known(n_sets);
      Array<double> table(n_vertices, std::numeric_limits<double>::infinity());
      for (Index set = 0; set < n_sets; ++set) {
        const Index first = row_begins.data()[set], end = row_begins.data()[set + 1];
        const std::span<const Index> row(near.data() + first, near.data() + end);
        const std::span<double> own(distances.data() + first, distances.data() + end);
        raise_to_straight_line(span(vertices), row, values_of(set, begins, places, starts), own);
        for (std::size_t i = 0; i < row.size(); ++i) table[row[i]] = own[i];
        are_known[set] = edge_bounds.lower_near(row, limits.data()[set], table);
        for (std::size_t i = 0; i < row.size(); ++i)
          own[i] = std::exchange(table[row[i]], std::numeric_limits<double>::infinity());
      }
      return are_known;
    }));
  }

 private:
  static void require_places(In<Index> begins, In<double, 2> places, In<double> starts,
                             Index n_sets) {
    require(places.shape(1) == 3, "three coordinates for each place");
    require(starts.size() == places.shape(0) && n_rows(begins) == n_sets + 1 &&
                begins.data()[0] == 0 && begins.data()[n_sets] == n_rows(starts),
            "a start for each place, and the places of each set");
    require(std::adjacent_find(begins.data(), begins.data() + n_sets + 1, std::greater_equal<>()) ==
                begins.data() + n_sets + 1,
            "a place at least for each set");
  }

  static SourceValues values_of(Index set, const In<Index>& begins, const In<double, 2>& places,
                                const In<double>& starts) {
    const Index first = begins.data()[set], size = begins.data()[set + 1] - first;
    return {span(places).subspan(3 * first, 3 * size), span(starts).subspan(first, size)};
  }
};

}  // namespace

void bind_bounds(nb::module_& module) {
  module.def(
      "edges_of",
      [](In<Index, 2> triangles, Index n_vertices) {
        require(triangles.shape(1) == 3, "three vertices for each triangle");
        require(2 * triangles.size() < std::size_t{1} << 31 && n_vertices >= 0,
                "fewer corners than 32 bits count twice, and a number of vertices");
        Matrix edges = unlocked([&] { return edges_of(span(triangles), n_vertices); });
        return nb::make_tuple(give(std::move(edges.indptr)), give(std::move(edges.indices)));
      },
      "triangles"_a.noconvert(), "n_vertices"_a);
  nb::class_<Bounds>(module, "Bounds")
      .def(nb::init<In<double, 2>, In<Row>, In<Row>>(), "vertices"_a.noconvert(),
           "indptr"_a.noconvert(), "indices"_a.noconvert())
      .def("hold", &Bounds::hold, "begins"_a.noconvert(), "places"_a.noconvert(),
           "starts"_a.noconvert(), "distances"_a.noconvert(), "n_threads"_a = 1)
      .def("hold_near", &Bounds::hold_near, "begins"_a.noconvert(), "places"_a.noconvert(),
           "starts"_a.noconvert(), "row_begins"_a.noconvert(), "near"_a.noconvert(),
           "distances"_a.noconvert(), "limits"_a.noconvert());
}

}  // namespace geodesic
