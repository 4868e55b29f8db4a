// Closed geodesics: on a torus, around a vertex, on a sphere.
#include <cmath>
#include <numbers>

#include "paths/chains.hpp"
#include "paths/loops.hpp"
#include "paths/sheets.hpp"
#include "paths/shortest_loops.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr Index kRings = 24, kAround = 12;
constexpr double kMajor = 2, kMinor = 0.5;

struct Torus {
  std::vector<double> places;
  std::vector<Index> faces;
};

Index at(Index ring, Index angle) { return (ring % kRings) * kAround + angle % kAround; }

Torus torus() {
  Torus mesh;
  for (Index i = 0; i < kRings; ++i) {
    for (Index j = 0; j < kAround; ++j) {
      const double u = 2 * std::numbers::pi * static_cast<double>(i) / kRings;
      const double v = 2 * std::numbers::pi * static_cast<double>(j) / kAround;
      const double out = kMajor + kMinor * std::cos(v);
      mesh.places.insert(mesh.places.end(),
                         {out * std::cos(u), out * std::sin(u), kMinor * std::sin(v)});
      const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      mesh.faces.insert(mesh.faces.end(), {a, b, c, a, c, d});
    }
  }
  return mesh;
}

double length_of(const Torus& mesh, const std::vector<Crossing>& points) {
  double length = 0, before[3];
  for (std::size_t i = 0; i < points.size(); ++i) {
    double squared = 0;
    for (Index c = 0; c < 3; ++c) {
      const double there = (1 - points[i].share) * mesh.places[3 * points[i].left + c] +
                           points[i].share * mesh.places[3 * points[i].right + c];
      if (i > 0) squared += (there - before[c]) * (there - before[c]);
      before[c] = there;
    }
    length += std::sqrt(squared);
  }
  return length;
}

double polygon(Index corners, double radius) {
  return 2 * static_cast<double>(corners) * radius *
         std::sin(std::numbers::pi / static_cast<double>(corners));
}

}  // namespace

TEST(a_loop_along_a_torus_slips_to_the_inner_equator) {
  const Torus mesh = torus();
  const Surface surface(mesh.places, mesh.faces);
  const Drawn loop = geodesic_through(surface, {{at(0, 4), at(8, 6), at(16, 7)}, true, false, 0.0});
  CHECK(loop.unreached == kNoStop);
  CHECK(std::abs(length_of(mesh, loop.points) - polygon(kRings, kMajor - kMinor)) < 1e-9);
}

TEST(a_loop_that_holds_its_stops_is_longer_and_closes) {
  const Torus mesh = torus();
  const Surface surface(mesh.places, mesh.faces);
  const Drawn loop = geodesic_through(surface, {{at(0, 0), at(8, 0), at(16, 0)}, true, true, 0.0});
  CHECK(loop.points.front().left == at(0, 0) && loop.points.back().left == at(0, 0));
  CHECK(length_of(mesh, loop.points) > polygon(kRings, kMajor - kMinor));
}

TEST(a_loop_around_nothing_shrinks_to_a_point) {
  const Torus mesh = torus();
  const Surface surface(mesh.places, mesh.faces);
  CHECK(
      geodesic_through(surface, {{at(0, 0), at(3, 1), at(1, 3)}, true, false, 0.0}).points.empty());
  CHECK(shortest_loop(surface, surface.ring(5, surface.around(5).front()), 0.0).ring.empty());
  // Around the tube, but shorter than is asked for.
  const Course course{{at(0, 0), at(0, 4), at(0, 8)}, true, false, 4.0};
  CHECK(geodesic_through(surface, course).points.empty());
}

TEST(a_ring_forgets_faces_that_it_passes_there_and_back) {
  CHECK(ring_without_returns({1, 2, 3, 2, 1}).size() == 1);
  CHECK((ring_without_returns({5, 1, 2, 3, 5}) == Strip{5, 1, 2, 3}));
  CHECK((ring_without_returns({1, 2, 3, 4, 2}) == Strip{2, 3, 4}));
}

TEST(a_stop_that_no_triangle_connects_is_named) {
  Torus mesh = torus();
  mesh.places.insert(mesh.places.end(), {9, 9, 9});
  const Surface surface(mesh.places, mesh.faces);
  const Drawn drawn = geodesic_through(surface, {{0, 5, kRings * kAround}, false, false, 0.0});
  CHECK(drawn.unreached == 2);
}

TEST(the_shortest_loop_of_a_torus_is_around_the_tube) {
  const Torus mesh = torus();
  const Surface surface(mesh.places, mesh.faces);
  const ShortestLoop anywhere = shortest_loop_anywhere(surface, 0.0);
  const ShortestLoop held = shortest_loop_through(surface, at(3, 0), 0.0);
  CHECK(anywhere.line.length < polygon(kAround, kMinor));
  CHECK(anywhere.line.length > 0.98 * polygon(kAround, kMinor));
  CHECK(held.line.length >= anywhere.line.length);
  CHECK(held.line.points.front().left == at(3, 0) && held.line.points.back().left == at(3, 0));
  CHECK(std::abs(length_of(mesh, held.line.points) - held.line.length) < 1e-12);
}

TEST(a_hole_is_gone_around_unless_it_is_filled) {
  Torus mesh = torus();
  mesh.faces.erase(mesh.faces.begin(), mesh.faces.begin() + 3);
  const Surface surface(mesh.places, mesh.faces);
  const double tube = shortest_loop_anywhere(surface, 2.0).line.length;
  CHECK(shortest_loop_anywhere(surface, 0.0).line.length < 2.0);
  CHECK(tube > 0.98 * polygon(kAround, kMinor) && tube < polygon(kAround, kMinor));
}

TEST(a_disc_and_a_sphere_have_no_loop) {
  const Mesh plate = sheared_grid(5, 0.3);
  CHECK(shortest_loop_anywhere(Surface(plate.vertices, plate.faces), 0.0).line.points.empty());
  const std::vector<double> places{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<Index> faces{0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3};
  CHECK(shortest_loop_through(Surface(places, faces), 2, 0.0).line.points.empty());
}

TEST(an_edge_of_three_faces_is_named) {
  Torus mesh = torus();
  mesh.places.insert(mesh.places.end(), {9, 9, 9});
  mesh.faces.insert(mesh.faces.end(), {at(2, 3), at(3, 3), kRings * kAround});
  const ShortestLoop loop = shortest_loop_anywhere(Surface(mesh.places, mesh.faces), 0.0);
  CHECK(loop.line.points.empty());
  CHECK(std::min(loop.unclear[0], loop.unclear[1]) == at(2, 3));
  CHECK(std::max(loop.unclear[0], loop.unclear[1]) == at(3, 3));
}

TEST(a_vertex_where_sheets_meet_has_a_copy_in_each) {
  const std::vector<double> places{0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0};
  const std::vector<Index> faces{0, 1, 2, 0, 3, 4};
  const Sheets sheets(Surface(places, faces), 0.0);
  CHECK(sheets.n_vertices() == 6 && sheets.n_holes() == 2 && sheets.n_edges() == 6);
  const auto [first, last] = sheets.copies(0);
  CHECK(first == 0 && last == 2);
}
