// The Cholesky solver: orders, factors, solves, and what it must refuse.
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "core/errors.hpp"
#include "linear/factor.hpp"
#include "linear/front.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr double kClose = 1e-10;        // of solutions around 1, of condition numbers up to 1e3
constexpr double kCompactClose = 1e-3;  // 20 bits, times such condition numbers
constexpr Index kColumns[] = {1, 2, 3, 5, 16, 17, 40};

std::shared_ptr<const Analysis> analysis_of(const Sparse& matrix) {
  return analyze(matrix.pattern(), minimum_degree(matrix.pattern()));
}

Factor factor_of(const Sparse& matrix, bool compact = false) {
  return {analysis_of(matrix), matrix.data, compact};
}

// The largest error of a solution whose values are known, with b in the place of x at last.
double error_of(const Sparse& matrix, const Factor& factor, Index n_columns) {
  const std::vector<double> expected = random_numbers(matrix.size() * n_columns, 5);
  std::vector<double> b = matrix.times(expected, n_columns), x(b.size());
  factor.solve(b, x, n_columns);
  factor.solve(b, b, n_columns);
  double worst = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    worst = std::max(worst, std::abs(x[k] - expected[k]));
    worst = std::max(worst, std::abs(x[k] - b[k]));
  }
  return worst;
}

void check_solves(const Sparse& matrix, const std::string& name) {
  for (const bool compact : {false, true}) {
    const Factor factor = factor_of(matrix, compact);
    for (const Index n_columns : kColumns) {
      const double error = error_of(matrix, factor, n_columns);
      CHECK(error <= (compact ? kCompactClose : kClose),
            name + (compact ? ", compact, " : ", ") + std::to_string(n_columns) +
                " columns, error " + std::to_string(error));
    }
  }
}

// Eliminate the first columns of a dense matrix, in plain loops; of its lower triangle.
std::vector<double> eliminated(std::vector<double> front, Index height, Index width) {
  for (Index c = 0; c < width; ++c) {
    double* const column = front.data() + c * height;
    const double root = std::sqrt(column[c]);
    for (Index i = c; i < height; ++i) column[i] /= root;
    for (Index j = c + 1; j < height; ++j)
      for (Index i = j; i < height; ++i) front[j * height + i] -= column[i] * column[j];
  }
  return front;
}

// Compare a front of whichever shape with plain loops; of pairs only the even columns. Memory is as
// large as it must be, so that the address sanitizer sees what reaches past it.
void check_front(std::vector<double> whole, Index height, Index width, bool in_pairs) {
  const std::string shape = std::to_string(height) + " rows, " + std::to_string(width) +
                            " columns" + (in_pairs ? ", pairs" : "");
  const Index every = in_pairs ? 2 : 1;
  for (Index c = 0; c < height; ++c) whole[c * height + c] += static_cast<double>(height);
  const std::vector<double> expected = eliminated(whole, height, width);
  std::vector<double> panel(whole.begin(), whole.begin() + height * width);
  const Index below = height - width;
  std::vector<double> update(below * below), workspace(front::packed_size(height));
  CHECK(front::eliminate(panel.data(), update.data(), height, width, in_pairs, workspace.data()) ==
            kNone,
        shape);
  double worst = 0.0;
  for (Index c = 0; c < width; c += every) {
    worst = std::max(worst, std::abs(panel[c * height + c] * expected[c * height + c] - 1.0));
    for (Index i = c + 1; i < height; ++i)
      worst = std::max(worst, std::abs(panel[c * height + i] - expected[c * height + i]));
  }
  for (Index j = 0; j < below; j += every) {
    for (Index i = j; i < below; ++i) {
      const Index place = (width + j) * height + width + i;
      worst = std::max(worst, std::abs(update[j * below + i] - expected[place] + whole[place]));
    }
  }
  CHECK(worst < kClose * static_cast<double>(height), shape + ", error " + std::to_string(worst));
}

void check_front(Index height, Index width) {
  check_front(random_numbers(height * height, 3), height, width, false);
}

// The real form of complex numbers, without those above the diagonal.
void check_pairs(Index height, Index width) {
  std::vector<double> whole = random_numbers(height * height, 3);
  for (Index c = 0; c < height; c += 2) {
    whole[c * height + c + 1] = 0.0;
    for (Index i = c; i < height; i += 2) {
      whole[(c + 1) * height + i] = -whole[c * height + i + 1];
      whole[(c + 1) * height + i + 1] = whole[c * height + i];
    }
  }
  check_front(whole, height, width, true);
}

}  // namespace

