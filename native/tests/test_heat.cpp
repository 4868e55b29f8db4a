// The steps of the heat method between its solves.
#include <cmath>
#include <limits>

#include "heat/connection.hpp"
#include "heat/filling.hpp"
#include "heat/poisson_load.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"
#include "triangles/half_edges.hpp"
#include "triangles/measures.hpp"
#include "triangles/stiffness.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

// G' W X with X = -grad u / |grad u|, triangle by triangle and column by column.
std::vector<double> plain_load(const Mesh& mesh, const Measures& its,
                               const std::vector<double>& heat, Index n_columns) {
  std::vector<double> load(heat.size(), 0.0);
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const Index* const corner = &mesh.faces[3 * f];
    const double p = its.frames[3 * f], q = its.frames[3 * f + 1], r = its.frames[3 * f + 2];
    for (Index c = 0; c < n_columns; ++c) {
      const double u = heat[corner[0] * n_columns + c];
      const double du = heat[corner[1] * n_columns + c] - u;
      const double dv = heat[corner[2] * n_columns + c] - u;
      double x = p * du, y = q * du + r * dv;
      const double size = std::sqrt(x * x + y * y);
      if (size == 0) continue;
      x *= -its.areas[f] / size;
      y *= -its.areas[f] / size;
      const double first = p * x + q * y, second = r * y;
      load[corner[0] * n_columns + c] -= first + second;
      load[corner[1] * n_columns + c] += first;
      load[corner[2] * n_columns + c] += second;
    }
  }
  return load;
}

}  // namespace

TEST(poisson_loads_are_those_of_plain_loops) {
  for (const Index side : {2, 7, 15}) {
    const Mesh mesh = sheared_grid(side, 0.4);
    const Measures its = measure_triangles(mesh.vertices, mesh.faces).triangles;
    const Triangles triangles{mesh.faces, its.frames, its.areas};
    for (const Index n_columns : {1, 2, 3, 4, 5, 16, 17, 40}) {
      const std::vector<double> heat = random_numbers(mesh.n_vertices() * n_columns, 9, 0.01);
      std::vector<double> logarithms;
      for (const double value : heat) logarithms.push_back(std::log(value));
      const std::vector<double> expected = plain_load(mesh, its, heat, n_columns);
      const Array<double> plain = poisson_load(triangles, heat, n_columns, false);
      const Array<double> scaled = poisson_load(triangles, logarithms, n_columns, true);
      double worst = 0.0;
      for (Index k = 0; k < plain.size(); ++k)
        worst =
            std::max({worst, std::abs(plain[k] - expected[k]), std::abs(scaled[k] - expected[k])});
      CHECK(worst < 1e-11, std::to_string(n_columns) + " columns, error " + std::to_string(worst));
    }
  }
}

TEST(heat_of_any_size_has_a_direction) {
  const Mesh mesh = sheared_grid(9, 0.2);
  const Measures its = measure_triangles(mesh.vertices, mesh.faces).triangles;
  const Triangles triangles{mesh.faces, its.frames, its.areas};
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double scale : {1.0, 1e3, 1e8, 1e9, 1e10, 1e300, infinity, -infinity, std::nan("")}) {
    for (const Index n_columns : {1, 5}) {
      std::vector<double> logarithms = random_numbers(mesh.n_vertices() * n_columns, 2, -1.0);
      for (double& value : logarithms) value *= scale;
      const Array<double> load = poisson_load(triangles, logarithms, n_columns, true);
      bool finite = true;
      for (const double value : load) finite &= std::isfinite(value);
      CHECK(finite || scale == infinity || scale == -infinity || std::isnan(scale),
            std::to_string(scale));
    }
  }
}

TEST(heat_without_a_slope_is_no_load) {
  const Mesh mesh = sheared_grid(5, 0.0);
  const Measures its = measure_triangles(mesh.vertices, mesh.faces).triangles;
  const std::vector<double> heat(mesh.n_vertices() * 4, 0.5);
  for (const double value : poisson_load({mesh.faces, its.frames, its.areas}, heat, 4, false))
    CHECK(value == 0.0);
}

TEST(a_slope_of_rounding_is_no_load) {
  const Mesh mesh = sheared_grid(5, 0.0);
  const Measures its = measure_triangles(mesh.vertices, mesh.faces).triangles;
  for (const Index n_columns : {1, 5}) {
    for (const double size : {1e-290, 0.5, 1e4}) {
      std::vector<double> heat = random_numbers(mesh.n_vertices() * n_columns, 3, -1e-14);
      for (double& value : heat) value = size * (1 + 1e-14 * value);
      for (const double value :
           poisson_load({mesh.faces, its.frames, its.areas}, heat, n_columns, false))
        CHECK(value == 0.0);
      for (double& value : heat) value = std::log(value);
      for (const double value :
           poisson_load({mesh.faces, its.frames, its.areas}, heat, n_columns, true))
        CHECK(value == 0.0);
    }
  }
}

