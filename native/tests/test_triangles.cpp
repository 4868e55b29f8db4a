// Half-edges, stiffness and flips, against plain loops over triangles.
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/check.hpp"
#include "tests/examples.hpp"
#include "triangles/flips.hpp"
#include "triangles/frames.hpp"
#include "triangles/half_edges.hpp"
#include "triangles/measures.hpp"
#include "triangles/normals.hpp"
#include "triangles/proper.hpp"
#include "triangles/rings.hpp"
#include "triangles/stiffness.hpp"
#include "triangles/vector3.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr double kClose = 1e-12;

Index next(Index half) { return half % 3 == 2 ? half - 2 : half + 1; }
Index previous(Index half) { return next(next(half)); }

double angle(const double* lengths, int corner) {
  const double a = lengths[corner], b = lengths[(corner + 1) % 3], c = lengths[(corner + 2) % 3];
  return std::acos(std::clamp((b * b + c * c - a * a) / (2 * b * c), -1.0, 1.0));
}

double total_area(const std::vector<double>& lengths) {
  double total = 0.0;
  for (std::size_t f = 0; f < lengths.size(); f += 3)
    total += doubled_area(lengths[f], lengths[f + 1], lengths[f + 2]) / 2;
  return total;
}

// A mesh as edge flips have it.
struct Intrinsic {
  std::vector<Index> faces, twin;
  std::vector<double> lengths;

  explicit Intrinsic(const Mesh& mesh) : faces(mesh.faces) {
    const Twins its = twins(sorted_half_edges(mesh.faces, mesh.n_vertices()));
    twin.assign(its.of.begin(), its.of.end());
    const Measured measured = measure_triangles(mesh.vertices, mesh.faces);
    const Array<double> edges = edge_lengths(measured.triangles.frames);
    lengths.assign(edges.begin(), edges.end());
  }
  bool is_coherent() const {
    for (Index half = 0; half < static_cast<Index>(twin.size()); ++half) {
      const Index mate = twin[half];
      if (mate < 0) continue;
      if (twin[mate] != half) return false;
      if (std::abs(lengths[mate] / lengths[half] - 1) > 1e-9) return false;
      if (faces[next(mate)] != faces[previous(half)]) return false;
      if (faces[previous(mate)] != faces[next(half)]) return false;
    }
    return true;
  }
  double largest_opposite_angles() const {
    double largest = 0.0;
    for (Index half = 0; half < static_cast<Index>(twin.size()); ++half) {
      const Index mate = twin[half];
      if (mate < 0) continue;
      largest = std::max(largest, angle(&lengths[half - half % 3], half % 3) +
                                      angle(&lengths[mate - mate % 3], mate % 3));
    }
    return largest;
  }
};

// The stiffness from cotangents, entry by entry.
Entries cotangent_stiffness(const Mesh& mesh) {
  Entries rows = diagonal(static_cast<Row>(mesh.n_vertices()), 0.0);
  for (Index half = 0; half < 3 * mesh.n_faces(); ++half) {
    const Index c = mesh.faces[half], i = mesh.faces[next(half)], j = mesh.faces[previous(half)];
    const Vector3 u = at(mesh.vertices, i) - at(mesh.vertices, c);
    const Vector3 v = at(mesh.vertices, j) - at(mesh.vertices, c);
    add_edge(rows, static_cast<Row>(i), static_cast<Row>(j), dot(u, v) / length(cross(u, v)) / 2);
  }
  return rows;
}

}  // namespace

TEST(each_half_edge_is_sorted_to_its_lower_end) {
  const Mesh mesh = sheared_grid(9, 0.0);
  const HalfEdges sides = sorted_half_edges(mesh.faces, mesh.n_vertices());
  CHECK(sides.halves.size() == 3 * mesh.n_faces());
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    for (Row place = sides.starts[v]; place < sides.starts[v + 1]; ++place) {
      const auto [head, half] = sides.halves[place];
      const Index tail = mesh.faces[next(number(half))], end = mesh.faces[previous(number(half))];
      CHECK(std::min(tail, end) == v && std::max(tail, end) == head);
      CHECK((half >= 0) == (tail == v));
    }
  }
}

