// Sparse matrices in compressed rows.
//
// A stiffness has sorted columns, a diagonal entry in every row, and an entry for every edge, be
// its weight zero.
#pragma once

#include <span>

#include "array.hpp"

namespace geodesic {

// Where the entries of a matrix are: row i has the columns indices[indptr[i], indptr[i + 1]).
struct Pattern {
  std::span<const Row> indptr, indices;
  Index size() const { return count(indptr) - 1; }
};

// A pattern with the values of its entries.
struct MatrixView : Pattern {
  std::span<const double> data;
};

struct Matrix {
  Array<Row> indptr, indices;
  Array<double> data;
};

}  // namespace geodesic
