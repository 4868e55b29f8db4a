// A Cholesky factor that solves.
#pragma once

#include <memory>

#include "core/half.hpp"
#include "linear/analysis.hpp"

namespace geodesic {

// The panels of a factor, of whole numbers or of their upper halves, which pairs never are. Solving
// changes nothing in it, so that several threads may.
class Factor {
 public:
  // Throws SolverError where the matrix is not positive definite to working precision, or has
  // entries that are not finite.
  Factor(std::shared_ptr<const Analysis> analysis, std::span<const double> data, bool compact);

  // Write x with A x = b, for n_columns of them by rows; x may be b itself. Throws SolverError
  // where it is not finite.
  void solve(std::span<const double> b, std::span<double> x, Index n_columns) const;

  const Analysis& analysis() const { return *analysis_; }
  const Array<double>& numbers() const { return numbers_; }
  const Array<Half>& halves() const { return halves_; }
  Index nbytes() const;
  // The bytes that factorising takes.
  static Index nbytes_needed(const Analysis& analysis, bool compact);

 private:
  std::shared_ptr<const Analysis> analysis_;
  Array<double> numbers_;  // one of the two is empty
  Array<Half> halves_;
};

}  // namespace geodesic
