#include "linear/factor.hpp"

#include <cmath>
#include <string>

#include "core/errors.hpp"
#include "linear/front.hpp"
#include "linear/numeric.hpp"
#include "linear/substitution.hpp"

namespace geodesic {
namespace {

constexpr Index kMaxColumnsOneByOne = 2;  // columns up to which one by one is quicker than a block

// Share of a diagonal entry, times the root of the number of unknowns, below which what elimination
// leaves of it is rounding.
//
// Rounding errors add up as the steps of a random walk do. Of Laplacians of grids, meshes, paths
// and neighbour graphs of 3,000 to 100,000 vertices, which should leave nothing, a fifth of this
// was left at the most; with one vertex held 1e-5 and more.
constexpr double kMinRelativePivot = 7e-15;

void check_definite(const Analysis& analysis, const Pivots& pivots) {
  const Index n = analysis.n_vertices();
  Index column = pivots.failed;
  const double least = kMinRelativePivot * std::sqrt(static_cast<double>(n));
  for (Index j = 0; j < n && column == kNone; ++j)
    if (!(pivots.left[j] > least)) column = j;  // nor is NaN
  if (column == kNone) return;
  throw SolverError("the matrix of " + std::to_string(n) +
                    " unknowns is not positive definite to working precision: elimination stops "
                    "at vertex " +
                    std::to_string(analysis.order[column]) + ", pivot " +
                    std::to_string(column + 1) + " of " + std::to_string(n));
}

}  // namespace

Factor::Factor(std::shared_ptr<const Analysis> analysis, std::span<const double> data, bool compact)
    : analysis_(std::move(analysis)) {
  const Index size = analysis_->n_stored() + kPaddingRows;
  if (compact && !analysis_->in_pairs) {
    halves_ = Array<Half>(size);
    check_definite(*analysis_, factorize<Half>(*analysis_, data, halves_));
  } else {
    numbers_ = Array<double>(size);
    check_definite(*analysis_, factorize<double>(*analysis_, data, numbers_));
  }
}

void Factor::solve(std::span<const double> b, std::span<double> x, Index n_columns) const {
  const auto with = [&](const auto* panels) {
    const Analysis& its = *analysis_;
    if (its.in_pairs) return solve_pairs(its, numbers_.data(), b, x, n_columns);
    const Index alone = n_columns <= kMaxColumnsOneByOne ? n_columns : 0;
    bool finite = true;
    for (Index k = 0; k < alone; ++k)
      finite &= solve_column(its, panels, b.data() + k, x.data() + k, n_columns);
    for (Index k = alone; k < n_columns; k += kBlock)
      finite &= solve_block(its, panels, b.data() + k, x.data() + k, n_columns,
                            std::min<Index>(kBlock, n_columns - k));
    return finite;
  };
  if (!(halves_.empty() ? with(numbers_.data()) : with(halves_.data())))
    throw SolverError(
        "the solution is not finite: the right-hand side is not, or they are too large");
}

Index Factor::nbytes() const {
  return numbers_.size() * Index{sizeof(double)} + halves_.size() * Index{sizeof(Half)};
}

Index Factor::nbytes_needed(const Analysis& its, bool compact) {
  const Index stored = its.n_stored() + kPaddingRows;
  compact = compact && !its.in_pairs;
  const Index front = compact || its.in_pairs ? its.largest : 0;
  const Index numbers = its.stack + front::packed_size(its.tallest) + front;
  return numbers * Index{sizeof(double)} + stored * Index(compact ? sizeof(Half) : sizeof(double));
}

}  // namespace geodesic
