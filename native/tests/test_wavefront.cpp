// Sweeps of fronts over flat grids, where distances are known.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "tests/check.hpp"
#include "tests/examples.hpp"
#include "triangles/half_edges.hpp"
#include "triangles/measures.hpp"
#include "triangles/vector3.hpp"
#include "wavefront/characteristics.hpp"
#include "wavefront/corners.hpp"
#include "wavefront/curvature.hpp"
#include "wavefront/sight.hpp"
#include "wavefront/sweeper.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr Index kSide = 30;

// A flat grid, ready for sweeps from some of its vertices, in the order of their true distances.
struct Flat {
  Mesh mesh = sheared_grid(kSide, 0.3);
  Index n = count(std::span<const double>(mesh.vertices)) / 3;
  std::vector<Index> vertices{0, n / 2, n - 1, kSide - 1, n / 3};
  Index n_sets = count(std::span<const Index>(vertices));
  std::vector<double> exact;  // a row for each source

  Flat() {
    for (const Index source : vertices)
      for (Index v = 0; v < n; ++v)
        exact.push_back(length(at(mesh.vertices, v) - at(mesh.vertices, source)));
  }

  // Use a sweeper with heat, sources and effort.
  template <class Use>
  void sweep(const Use& use) const {
    const Measured measured = measure_triangles(mesh.vertices, mesh.faces);
    Corners corners = gather_corners(mesh.faces, measured.triangles.frames, false, n);
    close_rims(corners, Array<bool>(n, true));
    const Sweeper sweeper(corners, Array<double>(n, 0.0), Array<bool>(n, false));
    std::vector<double> heat(exact.size());
    for (Index k = 0; k < n_sets; ++k)
      for (Index v = 0; v < n; ++v) heat[v * n_sets + k] = -exact[k * n + v];
    std::vector<Index> begins;
    for (Index k = 0; k <= n_sets; ++k) begins.push_back(k);
    const std::vector<double> distances(n_sets, 0.0), tolerances(n_sets, 1e-12);
    const std::vector<double> curvatures(n_sets, std::numeric_limits<double>::infinity());
    use(sweeper, HeatTable{heat, n_sets, true},
        Sources{begins, vertices, distances, curvatures, tolerances}, Effort{8 * n, 0, 100});
  }

  std::vector<double> swept(int n_threads) const {
    std::vector<double> found(exact.size());
    sweep([&](const Sweeper& sweeper, const auto&... arguments) {
      sweeper.sweep(arguments..., found, {}, n_threads);
    });
    return found;
  }

  NearRows swept_near(double limit, int n_threads) const {
    NearRows found;
    sweep([&](const Sweeper& sweeper, const auto&... arguments) {
      found = sweeper.sweep_near(arguments..., std::vector<double>(n_sets, limit), n_threads);
    });
    return found;
  }
};

}  // namespace

TEST(fronts_on_a_plane_are_circles) {
  const Flat flat;
  const std::vector<double> found = flat.swept(1);
  double worst = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i)
    worst = std::max(worst, std::abs(found[i] - flat.exact[i]));
  CHECK(worst < 1e-10);
}

TEST(sweeps_give_the_same_bits_on_any_number_of_threads) {
  const Flat flat;
  const std::vector<double> one = flat.swept(1);
  for (const int n_threads : {2, 3, 8}) {
    const std::vector<double> several = flat.swept(n_threads);
    CHECK(std::memcmp(one.data(), several.data(), one.size() * sizeof(double)) == 0);
  }
}

TEST(sweeps_that_end_at_a_limit_give_the_same_bits_up_to_it) {
  const Flat flat;
  const std::vector<double> all = flat.swept(1);
  for (const double limit : {0.0, 0.1, 0.5, 10.0}) {
    const NearRows near = flat.swept_near(limit, limit > 0.1 ? 3 : 1);
    for (Index k = 0; k < flat.n_sets; ++k) {
      const double* const row = all.data() + k * flat.n;
      Index found = 0;
      for (Index i = near.begins[k]; i < near.begins[k + 1]; ++i) {
        CHECK(i == near.begins[k] || near.vertices[i - 1] < near.vertices[i]);
        if (near.distances[i] > limit) continue;
        ++found;
        CHECK(near.distances[i] == row[near.vertices[i]]);
      }
      CHECK(found == std::count_if(row, row + flat.n, [&](double d) { return d <= limit; }));
    }
  }
}