TEST(fronts_of_every_small_shape_are_eliminated) {
  for (Index height = 1; height <= 24; ++height)
    for (Index width = 1; width <= height; ++width) check_front(height, width);
}

TEST(fronts_of_several_chunks_and_slabs_are_eliminated) {
  for (const Index height : {129, 135, 320, 321, 337})
    for (const Index width : {1, 3, 4, 127, 128, 129}) check_front(height, width);
}

TEST(fronts_of_complex_numbers_are_eliminated) {
  for (Index height = 2; height <= 24; height += 2)
    for (Index width = 2; width <= height; width += 2) check_pairs(height, width);
  for (const Index height : {130, 320, 322, 338})
    for (const Index width : {2, 6, 126, 128, 130}) check_pairs(height, width);
}

// A grid whose edges turn: entries i < j are multiplied by a complex number of length 1.
TEST(complex_systems_are_solved_in_pairs) {
  for (const Row side : {1, 2, 7, 40, 90}) {
    const Sparse matrix = grid(side, 0.1);
    const Index n = matrix.size();
    const auto analysis = in_pairs(*analysis_of(matrix), matrix.indptr);
    std::vector<double> data;
    for (Index i = 0; i < n; ++i)
      for (int part = 0; part < 2; ++part)
        for (Row k = matrix.indptr[i]; k < matrix.indptr[i + 1]; ++k) {
          const Index j = matrix.indices[k];
          const double turn = i == j ? 0.0 : (i < j ? 1.0 : -1.0) * static_cast<double>(i + j);
          const double re = matrix.data[k] * std::cos(turn), im = matrix.data[k] * std::sin(turn);
          data.push_back(part ? im : re);
          data.push_back(part ? re : -im);
        }
    const Factor factor(analysis, data, false);
    CHECK(factor.nbytes() <= Factor::nbytes_needed(*analysis, false));
    for (const Index n_columns : {1, 3}) {
      const std::vector<double> b = random_numbers(2 * n * n_columns, 5);
      std::vector<double> x = b;
      factor.solve(x, x, n_columns);
      double worst = 0.0;
      for (Index row = 0; row < 2 * n; ++row)
        for (Index column = 0; column < n_columns; ++column) {
          const Index i = row / 2, count = matrix.indptr[i + 1] - matrix.indptr[i];
          const double* const entry =
              data.data() + 4 * matrix.indptr[i] + (row % 2 ? 2 * count : 0);
          double sum = -b[row * n_columns + column];
          for (Index k = 0; k < 2 * count; ++k) {
            const Index j = 2 * matrix.indices[matrix.indptr[i] + k / 2] + k % 2;
            sum += entry[k] * x[j * n_columns + column];
          }
          worst = std::max(worst, std::abs(sum));
        }
      CHECK(worst < kClose, std::to_string(side) + ", error " + std::to_string(worst));
    }
  }
}

TEST(grids_are_solved) {
  for (const Row side : {1, 2, 7, 40, 90})
    check_solves(grid(side, 0.1), "a grid of " + std::to_string(side));
}

TEST(random_graphs_are_solved) {
  for (const Row n : {1, 2, 7, 40, 90, 400}) {
    for (const double edges : {0.0, 0.7, 3.0})
      check_solves(random_graph(n, edges, false, 0.1, 11), "a graph of " + std::to_string(n));
  }
}

TEST(full_rows_are_solved) {
  for (const Row n : {17, 18, 100, 500})
    check_solves(random_graph(n, 1.0, true, 0.1, 7), "a hub of " + std::to_string(n));
}

TEST(a_dense_matrix_is_solved) {
  const Row n = 400;
  Entries rows(n);
  for (Row i = 0; i < n; ++i) {
    for (Row j = 0; j < n; ++j) rows[i][j] = 1.0 / (1 + (i + j) % 13);
    rows[i][i] += 2.0 * n;
  }
  const Sparse dense(rows);
  CHECK(analysis_of(dense)->n_supernodes() == 1);
  check_solves(dense, "a dense matrix");
}

TEST(wide_supernodes_with_many_rows_below_are_solved) {
  const Sparse matrix = cliques(130, 330, 1950, 10.0);  // degrees below 10 sqrt(n): not full
  const auto analysis = analysis_of(matrix);
  Index widest = 0;
  for (Index s = 0; s < analysis->n_supernodes(); ++s)
    if (analysis->below(s) >= 330) widest = std::max(widest, analysis->width(s));
  CHECK(widest >= 130);
  check_solves(matrix, "cliques");
}

