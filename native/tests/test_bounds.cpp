// Distances held between the straight line and the path along edges.
#include <cmath>
#include <limits>

#include "bounds/bounds.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();

// Some vertices of a mesh, as places at which random distances are read.
struct Some {
  std::vector<double> positions, distances;

  Some(const Mesh& mesh, Index count) : distances(random_numbers(count, 3)) {
    for (Index k = 0; k < count; ++k) {
      const Index v = k * mesh.n_vertices() / count;
      positions.insert(positions.end(), &mesh.vertices[3 * v], &mesh.vertices[3 * v] + 3);
    }
  }

  SourceValues starts() const { return {positions, distances}; }

  double straight(const double* point) const {
    double least = kNowhere;
    for (std::size_t k = 0; k < distances.size(); ++k) {
      const double x = point[0] - positions[3 * k], y = point[1] - positions[3 * k + 1];
      least = std::min(least, distances[k] + std::hypot(x, y, point[2] - positions[3 * k + 2]));
    }
    return least;
  }
};

double edge_length(const Mesh& mesh, Index a, Index b) {
  const double* const p = &mesh.vertices[3 * a];
  const double* const q = &mesh.vertices[3 * b];
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

}  // namespace

TEST(places_know_the_least_that_any_of_them_reads) {
  const Mesh mesh = sheared_grid(20, 0.4);
  for (const Index count : {1, 7, 9, 150}) {
    const Some some(mesh, count);
    SourceTree places(some.starts());
    for (Index v = 0; v < mesh.n_vertices(); ++v) {
      const double* const point = &mesh.vertices[3 * v];
      const double expected = some.straight(point);
      CHECK(std::abs(places.straight(point, 0.0) - expected) < 1e-14);
      CHECK(places.straight(point, expected + 0.1) <= expected + 0.1);
      if (places.last_reads_at_most(0.9 * expected, point)) CHECK(expected == 0);
    }
  }
}

TEST(distances_are_raised_to_the_straight_line_and_no_farther) {
  const Mesh mesh = sheared_grid(15, 0.2);
  const Some some(mesh, 12);
  std::vector<double> distances = random_numbers(mesh.n_vertices(), 5);
  distances[7] = kNowhere;
  const std::vector<double> before = distances;
  raise_to_straight_line(mesh.vertices, some.starts(), distances);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const double expected = std::max(before[v], some.straight(&mesh.vertices[3 * v]));
    CHECK(distances[v] == kNowhere ? v == 7 : std::abs(distances[v] - expected) < 1e-14);
  }
}

TEST(no_edge_is_shorter_than_what_distances_differ_by_at_its_ends) {
  const Mesh mesh = sheared_grid(15, 0.2);
  const Matrix edges = edges_of(mesh.faces, mesh.n_vertices());
  std::vector<double> distances = random_numbers(mesh.n_vertices(), 8);
  for (double& distance : distances) distance *= 3;
  distances[30] = kNowhere;
  const std::vector<double> before = distances;
  EdgeBounds(mesh.vertices, {edges.indptr, edges.indices}).lower(distances);
  CHECK(distances[30] == kNowhere);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const Index a = mesh.faces[i], b = mesh.faces[i - i % 3 + (i + 1) % 3];
    if (a == 30 || b == 30) continue;
    CHECK(std::abs(distances[a] - distances[b]) <= edge_length(mesh, a, b) + 1e-12);
    CHECK(distances[a] <= before[a]);
  }
}

TEST(distances_that_are_possible_stay_to_the_bit) {
  const Mesh mesh = sheared_grid(15, 0.2);
  const Matrix edges = edges_of(mesh.faces, mesh.n_vertices());
  std::vector<double> distances;
  for (Index v = 0; v < mesh.n_vertices(); ++v) distances.push_back(edge_length(mesh, v, 40));
  const std::vector<double> before = distances, at_zero{0.0};
  const std::vector<double> place(&mesh.vertices[120], &mesh.vertices[120] + 3);
  EdgeBounds(mesh.vertices, {edges.indptr, edges.indices}).lower(distances);
  CHECK(distances == before);
  raise_to_straight_line(mesh.vertices, {place, at_zero}, distances);
  for (Index v = 0; v < mesh.n_vertices(); ++v) CHECK(std::abs(distances[v] - before[v]) < 1e-14);
}
