// Exact distances by windows.
#include <cmath>
#include <limits>

#include "tests/check.hpp"
#include "tests/examples.hpp"
#include "windows/windows.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();
constexpr Index kMany = 1 << 20;

// One point, with the vertices around it.
struct Point {
  std::vector<Index> begins, vertices;
  std::vector<double> shares, distances, starts{0.0};

  explicit Point(Index vertex) : begins{0, 1}, vertices{vertex}, shares{1.0}, distances{0.0} {}
  Point(const Mesh& mesh, std::vector<Index> around, std::vector<double> weights)
      : begins{0, static_cast<Index>(around.size())}, vertices(around), shares(weights) {
    for (const Index v : around) distances.push_back(from(mesh, v));
  }
  double from(const Mesh& mesh, Index v) const {
    double place[3]{};
    for (std::size_t i = 0; i < vertices.size(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        place[axis] += shares[i] * mesh.vertices[3 * vertices[i] + axis];
    const double* const at = &mesh.vertices[3 * v];
    return std::hypot(at[0] - place[0], at[1] - place[1], at[2] - place[2]);
  }
  PointsOnFaces view() const { return {begins, vertices, shares, distances, starts}; }
};

const Mesh kTetrahedron{{1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1},
                        {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2}};

}  // namespace

TEST(windows_go_straight_over_a_plane_however_it_is_divided) {
  const Mesh mesh = sheared_grid(12, 0.4);
  const Polyhedron shape(mesh.vertices, mesh.faces);
  std::vector<double> distances(mesh.n_vertices());
  const Index* const face = &mesh.faces[3 * 50];
  for (const Point& point : {Point(40), Point(mesh, {face[0], face[1]}, {0.3, 0.7}),
                             Point(mesh, {face[2], face[0], face[1]}, {0.2, 0.5, 0.3})}) {
    CHECK(exact_distances(shape, point.view(), kMany, distances));
    for (Index v = 0; v < mesh.n_vertices(); ++v)
      CHECK(std::abs(distances[v] - point.from(mesh, v)) < 1e-12);
  }
}

TEST(from_the_middle_of_a_face_of_a_tetrahedron_the_tip_is_two_faces_away) {
  const Polyhedron shape(kTetrahedron.vertices, kTetrahedron.faces);
  std::vector<double> distances(4);
  const double third = 1.0 / 3, edge = std::sqrt(8.0), height = edge * std::sqrt(3.0) / 2;
  const Point point(kTetrahedron, {0, 1, 2}, {third, third, third});
  CHECK(exact_distances(shape, point.view(), kMany, distances));
  for (Index v = 0; v < 3; ++v) CHECK(std::abs(distances[v] - 2 * height / 3) < 1e-14);
  CHECK(std::abs(distances[3] - 4 * height / 3) < 1e-14);
}

TEST(what_no_face_connects_is_infinitely_far) {
  Mesh mesh = kTetrahedron;
  for (const double x : {5.0, 6.0, 7.0}) mesh.vertices.insert(mesh.vertices.end(), {x, x * x, 0});
  mesh.faces.insert(mesh.faces.end(), {4, 5, 6});
  const Polyhedron shape(mesh.vertices, mesh.faces);
  std::vector<double> distances(7);
  CHECK(exact_distances(shape, Point(0).view(), kMany, distances));
  for (Index v = 0; v < 7; ++v) CHECK((distances[v] == kNowhere) == (v > 3));
}

TEST(a_search_is_given_up_after_so_many_windows) {
  const Polyhedron shape(kTetrahedron.vertices, kTetrahedron.faces);
  std::vector<double> distances(4);
  CHECK(!exact_distances(shape, Point(0).view(), 0, distances));
}