TEST(a_system_without_unknowns_is_solved) {
  const Sparse nothing{Entries()};
  CHECK(is_symmetric(nothing.pattern()));
  const Factor factor = factor_of(nothing);
  for (const Index n_columns : kColumns) factor.solve({}, {}, n_columns);
}

TEST(an_analysis_is_a_permutation_and_a_tree) {
  const Sparse matrix = random_graph(300, 2.0, true, 0.1, 1);
  const auto its = analysis_of(matrix);
  std::vector<bool> seen(matrix.size(), false);
  for (const Row v : its->order) seen[v] = true;
  CHECK(std::find(seen.begin(), seen.end(), false) == seen.end());
  CHECK(its->first[its->n_supernodes()] == matrix.size());
  for (Index s = 0; s < its->n_supernodes(); ++s) {
    CHECK(its->parents[s] == kNone ? its->below(s) == 0 : its->parents[s] > s);
    CHECK(std::is_sorted(its->rows_of(s), its->rows_of(s) + its->height(s)));
    for (Index k = 0; k < its->width(s); ++k) CHECK(its->rows_of(s)[k] == its->first[s] + k);
  }
}

TEST(entries_without_a_mirror_image_are_told) {
  Entries rows = diagonal(5, 1.0);
  rows[1][3] = rows[3][1] = 1.0;
  CHECK(is_symmetric(Sparse(rows).pattern()));
  rows[0][4] = 1.0;
  CHECK(!is_symmetric(Sparse(rows).pattern()));
  rows[4][0] = 1.0;
  rows[4][2] = 1.0;
  CHECK(!is_symmetric(Sparse(rows).pattern()));
}

TEST(a_matrix_that_is_not_definite_names_vertex_and_pivot) {
  Entries rows = diagonal(9, 1.0);
  rows[5][5] = -1.0;
  for (const bool compact : {false, true}) {
    const std::string message = message_of<SolverError>([&] { factor_of(Sparse(rows), compact); });
    CHECK(message.find("vertex 5, pivot ") != std::string::npos, message);
    CHECK(message.find("of 9 unknowns") != std::string::npos, message);
  }
  for (const Sparse& matrix : {grid(9, -0.5), grid(9, 0.0), grid(40, 0.0), grid(40, -3.0)}) {
    const std::string message = message_of<SolverError>([&] { factor_of(matrix); });
    CHECK(message.find("not positive definite") != std::string::npos, message);
  }
}

TEST(a_matrix_that_is_not_finite_is_told) {
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const Row other : {40, 41}) {  // on the diagonal, and beside it
      Sparse matrix = grid(9, 0.1);
      for (const auto& [row, column] : {std::pair{Row{40}, other}, std::pair{other, Row{40}}})
        matrix.at(row, column) = value;
      const std::string message = message_of<SolverError>([&] { factor_of(matrix); });
      CHECK(message.find("vertex") != std::string::npos, message);
    }
  }
}

TEST(a_right_hand_side_that_is_not_finite_is_told) {
  const Sparse matrix = grid(7, 0.1);
  for (const bool compact : {false, true}) {
    const Factor factor = factor_of(matrix, compact);
    for (const Index n_columns : kColumns) {
      for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        std::vector<double> b(matrix.size() * n_columns, 1.0);
        b.back() = value;
        const std::string message = message_of<SolverError>([&] { factor.solve(b, b, n_columns); });
        CHECK(message.find("not finite") != std::string::npos, std::to_string(n_columns));
      }
    }
  }
}

TEST(a_factor_says_its_bytes) {
  const Sparse matrix = grid(40, 0.1);
  const Factor whole = factor_of(matrix), compact = factor_of(matrix, true);
  CHECK(compact.nbytes() * 2 == whole.nbytes());
  CHECK(whole.nbytes() <= Factor::nbytes_needed(whole.analysis(), false));
  CHECK(compact.nbytes() <= Factor::nbytes_needed(whole.analysis(), true));
}

TEST(threads_share_an_analysis_and_a_factor) {
  const Sparse matrix = grid(40, 0.1);
  const auto analysis = analysis_of(matrix);
  constexpr int kThreads = 4;
  double errors[kThreads] = {};
  std::vector<std::thread> threads;
  const Factor shared(analysis, matrix.data, false);
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      const Factor own(analysis, matrix.data, t % 2 == 1);
      for (int round = 0; round < 3; ++round) {
        for (const Index n_columns : {1, 5, 17}) {
          errors[t] = std::max(errors[t], error_of(matrix, shared, n_columns));
          errors[t] = std::max(errors[t], 1e-3 * error_of(matrix, own, n_columns));
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const double error : errors) CHECK(error < 1e-6, std::to_string(error));
}
