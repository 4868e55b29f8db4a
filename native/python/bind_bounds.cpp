// Distances held to what is possible, in Python.
#include "bounds/bounds.hpp"
#include "core/threads.hpp"
#include "python/bindings.hpp"

namespace geodesic {

void bind_bounds(nb::module_& module) {
  module.def(
      "hold_within_bounds",
      [](In<double, 2> vertices, In<Index, 2> triangles, In<Index> begins, In<double, 2> places,
         In<double> starts, Out<double, 2> distances, int n_threads) {
        const Index n_sets = n_rows(distances), n_vertices = n_rows(vertices);
        require(vertices.shape(1) == 3 && triangles.shape(1) == 3 && places.shape(1) == 3,
                "three coordinates for each point, three vertices for each triangle");
        require(static_cast<Index>(distances.shape(1)) == n_vertices,
                "a distance for each vertex and each set of sources");
        require(starts.size() == places.shape(0) && n_rows(begins) == n_sets + 1 &&
                    begins.data()[0] == 0 && begins.data()[n_sets] == n_rows(starts),
                "a start for each place, and the places of each set");
        require(std::adjacent_find(begins.data(), begins.data() + n_sets + 1,
                                   std::greater_equal<>()) == begins.data() + n_sets + 1,
                "a place at least for each set");
        require(n_threads > 0, "at least one thread");
        const Surface surface{span(vertices), span(triangles)};
        unlocked([&] {
          in_pieces(n_sets, 1, n_threads, [&](Index set, Index) {
            const std::span row(distances.data() + set * n_vertices,
                                static_cast<std::size_t>(n_vertices));
            const Index first = begins.data()[set], size = begins.data()[set + 1] - first;
            const Starts from{span(places).subspan(3 * first, 3 * size),
                              span(starts).subspan(first, size)};
            raise_to_straight_line(surface.vertices, from, row);
            lower_to_edges(surface, row);
          });
        });
      },
      "vertices"_a.noconvert(), "triangles"_a.noconvert(), "begins"_a.noconvert(),
      "places"_a.noconvert(), "starts"_a.noconvert(), "distances"_a.noconvert(), "n_threads"_a = 1);
}

}  // namespace geodesic