TEST(twins_run_against_each_other) {
  const Mesh mesh = sheared_grid(9, 0.3);
  const Intrinsic its(mesh);
  CHECK(its.is_coherent());
  CHECK(std::count(its.twin.begin(), its.twin.end(), -1) == 4 * 8);
}

TEST(edges_of_more_than_two_triangles_have_no_twins) {
  for (Index fans = 3; fans <= 6; ++fans) {
    std::vector<Index> faces;
    for (Index k = 0; k < fans; ++k)
      for (const Index corner : {Index{0}, Index{1}, k + 2}) faces.push_back(corner);
    const Twins its = twins(sorted_half_edges(faces, fans + 2));
    for (const Index twin : its.of) CHECK(twin == -1);
  }
}

TEST(twins_that_run_along_one_another_are_told) {
  const std::vector<Index> against{0, 1, 2, 1, 0, 3}, along{0, 1, 2, 0, 1, 3};
  CHECK(twins(sorted_half_edges(against, 4)).coherent);
  CHECK(!twins(sorted_half_edges(along, 4)).coherent);
}

TEST(no_triangles_are_no_trouble) {
  const HalfEdges none = sorted_half_edges({}, 3);
  CHECK(twins(none).of.empty());
  const EdgeSums sums = edge_sums({}, none, {}, {});
  CHECK(sums.edges.indptr[3] == 0);
  const Matrix matrix = mirrored({Pattern{sums.edges.indptr, sums.edges.indices}, sums.edges.data});
  CHECK(matrix.data.size() == 3);
  CHECK(measure_triangles({}, {}).total == 0.0);
  CHECK(flip_edges({}, {}, {}, {}) == 0);
}

TEST(a_face_is_proper_that_has_three_vertices_of_which_no_other_one_was_made) {
  CHECK(proper_faces({}, 0).empty());
  const std::vector<Index> faces{0, 1, 2, 2, 1, 0, 3, 1, 3, 0, 1, 3, 1, 3, 0, 2, 0, 1};
  const Array<bool> proper = proper_faces(faces, 5);
  const bool expected[] = {true, false, false, true, false, false};
  CHECK(std::equal(proper.begin(), proper.end(), expected));
  std::vector<Index> fan;  // many about one vertex, each of them twice
  for (const Index turn : {0, 1})
    for (Index k = 1; k <= 40; ++k) {
      const Index rim[] = {k, k % 40 + 1};
      fan.insert(fan.end(), {rim[turn], 0, rim[1 - turn]});
    }
  const Array<bool> once = proper_faces(fan, 41);
  for (Index f = 0; f < once.size(); ++f) CHECK(once[f] == (f < 40));
}

TEST(stiffness_is_that_of_cotangents_and_symmetric_to_the_bit) {
  for (const double shear : {0.0, 0.4, 2.3}) {
    const Mesh mesh = sheared_grid(12, shear);
    const Measured its = measure_triangles(mesh.vertices, mesh.faces);
    const HalfEdges sides = sorted_half_edges(mesh.faces, mesh.n_vertices());
    const EdgeSums sums = edge_sums(mesh.faces, sides, its.triangles.frames, its.triangles.areas);
    const Matrix matrix =
        mirrored({Pattern{sums.edges.indptr, sums.edges.indices}, sums.edges.data});
    const Entries expected = cotangent_stiffness(mesh);
    Entries found(mesh.n_vertices());
    for (Index v = 0; v < mesh.n_vertices(); ++v) {
      Row before = -1;
      for (Row entry = matrix.indptr[v]; entry < matrix.indptr[v + 1]; ++entry) {
        const Row head = matrix.indices[entry];
        CHECK(head > before);
        before = head;
        found[v][head] = matrix.data[entry];
        CHECK(expected[v].contains(head));
        CHECK(std::abs(matrix.data[entry] - expected[v].at(head)) < kClose * 10);
      }
      CHECK(found[v].size() == expected[v].size());
    }
    for (Index v = 0; v < mesh.n_vertices(); ++v) {
      double total = 0.0;
      for (const auto& [head, value] : found[v]) {
        CHECK(found[head][static_cast<Row>(v)] == value);
        total += value;
      }
      CHECK(std::abs(total) < kClose * 10);
    }
    CHECK(std::count(sums.boundary.begin(), sums.boundary.end(), true) == 4 * 11);
    double area = 0.0;
    for (const double third : sums.lumped_mass) area += third;
    CHECK(std::abs(area - 11 * 11) < 1e-9);
  }
}

