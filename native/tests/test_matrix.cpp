// Checks of a stiffness: components, soundness, signs, diagonal.
#include <cmath>
#include <limits>

#include "matrix/checks.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

// Components by passing labels on until nothing changes.
std::vector<Index> spread_labels(const Sparse& matrix) {
  std::vector<Index> label(matrix.size());
  for (Index v = 0; v < matrix.size(); ++v) label[v] = v;
  for (bool changed = true; changed;) {
    changed = false;
    for (Index v = 0; v < matrix.size(); ++v) {
      for (Row p = matrix.indptr[v]; p < matrix.indptr[v + 1]; ++p) {
        const Index least = std::min(label[v], label[matrix.indices[p]]);
        changed |= label[v] != least || label[matrix.indices[p]] != least;
        label[v] = label[matrix.indices[p]] = least;
      }
    }
  }
  Index count = 0;
  for (Index v = 0; v < matrix.size(); ++v) label[v] = label[v] == v ? count++ : label[label[v]];
  return label;
}

std::vector<double> plain_excess(const Sparse& matrix, const std::vector<double>& mass,
                                 Index rings) {
  const Index n = matrix.size();
  std::vector<double> excess(n), area = mass;
  for (Index v = 0; v < n; ++v) {
    double positive = 0.0, absolute = 0.0;
    for (Row p = matrix.indptr[v]; p < matrix.indptr[v + 1]; ++p) {
      if (matrix.indices[p] == v) continue;
      positive += std::max(matrix.data[p], 0.0);
      absolute += std::abs(matrix.data[p]);
    }
    excess[v] = absolute > 0 ? positive / absolute * mass[v] : 0.0;
  }
  for (Index ring = 0; ring < rings; ++ring) {
    std::vector<double> wider = excess, more = area;
    for (Index v = 0; v < n; ++v) {
      for (Row p = matrix.indptr[v]; p < matrix.indptr[v + 1]; ++p) {
        if (matrix.indices[p] == v) continue;
        wider[v] += excess[matrix.indices[p]];
        more[v] += area[matrix.indices[p]];
      }
    }
    excess = wider;
    area = more;
  }
  for (Index v = 0; v < n; ++v) excess[v] = area[v] > 0 ? excess[v] / area[v] : 0.0;
  return excess;
}

}  // namespace

TEST(components_are_numbered_by_their_first_vertices) {
  for (const Row n : {1, 2, 7, 90, 1000}) {
    for (const double edges : {0.0, 0.3, 0.6, 2.0}) {
      const Sparse matrix = random_graph(n, edges, false, 0.0, 3);
      const std::vector<Index> expected = spread_labels(matrix);
      const Array<Index> found = components(matrix.pattern());
      CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    }
  }
  CHECK(components(Sparse{Entries()}.pattern()).empty());
}

TEST(one_side_of_the_diagonal_is_enough_for_components) {
  Entries rows = diagonal(6, 0.0);
  rows[4][1] = rows[5][4] = rows[0][3] = 1.0;
  const Array<Index> found = components(Sparse(rows).pattern());
  const Index expected[] = {0, 1, 2, 0, 1, 1};
  CHECK(std::equal(found.begin(), found.end(), expected));
}

TEST(laplacians_are_sound) {
  for (const Row side : {1, 2, 7, 40}) CHECK(is_sound(grid(side, 0.0).view()));
  CHECK(is_sound(Sparse{Entries()}.view()));
}

TEST(what_is_unsound_is_told) {
  CHECK(!is_sound(grid(7, 0.1).view()));  // does not kill constants
  const Sparse sound = grid(7, 0.0);
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity(), 5.0}) {
    for (const std::size_t place : {std::size_t{0}, sound.data.size() / 2, sound.data.size() - 1}) {
      Sparse broken = sound;
      broken.data[place] = value;
      CHECK(!is_sound(broken.view()));
    }
  }
  Sparse negative = sound;
  for (double& value : negative.data) value = -value;
  CHECK(!is_sound(negative.view()));
  Entries rows = diagonal(3, 0.0);  // rows add up to 0, columns do not
  rows[0] = {{0, 1.0}, {1, -1.0}};
  rows[1] = {{1, 1.0}, {2, -1.0}};
  rows[2] = {{0, -1.0}, {2, 1.0}};
  CHECK(!is_sound(Sparse(rows).view()));
}

TEST(obtuse_excess_is_that_of_plain_loops) {
  for (const Row n : {1, 2, 7, 200}) {
    Entries rows = diagonal(n, 0.0);
    for (Row v = 0; v < n; ++v)
      for (Row step = 1; step < 4; ++step)
        if (v + step < n) add_edge(rows, v, v + step, (v * step) % 5 - 1.0);
    const Sparse matrix(rows);
    const std::vector<double> mass = random_numbers(n, 4);
    for (const Index rings : {0, 1, 5}) {
      const std::vector<double> expected = plain_excess(matrix, mass, rings);
      const Array<double> found = obtuse_excess(matrix.view(), mass, rings);
      for (Row v = 0; v < n; ++v) CHECK(std::abs(found[v] - expected[v]) < 1e-13);
    }
  }
}

TEST(a_diagonal_is_added_where_it_is) {
  const Sparse matrix({{{0, 2.0}, {2, -1.0}}, {{1, 3.0}}, {{0, -1.0}, {2, 4.0}}});
  const Array<Index> places = diagonal_places(matrix.pattern());
  CHECK(std::ranges::equal(places, std::vector<Index>{0, 2, 4}));
  const std::vector<double> diagonal{10, 20, 30}, one{2.0}, each{1.0, 2.0, 3.0};
  CHECK(std::ranges::equal(plus_diagonal(matrix.view(), places, one, diagonal),
                           std::vector<double>{14, -2, 26, -2, 38}));
  CHECK(std::ranges::equal(plus_diagonal(matrix.view(), places, each, diagonal),
                           std::vector<double>{12, -1, 26, -3, 42}));
}

TEST(rows_without_a_diagonal_entry_have_no_place) {
  const Sparse matrix({{{1, 1.0}}, {{0, 1.0}, {1, 2.0}}, {}});
  CHECK(std::ranges::equal(diagonal_places(matrix.pattern()), std::vector<Index>{2}));
}

TEST(rows_are_summed) {
  const Sparse matrix({{{0, 2.0}, {2, -1.0}}, {}, {{0, -1.0}, {2, 4.0}}});
  CHECK(std::ranges::equal(row_sums(matrix.view()), std::vector<double>{1, 0, 3}));
}
