#include "matrix/checks.hpp"

namespace geodesic {

Array<Index> diagonal_places(const Pattern& pattern) {
  Array<Index> places(pattern.size());
  Index count = 0;
  for (Index row = 0; row < pattern.size(); ++row) {
    for (Row entry = pattern.indptr[row]; entry < pattern.indptr[row + 1]; ++entry)
      if (pattern.indices[entry] == row) places[count++] = entry;
  }
  places.shorten(count);
  return places;
}

// In two passes: a product and a sum in one expression would be rounded once, and only where the
// processor can.
Array<double> plus_diagonal(const MatrixView& matrix, std::span<const Index> places,
                            std::span<const double> scales, std::span<const double> diagonal) {
  Array<double> data(count(matrix.data));
  if (scales.size() == 1) {
    for (Index entry = 0; entry < data.size(); ++entry)
      data[entry] = matrix.data[entry] * scales[0];
  } else {
    for (Index row = 0; row < matrix.size(); ++row)
      for (Row entry = matrix.indptr[row]; entry < matrix.indptr[row + 1]; ++entry)
        data[entry] = matrix.data[entry] * scales[row];
  }
  for (Index row = 0; row < matrix.size(); ++row) data[places[row]] += diagonal[row];
  return data;
}

Array<double> row_sums(const MatrixView& matrix) {
  Array<double> sums(matrix.size());
  for (Index row = 0; row < matrix.size(); ++row) {
    double sum = 0;
    for (Row entry = matrix.indptr[row]; entry < matrix.indptr[row + 1]; ++entry)
      sum += matrix.data[entry];
    sums[row] = sum;
  }
  return sums;
}

}  // namespace geodesic
