// Exact distances on polyhedra, in Python.
#include <nanobind/stl/optional.h>

#include "python/bindings.hpp"
#include "windows/windows.hpp"

namespace geodesic {
namespace {

bool are_all_below(std::span<const Index> indices, Index end) {
  return std::ranges::all_of(indices, [end](Index i) { return 0 <= i && i < end; });
}

}  // namespace

void bind_windows(nb::module_& module) {
  nb::class_<Polyhedron>(module, "Polyhedron")
      .def(
          "__init__",
          [](Polyhedron* self, In<double, 2> vertices, In<Index, 2> faces) {
            require(vertices.shape(1) == 3 && faces.shape(1) == 3,
                    "three coordinates for each vertex, three vertices for each face");
            require(are_all_below(span(faces), n_rows(vertices)), "faces of vertices that exist");
            unlocked([&] { new (self) Polyhedron(span(vertices), span(faces)); });
          },
          "vertices"_a.noconvert(), "faces"_a.noconvert())
      .def_prop_ro("n_vertices", &Polyhedron::n_vertices)
      .def(
          "distances",
          [](const Polyhedron& self, In<Index> begins, In<Index> vertices, In<double> shares,
             In<double> known, In<double> starts, Index most) {
            const PointsOnFaces points{span(begins), span(vertices), span(shares), span(known),
                                       span(starts)};
            const Index n_points = n_rows(starts);
            require(n_rows(begins) == n_points + 1 && begins.data()[0] == 0 &&
                        begins.data()[n_points] == n_rows(vertices) &&
                        std::adjacent_find(begins.data(), begins.data() + n_points + 1,
                                           std::greater_equal<>()) == begins.data() + n_points + 1,
                    "begins rises from 0 to the number of vertices, for each start");
            require(shares.size() == vertices.size() && known.size() == vertices.size(),
                    "a share and a distance for each vertex");
            require(are_all_below(span(vertices), self.n_vertices()), "vertices that exist");
            Array<double> distances(self.n_vertices());
            const bool done =
                unlocked([&] { return exact_distances(self, points, most, distances); });
            return done ? std::optional(give(std::move(distances))) : std::nullopt;
          },
          "begins"_a.noconvert(), "vertices"_a.noconvert(), "shares"_a.noconvert(),
          "known"_a.noconvert(), "starts"_a.noconvert(), "most"_a);
}

}  // namespace geodesic