TEST(slices_of_an_order_are_its_beginning) {
  const std::vector<double> heat{0.5, -1.0, 2.0, 0.5, 1e-300, 1e300, 0.0, 3.0};
  for (const bool logarithmic : {false, true}) {
    const HeatTable table{heat, 1, logarithmic};
    const Array<Row> whole = falling(table, 0, 1);
    FallingKeys keys(table, 0, 1);
    CHECK(keys.are_heat[0] == logarithmic);
    FallingSlices slices;
    slices.begin(keys.column(0), keys.mosts[0], keys.number);
    for (Index size = 1; !slices.is_whole(); ++size) {
      slices.add(size);
      CHECK(std::ranges::equal(slices.order(), std::span(whole).first(slices.order().size())));
    }
    slices.add(1);
    CHECK(count(slices.order()) == whole.size());
  }
}

TEST(edges_with_nothing_behind_them_are_less_than_zero) {
  const Flat flat;
  const Measured measured = measure_triangles(flat.mesh.vertices, flat.mesh.faces);
  Corners corners = gather_corners(flat.mesh.faces, measured.triangles.frames, false, flat.n);
  const auto n_closed = [&] {
    return std::ranges::count_if(corners.around, [](const Corner& it) { return it.edge < 0; });
  };
  close_rims(corners, Array<bool>(flat.n, false));
  CHECK(n_closed() == 0);
  close_rims(corners, Array<bool>(flat.n, true));
  CHECK(n_closed() == 4 * (kSide - 1));
}

TEST(vertices_without_triangles_are_out_of_reach) {
  Flat flat;
  flat.mesh.vertices.insert(flat.mesh.vertices.end(), {5.0, 5.0, 5.0});
  ++flat.n;
  flat.exact.clear();
  for (const Index source : flat.vertices)
    for (Index v = 0; v < flat.n; ++v)
      flat.exact.push_back(length(at(flat.mesh.vertices, v) - at(flat.mesh.vertices, source)));
  const std::vector<double> found = flat.swept(2);
  for (Index k = 0; k < flat.n_sets; ++k) CHECK(std::isinf(found[(k + 1) * flat.n - 1]));
  CHECK(std::abs(found[1] - 1.0) < 1e-12);
}

TEST(angles_about_the_vertices_of_a_plane_lack_nothing) {
  const Flat flat;
  const Measured measured = measure_triangles(flat.mesh.vertices, flat.mesh.faces);
  std::vector<Index> inner;
  Array<bool> boundary(flat.n, false);
  for (Index v = 0; v < flat.n; ++v)
    if (v % kSide > 0 && v % kSide < kSide - 1 && v >= kSide && v < flat.n - kSide)
      inner.push_back(v);
  const Array<double> defects = angle_defects(flat.mesh.faces, measured.triangles.frames, boundary);
  for (const Index v : inner) CHECK(std::abs(defects[v]) < 1e-12);
}