TEST(triangles_with_a_vertex_twice_leave_no_edge_to_itself) {
  const std::vector<Index> faces{0, 1, 2, 1, 1, 2, 3, 3, 3};
  const std::vector<double> frames(9, 1.0), measure(3, 1.0);
  const EdgeSums sums = edge_sums(faces, sorted_half_edges(faces, 4), frames, measure);
  CHECK(sums.edges.indptr[4] == 3);
  CHECK(twins(sorted_half_edges(faces, 4)).of.size() == 9);
}

TEST(lengths_and_frames_lead_to_each_other) {
  const Mesh mesh = sheared_grid(7, 0.8);
  const Measured its = measure_triangles(mesh.vertices, mesh.faces);
  const Array<double> lengths = edge_lengths(its.triangles.frames);
  const Measures again = measure_lengths(lengths);
  for (Index e = 0; e < lengths.size(); ++e)
    CHECK(std::abs(again.frames[e] - its.triangles.frames[e]) < kClose * 10);
  for (Index f = 0; f < mesh.n_faces(); ++f)
    CHECK(std::abs(again.areas[f] - its.triangles.areas[f]) < kClose);
}

TEST(flips_leave_no_opposite_angles_of_more_than_pi) {
  for (const double shear : {0.0, -0.3, -1.0, -4.0, -30.0, 0.7, 30.0}) {
    for (const Index side : {2, 3, 10, 20}) {
      const Mesh mesh = sheared_grid(side, shear);
      Intrinsic its(mesh);
      const double area = total_area(its.lengths);
      const std::vector<char> held(mesh.n_vertices(), 0);
      const std::span<const bool> nobody(reinterpret_cast<const bool*>(held.data()), held.size());
      const Index flips = flip_edges(its.faces, its.lengths, its.twin, nobody);
      const std::string name = "shear " + std::to_string(shear) + ", side " + std::to_string(side);
      if (shear < 0) CHECK(flips > 0, name);
      if (shear == 0) CHECK(flips == 0, name);
      CHECK(its.is_coherent(), name);
      CHECK(its.largest_opposite_angles() <= std::numbers::pi + 1e-6, name);
      CHECK(std::abs(total_area(its.lengths) - area) < 1e-6 * area, name);
    }
  }
}

TEST(edges_of_held_vertices_stay) {
  const Mesh mesh = sheared_grid(8, 3.0);
  Intrinsic its(mesh);
  const Array<bool> all(mesh.n_vertices(), true);
  CHECK(flip_edges(its.faces, its.lengths, its.twin, all) == 0);
  CHECK(its.faces == mesh.faces);
}

TEST(mean_edge_length_is_that_of_a_pattern) {
  const Mesh mesh = sheared_grid(4, 0.0);
  const double expected = (24 * 1.0 + 9 * std::numbers::sqrt2) / 33;
  const Sparse matrix(cotangent_stiffness(mesh));
  CHECK(std::abs(mean_edge_length(mesh.vertices, matrix.pattern()) - expected) < kClose);
}

