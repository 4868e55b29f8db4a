// Shortest paths over triangles: a plane, a fold of three sheets at an edge, parts that do not
// meet.
#include <cmath>

#include "paths/candidates.hpp"
#include "paths/straight.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"
#include "triangles/half_edges.hpp"
#include "triangles/measures.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr Index kSide = 20;

struct Sheet {
  std::vector<double> places;
  std::vector<Index> faces;
};

// A square of unit cells, cut along one diagonal, its inner vertices shaken.
Sheet square() {
  Sheet sheet;
  const std::vector<double> shaken = random_numbers(2 * (kSide + 1) * (kSide + 1), 3, -0.3);
  for (Index y = 0; y <= kSide; ++y) {
    for (Index x = 0; x <= kSide; ++x) {
      const bool inner = x % kSide != 0 && y % kSide != 0;
      const double* const shift = &shaken[2 * (y * (kSide + 1) + x)];
      sheet.places.insert(sheet.places.end(),
                          {static_cast<double>(x) + (inner ? 0.2 * shift[0] : 0.0),
                           static_cast<double>(y) + (inner ? 0.2 * shift[1] : 0.0), 0.0});
    }
  }
  for (Index y = 0; y < kSide; ++y) {
    for (Index x = 0; x < kSide; ++x) {
      const Index v = y * (kSide + 1) + x, w = v + kSide + 1;
      sheet.faces.insert(sheet.faces.end(), {v, v + 1, w + 1, v, w + 1, w});
    }
  }
  return sheet;
}

// Distances along x and y together: descent by them leads far from the straight line.
std::vector<double> taxicab(const Sheet& sheet, Index from) {
  std::vector<double> distances;
  for (Index v = 0; v < count(std::span(sheet.places)) / 3; ++v)
    distances.push_back(std::abs(sheet.places[3 * v] - sheet.places[3 * from]) +
                        std::abs(sheet.places[3 * v + 1] - sheet.places[3 * from + 1]));
  return distances;
}

double length_of(const Sheet& sheet, const std::vector<Crossing>& points) {
  double length = 0, before[3];
  for (std::size_t i = 0; i < points.size(); ++i) {
    double squared = 0;
    for (Index c = 0; c < 3; ++c) {
      const double at = (1 - points[i].share) * sheet.places[3 * points[i].left + c] +
                        points[i].share * sheet.places[3 * points[i].right + c];
      if (i > 0) squared += (at - before[c]) * (at - before[c]);
      before[c] = at;
    }
    length += std::sqrt(squared);
  }
  return length;
}

}  // namespace

TEST(a_way_over_a_plane_is_straight_however_it_was_begun) {
  const Sheet sheet = square();
  const Surface surface(sheet.places, sheet.faces);
  const Index start = 0, end = 13 * (kSide + 1) + kSide;
  const std::vector<Crossing> path =
      best_path(surface, taxicab(sheet, end), taxicab(sheet, start), start, std::vector{end});
  CHECK(path.front().left == start && path.back().left == end);
  CHECK(std::abs(length_of(sheet, path) - std::hypot(kSide, 13)) < 1e-9);
}

TEST(a_way_through_a_hollow_goes_along_edges_first) {
  const Sheet sheet = square();
  const Surface surface(sheet.places, sheet.faces);
  const std::vector<double> nothing(sheet.places.size() / 3, 0.0);
  const Index end = (kSide + 1) * (kSide + 1) - 1;
  const std::vector<Crossing> path = best_path(surface, nothing, nothing, 0, std::vector{end});
  CHECK(std::abs(length_of(sheet, path) - kSide * std::sqrt(2.0)) < 1e-9);
}

TEST(where_no_triangle_leads_there_is_no_way) {
  const std::vector<double> places{0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
  const std::vector<Index> faces{0, 1, 2, 3, 4, 5};
  const std::vector<double> nothing(6, 0.0);
  CHECK(best_path(Surface(places, faces), nothing, nothing, 0, std::vector<Index>{4}).empty());
}

TEST(triangles_of_several_stars_are_counted_once) {
  const std::vector<Index> elements{2, 0, 1, 1, 2, 0, 3, 1, 2, 4, 5, 5};
  const Distinct found = distinct_triangles(elements);
  CHECK((found.triangles == std::vector<Index>{0, 1, 2, 1, 2, 3}));
  CHECK((found.stars == std::vector<Index>{2, 1}));
}

TEST(in_the_plane_a_straightest_line_is_straight_and_ends_at_the_boundary) {
  const Sheet sheet = square();
  const Measured measured = measure_triangles(sheet.places, sheet.faces);
  const Array<double> lengths = edge_lengths(measured.triangles.frames);
  const Index n_vertices = count(std::span(sheet.places)) / 3;
  const Twins twin = twins(sorted_half_edges(sheet.faces, n_vertices));
  const Array<Index> face(1, 2 * (kSide * (kSide / 2) + kSide / 2));
  const Array<double> weights(3, 1.0 / 3);
  for (const double length : {0.01, 3.0, 100.0}) {
    const StraightLines lines = straight_lines(
        lengths, twin.of, face, weights, Array<double>(1, 0.7), Array<double>(1, length), 1000);
    double places[2][2] = {{0, 0}, {0, 0}};
    for (int end = 0; end < 2; ++end) {
      const Index point = end ? lines.begins[1] - 1 : 0;
      for (int c = 0; c < 3; ++c)
        for (int axis = 0; axis < 2; ++axis)
          places[end][axis] += lines.weights[3 * point + c] *
                               sheet.places[3 * sheet.faces[3 * lines.faces[point] + c] + axis];
    }
    const double gone = std::hypot(places[1][0] - places[0][0], places[1][1] - places[0][1]);
    CHECK(std::abs(gone + lines.missing[0] - length) < 1e-9);
    CHECK((lines.missing[0] > 0) == (length > 50));
  }
}