TEST(directions_at_a_source_are_carried_to_all_of_a_plane) {
  const Flat flat;
  const Measured measured = measure_triangles(flat.mesh.vertices, flat.mesh.faces);
  const Array<double> lengths = edge_lengths(measured.triangles.frames);
  const std::span<const Index> faces = flat.mesh.faces;
  const auto direction = [&](Index from, Index to) {
    const Vector3 step = at(flat.mesh.vertices, to) - at(flat.mesh.vertices, from);
    return std::atan2(step.y, step.x);
  };
  std::vector<double> angles, scales(count(faces), 1.0);
  for (Index half = 0; half < count(faces); ++half) {
    const Index face = half - half % 3;
    angles.push_back(direction(faces[face + (half + 1) % 3], faces[face + (half + 2) % 3]));
  }
  Corners corners = gather_corners(faces, measured.triangles.frames, false, flat.n);
  Array<Bearing> bearings = bearings_of(corners, faces, lengths, lengths, {angles, scales});
  const Tracer tracer(std::move(corners), std::move(bearings), Array<double>(flat.n, 0.0),
                      Array<bool>(flat.n, false));
  const Index source = flat.vertices[1];
  std::vector<double> distances(flat.exact.begin() + flat.n, flat.exact.begin() + 2 * flat.n);
  std::vector<double> kappas;
  for (const double distance : distances) kappas.push_back(1 / distance);
  const std::vector<Index> vertices{source};
  const std::vector<double> none{0.0};
  const std::vector<Row> labels{3};
  const Carried carried =
      tracer.carry({distances, kappas}, {vertices, none, none, none, none, labels},
                   {2 * 3.14159265358979323846, true, true});
  double worst = 0.0;
  for (Index v = 0; v < flat.n; ++v) {
    CHECK(carried.labels[v] == 3);
    if (v == source) continue;
    worst = std::max(worst, std::abs(std::sin(carried.angles[v] - direction(source, v))));
    worst = std::max(worst, std::abs(std::sin(carried.arrivals[v] - direction(source, v))));
  }
  CHECK(worst < 1e-9);
}

// Two triangles, 0 1 2 and 2 1 3, with a right angle at 0 and the third at (far, far).
TEST(vertices_in_sight_of_a_place_are_those_across_near_edges) {
  const auto errors_of = [](double x, double y, double far, const std::vector<Index>& own) {
    const std::vector<double> vertices{0, 0, 0, 1, 0, 0, 0, 1, 0, far, far, 0};
    const std::vector<Index> faces{0, 1, 2, 2, 1, 3}, begins{0, static_cast<Index>(own.size())};
    const auto distance_to = [&](Index v) {
      return std::hypot(vertices[3 * v] - x, vertices[3 * v + 1] - y);
    };
    std::vector<double> distances, errors;
    for (const Index v : own) distances.push_back(distance_to(v));
    const Measured measured = measure_triangles(vertices, faces);
    const Sight sight = in_sight({begins, own, distances},
                                 {faces, measured.triangles.frames, false}, Array<bool>(4, false));
    for (std::size_t s = 0; s < sight.vertices.size(); ++s)
      errors.push_back(std::hypot(sight.x[s], sight.y[s]) - distance_to(sight.vertices[s]));
    return errors;
  };
  const auto are_small = [](const std::vector<double>& errors) {
    return std::ranges::all_of(errors, [](double error) { return std::abs(error) < 1e-12; });
  };
  CHECK(errors_of(0.1, 0.1, 1.0, {0, 1, 2}).empty());  // it is farther than the ends of the edge
  const std::vector<double> behind = errors_of(0.48, 0.48, 0.6, {0, 1, 2});
  CHECK(behind.size() == 1 && are_small(behind));
  const std::vector<double> on_edge = errors_of(0.3, 0.7, 1.0, {1, 2});
  CHECK(on_edge.size() == 2 && are_small(on_edge));
  CHECK(errors_of(0.1, 0.1, 1.0, {0, 3}).empty());  // no triangle has both
}

TEST(offsets_do_not_change_the_centres_of_fronts) {
  const Flat flat;
  const Measured measured = measure_triangles(flat.mesh.vertices, flat.mesh.faces);
  Corners corners = gather_corners(flat.mesh.faces, measured.triangles.frames, false, flat.n);
  close_rims(corners, Array<bool>(flat.n, true));
  const Sweeper sweeper(corners, Array<double>(flat.n, 0.0), Array<bool>(flat.n, false));
  std::vector<double> heat(flat.n), found(flat.n);
  for (Index v = 0; v < flat.n; ++v) heat[v] = -flat.exact[flat.n + v];
  const std::vector<Index> begins{0, 1}, source{flat.vertices[1]};
  const std::vector<double> offset{0.7}, tolerance{1e-12};
  const std::vector<double> curvature{std::numeric_limits<double>::infinity()};
  sweeper.sweep({heat, 1, true}, {begins, source, offset, curvature, tolerance, true},
                {8 * flat.n, 0, 100}, found, {}, 1);
  for (Index v = 0; v < flat.n; ++v)
    CHECK(std::abs(found[v] - 0.7 - flat.exact[flat.n + v]) < 1e-9);
}
