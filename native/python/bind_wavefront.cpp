// Wavefronts over triangles in Python.
#include <nanobind/stl/optional.h>

#include <functional>

#include "python/bindings.hpp"
#include "triangles/measures.hpp"
#include "wavefront/characteristics.hpp"
#include "wavefront/curvature.hpp"
#include "wavefront/sight.hpp"
#include "wavefront/sweeper.hpp"

namespace geodesic {
namespace {

// A field of all corners as a read-only array.
template <class T>
auto field(T Corner::* member) {
  return [member](nb::handle self) {
    const Corners& corners = nb::cast<const Corners&>(self);
    const std::size_t shape[] = {static_cast<std::size_t>(corners.around.size())};
    const std::int64_t strides[] = {sizeof(Corner) / sizeof(T)};
    const T* const first = corners.around.empty() ? nullptr : &(corners.around[0].*member);
    return nb::ndarray<nb::numpy, const T>(first, 1, shape, self, strides);
  };
}

template <class T>
auto field(Array<T> Corners::* member) {
  return [member](nb::handle self) { return view(nb::cast<const Corners&>(self).*member, self); };
}

void require_elements(const In<Index, 2>& elements, const In<double, 2>& frames) {
  require(elements.shape(1) == 3 && frames.shape(1) == 3 && frames.size() == elements.size(),
          "three vertices and three numbers for each element");
}

void require_sources(const Sources& sources, Index n_sets, Index n_vertices) {
  require(count(sources.begins) == n_sets + 1 && count(sources.tolerances) == n_sets &&
              sources.begins.front() == 0 && sources.begins.back() == count(sources.vertices) &&
              std::ranges::is_sorted(sources.begins),
          "a beginning and a tolerance for each set of sources");
  require(sources.distances.size() == sources.vertices.size() &&
              sources.curvatures.size() == sources.vertices.size(),
          "a distance and a curvature at each vertex of the sources");
  require(std::ranges::all_of(sources.vertices, [&](Index v) { return 0 <= v && v < n_vertices; }),
          "vertices of the sources below their number");
}

Corners gathered(std::span<const Index> elements, std::span<const double> frames, bool stars,
                 bool add_missed, std::span<const bool> boundary, bool edges_agree) {
  require(elements.size() < std::size_t{1} << 31, "fewer than 2^31 corners");
  Corners corners = gather_corners(elements, frames, stars, count(boundary));
  if (add_missed) add_missed_triangles(corners);
  if (!stars) close_rims(corners, boundary, edges_agree);
  return corners;
}

template <class T>
auto give(const std::vector<T>& values) {
  Array<T> array(static_cast<Index>(values.size()));
  std::ranges::copy(values, array.begin());
  return give(std::move(array));
}

void bind_sight(nb::module_& module) {
  module.def(
      "in_sight",
      [](In<Index> begins, In<Index> vertices, In<double> distances, In<Index, 2> elements,
         In<double, 2> frames, bool stars, In<bool> hidden) {
        const auto below = [&](Index v) { return 0 <= v && v < n_rows(hidden); };
        const auto two_or_three = [&](Index begin, Index end) {
          return end - begin == 2 || end - begin == 3;
        };
        require_elements(elements, frames);
        require(
            elements.size() < std::size_t{1} << 31 && std::ranges::all_of(span(elements), below),
            "fewer than 2^31 corners, and vertices below their number");
        require(begins.size() > 0 && begins.data()[0] == 0 &&
                    begins.data()[begins.size() - 1] == n_rows(vertices) &&
                    distances.size() == vertices.size() &&
                    std::ranges::adjacent_find(span(begins), std::not_fn(two_or_three)) ==
                        span(begins).end() &&
                    std::ranges::all_of(span(vertices), below),
                "two or three vertices around each place, and a distance for each");
        const Sight sight = unlocked([&] {
          return in_sight({span(begins), span(vertices), span(distances)},
                          {span(elements), span(frames), stars}, span(hidden));
        });
        return nb::make_tuple(give(sight.places), give(sight.vertices), give(sight.x),
                              give(sight.y));
      },
      "begins"_a.noconvert(), "vertices"_a.noconvert(), "distances"_a.noconvert(),
      "elements"_a.noconvert(), "frames"_a.noconvert(), "stars"_a, "hidden"_a.noconvert());
}

void bind_tracer(nb::module_& module) {
  module.def(
      "directions_of",
      [](In<Index, 2> elements, In<double, 2> lengths, In<double, 2> turns, In<bool> mirrored,
         In<Index> twin) {
        require(elements.shape(1) == 3 && have_one_shape(lengths, elements) &&
                    turns.size() == 2 * elements.size() && mirrored.size() == elements.shape(0),
                "three lengths and three turns for each element, and whether it is mirrored");
        require(twin.size() == 0 || twin.size() == elements.size(),
                "a twin for each half-edge, or none");
        Directions directions = unlocked([&] {
          return directions_of(span(elements), span(lengths), span(turns), span(mirrored),
                               span(twin));
        });
        return nb::make_tuple(give(std::move(directions.angles)),
                              give(std::move(directions.scales)));
      },
      "elements"_a.noconvert(), "lengths"_a.noconvert(), "turns"_a.noconvert(),
      "mirrored"_a.noconvert(), "twin"_a.noconvert());
  nb::class_<Tracer>(module, "Tracer")
      .def(
          "__init__",
          [](Tracer* self, In<Index, 2> elements, In<double, 2> frames, bool stars, bool add_missed,
             In<bool> boundary, In<double, 2> flat, In<double> angles, In<double> scales,
             In<double> curvature, In<bool> reflex) {
            require_elements(elements, frames);
            require(have_one_shape(flat, elements) && angles.size() == elements.size() &&
                        scales.size() == elements.size(),
                    "a length, an angle and a scale for each half-edge of an element");
            require(curvature.size() == boundary.size() && reflex.size() == boundary.size(),
                    "a curvature for each vertex, and whether fronts turn about it");
            unlocked([&] {
              Corners corners =
                  gathered(span(elements), span(frames), stars, add_missed, span(boundary), true);
              Array<Bearing> bearings =
                  bearings_of(corners, span(elements), edge_lengths(span(frames)), span(flat),
                              {span(angles), span(scales)});
              new (self)
                  Tracer(std::move(corners), std::move(bearings), span(curvature), span(reflex));
            });
          },
          "elements"_a.noconvert(), "frames"_a.noconvert(), "stars"_a, "add_missed"_a,
          "boundary"_a.noconvert(), "flat"_a.noconvert(), "angles"_a.noconvert(),
          "scales"_a.noconvert(), "curvature"_a.noconvert(), "reflex"_a.noconvert())
      .def(
          "carry",
          [](const Tracer& self, In<double> distances, In<double> kappas, In<Index> vertices,
             In<double> known, In<double> angles, In<double> spreads, In<double> arrivals,
             In<Row> labels, double period, bool clockwise, bool directions) {
            require(n_rows(distances) == self.n_vertices() && kappas.size() == distances.size(),
                    "a distance and a curvature for each vertex");
            const std::size_t n_seeds = vertices.size();
            require(known.size() == n_seeds && angles.size() == n_seeds &&
                        spreads.size() == n_seeds && arrivals.size() == n_seeds &&
                        labels.size() == n_seeds,
                    "a distance, an angle, a spread, an arrival and a label for each seed");
            require(std::ranges::all_of(span(vertices),
                                        [&](Index v) { return 0 <= v && v < self.n_vertices(); }),
                    "seeds below the number of vertices");
            const Seeds seeds{span(vertices), span(known),    span(angles),
                              span(spreads),  span(arrivals), span(labels)};
            Carried carried = unlocked([&] {
              return self.carry({span(distances), span(kappas)}, seeds,
                                {period, clockwise, directions});
            });
            return nb::make_tuple(give(std::move(carried.angles)), give(std::move(carried.spreads)),
                                  give(std::move(carried.arrivals)),
                                  give(std::move(carried.rotations)),
                                  give(std::move(carried.labels)), give(std::move(carried.a)),
                                  give(std::move(carried.b)), give(std::move(carried.shares)));
          },
          "distances"_a.noconvert(), "kappas"_a.noconvert(), "vertices"_a.noconvert(),
          "known"_a.noconvert(), "angles"_a.noconvert(), "spreads"_a.noconvert(),
          "arrivals"_a.noconvert(), "labels"_a.noconvert(), "period"_a, "clockwise"_a,
          "directions"_a);
}

}  // namespace

void bind_wavefront(nb::module_& module) {
  nb::class_<Corners>(module, "Corners")
      .def_prop_ro("starts", field(&Corners::starts))
      .def_prop_ro("ends", field(&Corners::ends))
      .def_prop_ro("a", field(&Corner::a))
      .def_prop_ro("b", field(&Corner::b))
      .def_prop_ro("to_a", field(&Corner::to_a))
      .def_prop_ro("to_b", field(&Corner::to_b))
      .def_prop_ro("edge", field(&Corner::edge));
  module.def(
      "gather_corners",
      [](In<Index, 2> elements, In<double, 2> frames, bool stars, bool add_missed,
         In<bool> boundary, bool edges_agree) {
        require_elements(elements, frames);
        return unlocked([&] {
          return gathered(span(elements), span(frames), stars, add_missed, span(boundary),
                          edges_agree);
        });
      },
      "elements"_a.noconvert(), "frames"_a.noconvert(), "stars"_a, "add_missed"_a,
      "boundary"_a.noconvert(), "edges_agree"_a = true);
  module.def(
      "angle_defects",
      [](In<Index, 2> elements, In<double, 2> frames, In<bool> boundary) {
        require_elements(elements, frames);
        return give(
            unlocked([&] { return angle_defects(span(elements), span(frames), span(boundary)); }));
      },
      "elements"_a.noconvert(), "frames"_a.noconvert(), "boundary"_a.noconvert());
  module.def(
      "curvatures",
      [](In<Index, 2> elements, In<double> measure, In<double> defects, const Corners& corners,
         In<bool> boundary, double coarse) {
        require(elements.shape(1) == 3 && measure.size() == elements.shape(0) &&
                    static_cast<Index>(elements.size()) == corners.around.size(),
                "a measure for each element, and their corners");
        require(n_rows(defects) == corners.n_vertices() && boundary.size() == defects.size(),
                "a defect for each vertex, and whether the domain ends there");
        return give(unlocked([&] {
          return curvatures(span(elements), span(measure), span(defects), corners, span(boundary),
                            coarse);
        }));
      },
      "elements"_a.noconvert(), "measure"_a.noconvert(), "defects"_a.noconvert(), "corners"_a,
      "boundary"_a.noconvert(), "coarse"_a);
  module.def(
      "star_curvatures",
      [](In<Index, 2> elements, In<double, 2> frames, In<bool> boundary, double coarse) {
        require_elements(elements, frames);
        return give(unlocked(
            [&] { return star_curvatures(span(elements), span(frames), span(boundary), coarse); }));
      },
      "elements"_a.noconvert(), "frames"_a.noconvert(), "boundary"_a.noconvert(), "coarse"_a);
  module.def(
      "falling",
      [](Columns heat, bool logarithmic) {
        const HeatTable table{span(heat), n_columns(heat), logarithmic};
        return give(unlocked([&] { return falling(table, 0, table.n_columns); }));
      },
      "heat"_a.noconvert(), "logarithmic"_a);
  nb::class_<Sweeper>(module, "Sweeper")
      .def(
          "__init__",
          [](Sweeper* self, const Corners& corners, In<double> curvature, In<bool> reflex) {
            require(n_rows(curvature) == corners.n_vertices() && reflex.size() == curvature.size(),
                    "a curvature for each vertex, and whether fronts turn about it");
            unlocked([&] { new (self) Sweeper(corners, span(curvature), span(reflex)); });
          },
          "corners"_a, "curvature"_a.noconvert(), "reflex"_a.noconvert())
      .def(
          "sweep",
          [](const Sweeper& self, Columns heat, bool logarithmic, In<Index> begins,
             In<Index> vertices, In<double> known, In<double> curvatures, In<double> tolerances,
             Index returns, Index steady, Index most_sweeps, Out<double, 2> distances,
             std::optional<Out<double, 2>> kappas, int n_threads, bool have_offsets) {
            const HeatTable table{span(heat), n_columns(heat), logarithmic};
            const Sources sources{span(begins),     span(vertices),   span(known),
                                  span(curvatures), span(tolerances), have_offsets};
            require(n_rows(heat) == self.n_vertices() && distances.size() == heat.size() &&
                        (!kappas || kappas->size() == heat.size()),
                    "a number for each vertex and each set of sources");
            require_sources(sources, table.n_columns, self.n_vertices());
            require(n_threads > 0, "at least one thread");
            unlocked([&] {
              self.sweep(table, sources, {returns, steady, most_sweeps}, span(distances),
                         kappas ? span(*kappas) : std::span<double>(), n_threads);
            });
          },
          "heat"_a.noconvert(), "logarithmic"_a, "begins"_a.noconvert(), "vertices"_a.noconvert(),
          "known"_a.noconvert(), "curvatures"_a.noconvert(), "tolerances"_a.noconvert(),
          "returns"_a, "steady"_a, "most_sweeps"_a, "distances"_a.noconvert(),
          "kappas"_a.noconvert() = nb::none(), "n_threads"_a = 1, "have_offsets"_a = false)
      .def(
          "sweep_near",
          [](const Sweeper& self, Columns heat, bool logarithmic, In<Index> begins,
             In<Index> vertices, In<double> known, In<double> curvatures, In<double> tolerances,
             Index returns, Index steady, Index most_sweeps, In<double> limits, int n_threads,
             bool have_offsets) {
            const HeatTable table{span(heat), n_columns(heat), logarithmic};
            const Sources sources{span(begins),     span(vertices),   span(known),
                                  span(curvatures), span(tolerances), have_offsets};
            require(n_rows(heat) == self.n_vertices(), "a number for each vertex");
            require_sources(sources, table.n_columns, self.n_vertices());
            require(n_rows(limits) == table.n_columns, "a limit for each set of sources");
            require(n_threads > 0, "at least one thread");
            return give(unlocked([&] {
              return self.sweep_near(table, sources, {returns, steady, most_sweeps}, span(limits),
                                     n_threads);
            }));
          },
          "heat"_a.noconvert(), "logarithmic"_a, "begins"_a.noconvert(), "vertices"_a.noconvert(),
          "known"_a.noconvert(), "curvatures"_a.noconvert(), "tolerances"_a.noconvert(),
          "returns"_a, "steady"_a, "most_sweeps"_a, "limits"_a.noconvert(), "n_threads"_a = 1,
          "have_offsets"_a = false)
      .def(
          "sweep_limited",
          [](const Sweeper& self, In<Index> vertices, In<double> known, In<double> curvatures,
             double tolerance, In<double> latest, Index most_visits, Out<double> distances,
             bool have_offsets) {
            const Index begins[] = {0, n_rows(vertices)};
            const Sources sources{begins,           span(vertices),  span(known),
                                  span(curvatures), {&tolerance, 1}, have_offsets};
            require(n_rows(latest) == self.n_vertices() && n_rows(distances) == self.n_vertices(),
                    "a limit and a distance for each vertex");
            require_sources(sources, 1, self.n_vertices());
            unlocked(
                [&] { self.sweep_limited(sources, span(latest), most_visits, span(distances)); });
          },
          "vertices"_a.noconvert(), "known"_a.noconvert(), "curvatures"_a.noconvert(),
          "tolerance"_a, "latest"_a.noconvert(), "most_visits"_a, "distances"_a.noconvert(),
          "have_offsets"_a = false);
  bind_sight(module);
  bind_tracer(module);
}

}  // namespace geodesic