TEST(missing_heat_is_filled_from_its_neighbours) {
  for (const Index stride : {1, 3}) {
    const Row side = 9;
    const Sparse matrix = grid(side, 0.5);
    std::vector<double> solution(1 + (matrix.size() - 1) * stride, 0.0);
    std::vector<Row> rows;
    for (Row v = 0; v < matrix.size(); ++v) {
      if (v % side < 3)
        solution[v * stride] = 1.0 + v % 4;
      else
        rows.push_back(v);
    }
    const std::vector<double> before = solution;
    fill(matrix.view(), solution, stride, rows);
    for (Row v = 0; v < matrix.size(); ++v) {
      CHECK(solution[v * stride] > 0.0);
      if (v % side < 3) CHECK(solution[v * stride] == before[v * stride]);
      if (v % side == 3)
        CHECK(std::abs(solution[v * stride] - before[(v - 1) * stride] / (0.5 + 2 + (v >= side) +
                                                                          (v < 8 * side))) < 1e-15);
    }
  }
}

TEST(what_no_heat_reaches_stays_empty) {
  const Sparse matrix(diagonal(5, 1.0));
  std::vector<double> solution{1.0, 0.0, 0.0, 0.0, 0.0};
  std::vector<Row> rows{1, 2, 3, 4};
  fill(matrix.view(), solution, 1, rows);
  CHECK((solution == std::vector<double>{1.0, 0.0, 0.0, 0.0, 0.0}));
  fill(matrix.view(), solution, 1, {});
}

TEST(a_connection_without_turning_is_the_stiffness_and_its_real_form_has_it_twice) {
  const Mesh mesh = sheared_grid(5, 0.4);
  const Measured measured = measure_triangles(mesh.vertices, mesh.faces);
  const EdgeSums sums = edge_sums(mesh.faces, sorted_half_edges(mesh.faces, mesh.n_vertices()),
                                  measured.triangles.frames, measured.triangles.areas);
  const Matrix stiffness = mirrored({{sums.edges.indptr, sums.edges.indices}, sums.edges.data});
  const Pattern pattern{stiffness.indptr, stiffness.indices};
  Array<double> turns(2 * count(std::span(mesh.faces)));
  for (Index k = 0; k < turns.size(); ++k) turns[k] = k % 2 ? 0.0 : 1.0;
  const auto found = connection_laplacian(pattern, mesh.faces, measured.triangles.frames,
                                          measured.triangles.areas, turns);
  CHECK(found.has_value());
  const Array<double>& entries = *found;
  for (Index k = 0; k < stiffness.data.size(); ++k) {
    CHECK(std::abs(entries[2 * k] - stiffness.data[k]) < 1e-12);
    CHECK(std::abs(entries[2 * k + 1]) < 1e-12);
  }
  const Array<double> ones(mesh.n_vertices(), 1.0), none(mesh.n_vertices(), 0.0);
  const Matrix real = real_form(pattern, entries, ones, none);
  CHECK(real.indptr.size() == 2 * mesh.n_vertices() + 1);
  for (Row i = 0; i < 2 * mesh.n_vertices(); ++i)
    for (Row k = real.indptr[i]; k < real.indptr[i + 1]; ++k)
      if ((real.indices[k] - i) % 2 != 0) CHECK(std::abs(real.data[k]) < 1e-12);
}

TEST(the_polar_form_of_small_and_large_numbers_is_exact_to_rounding) {
  for (const double scale : {1.0, 1e-290, 1e290}) {
    const std::vector<double> pairs = {3 * scale, -4 * scale, 0.0, 2 * scale, 0.0, 0.0};
    const Polar its = polar_form(pairs);
    CHECK(std::abs(its.sizes[0] / (5 * scale) - 1) < 1e-15);
    CHECK(std::abs(its.sizes[1] / (2 * scale) - 1) < 1e-15);
    CHECK(its.sizes[2] == 0.0);
    const double wanted[6] = {0.6, -0.8, 0.0, 1.0, 0.0, 0.0};
    for (Index k = 0; k < 6; ++k) CHECK(std::abs(its.directions[k] - wanted[k]) < 1e-15);
  }
}