TEST(faces_at_marked_vertices_are_found_by_number) {
  const std::vector<Index> faces{0, 1, 2, 2, 3, 4, 4, 5, 6};
  Array<bool> marked(7, false);
  CHECK(faces_at(faces, marked).empty());
  marked[2] = marked[6] = true;
  CHECK(std::ranges::equal(faces_at(faces, marked), std::vector<Index>{0, 1, 2}));
  marked[2] = false;
  CHECK(std::ranges::equal(faces_at(faces, marked), std::vector<Index>{2}));
}

TEST(in_the_plane_directions_are_those_of_edges_and_flips_carry_them_along) {
  for (const double shear : {0.0, -4.0}) {
    const Mesh mesh = sheared_grid(9, shear);
    Intrinsic its(mesh);
    const Array<double> normals = vertex_normals(mesh.vertices, mesh.faces);
    const Array<double> axes = tangent_axes(normals);
    const Array<bool> mirrored(mesh.n_faces(), false), nowhere(mesh.n_vertices(), false);
    Directions own =
        polar_directions(mesh.vertices, mesh.faces, its.lengths, its.twin, mirrored, normals, axes);
    const Index flips =
        flip_edges(its.faces, its.lengths, its.twin, nowhere, own.angles, own.scales);
    CHECK((flips > 0) == (shear < 0));
    for (Index half = 0; half < own.angles.size(); ++half) {
      const Index tail = its.faces[next(half)], head = its.faces[previous(half)];
      const Vector3 step = at(mesh.vertices, head) - at(mesh.vertices, tail);
      const Vector3 x = at(axes, tail), y = cross(at(normals, tail), x);
      const double off = own.angles[half] - std::atan2(dot(step, y), dot(step, x));
      CHECK(std::abs(std::remainder(off, 2 * std::numbers::pi)) < 1e-9);
    }
    const Array<double> turns =
        triangle_turns(its.lengths, bisectors(its.lengths, own.angles, own.scales), mirrored);
    for (Index f = 0; f < mesh.n_faces(); ++f)
      for (int c = 1; c < 3; ++c)
        for (int part = 0; part < 2; ++part)
          CHECK(std::abs(turns[6 * f + 2 * c + part] - turns[6 * f + part]) < 1e-9);
  }
}

TEST(least_rotations_in_the_plane_are_those_of_angles) {
  const Mesh mesh = sheared_grid(5, 0.3);
  const Array<double> normals = vertex_normals(mesh.vertices, mesh.faces);
  const Array<double> axes = tangent_axes(normals);
  const SpaceTurns its = space_turns(mesh.vertices, mesh.faces, 3, normals, axes, false);
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    CHECK(!its.mirrored[f]);
    const Vector3 step =
        at(mesh.vertices, mesh.faces[3 * f + 1]) - at(mesh.vertices, mesh.faces[3 * f]);
    CHECK(std::abs(its.turns[6 * f] - step.x / length(step)) < kClose);  // the x axis is (1, 0, 0)
    CHECK(std::abs(its.turns[6 * f + 1] + step.y / length(step)) < kClose);
  }
}

namespace {

// A shaken grid of squares of side h, rolled up about the x axis with radius 1.
Mesh rolled(Index side, double h) {
  Mesh mesh = sheared_grid(side, 0.0);
  const std::vector<double> shakes = random_numbers(2 * mesh.n_vertices(), 5, -1.0);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const double x = h * (mesh.vertices[3 * v] + 0.3 * shakes[2 * v]);
    const double turn = h * (mesh.vertices[3 * v + 1] + 0.3 * shakes[2 * v + 1]);
    mesh.vertices[3 * v] = x;
    mesh.vertices[3 * v + 1] = std::sin(turn);
    mesh.vertices[3 * v + 2] = std::cos(turn);
  }
  return mesh;
}

double worst_tilt_inside(Index side, double h) {
  const Mesh mesh = rolled(side, h);
  const Array<double> normals = vertex_normals(mesh.vertices, mesh.faces);
  double worst = 0.0;
  for (Index row = 1; row + 1 < side; ++row)
    for (Index column = 1; column + 1 < side; ++column) {
      const Index v = row * side + column;
      const Vector3 exact = unit({0, mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]}, {});
      worst = std::max(worst, length(cross(at(normals, v), exact)));
    }
  return worst;
}

}  // namespace

TEST(normals_of_a_cylinder_converge_with_the_third_order) {
  const double coarse = worst_tilt_inside(12, 0.04), fine = worst_tilt_inside(12, 0.02);
  CHECK(coarse < 1e-4);
  CHECK(fine < coarse / 6);
}

TEST(where_a_plane_is_folded_its_normals_stay) {
  Mesh mesh = sheared_grid(11, 0.2);
  for (Index v = 0; v < mesh.n_vertices(); ++v)
    mesh.vertices[3 * v + 2] = std::abs(mesh.vertices[3 * v + 1] - 5.0);
  const Array<double> normals = vertex_normals(mesh.vertices, mesh.faces);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const double aside = mesh.vertices[3 * v + 1] - 5.0;
    if (aside == 0) continue;
    const Vector3 exact = unit({0, aside > 0 ? -1.0 : 1.0, 1}, {});
    CHECK(length(cross(at(normals, v), exact)) < kClose);
  }
}

TEST(normals_are_the_same_on_any_number_of_threads) {
  const Mesh mesh = rolled(20, 0.05);
  const Array<double> alone = vertex_normals(mesh.vertices, mesh.faces);
  for (const int n_threads : {2, 3, 7})
    CHECK(std::ranges::equal(alone, vertex_normals(mesh.vertices, mesh.faces, n_threads)));
}

TEST(two_rings_have_each_vertex_once) {
  const Index side = 9;
  const Mesh mesh = sheared_grid(side, 0.0);
  const Rings rings(mesh.faces, mesh.n_vertices());
  TwoRings both(rings);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const std::span<const Row> near = both.of(v);
    std::vector<Row> sorted(near.begin(), near.end());
    std::ranges::sort(sorted);
    CHECK(std::ranges::adjacent_find(sorted) == sorted.end());
    const Index row = v / side, column = v % side;
    const auto is_between = [](Index k, Index from, Index to) { return from <= k && k <= to; };
    if (!is_between(row, 1, side - 2) || !is_between(column, 1, side - 2)) CHECK(near.empty());
    if (is_between(row, 2, side - 3) && is_between(column, 2, side - 3)) CHECK(count(near) == 18);
  }
}

TEST(where_many_edges_meet_there_are_no_rings) {
  const Index n = Rings::kMostNeighbours + 1;  // around vertex n, and all of these around n + 1
  std::vector<Index> faces;
  for (Index k = 0; k < n; ++k)
    for (const Index v : {k, (k + 1) % n, n, (k + 1) % n, k, n + 1}) faces.push_back(v);
  const Rings rings(faces, n + 2);
  TwoRings both(rings);
  CHECK(rings.size(n) == n && rings.is_inside(n));
  CHECK(both.of(n).empty());
  CHECK(count(both.of(0)) == 6);  // two neighbours on the rim, both hubs, and two beyond
}

TEST(fits_do_without_neighbours_at_the_place_of_a_vertex) {
  Mesh mesh = rolled(9, 0.05);
  const Array<double> before = vertex_normals(mesh.vertices, mesh.faces);
  const Index middle = 4 * 9 + 4;
  for (Index d = 0; d < 3; ++d) mesh.vertices[3 * (middle + 1) + d] = mesh.vertices[3 * middle + d];
  const Array<double> normals = vertex_normals(mesh.vertices, mesh.faces);
  for (const double part : normals) CHECK(std::isfinite(part));
  CHECK(length(cross(at(normals, middle), at(before, middle))) < 0.01);
}
