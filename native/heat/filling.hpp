// Enforce the maximum principle where heat underflowed.
#pragma once

#include "core/matrix.hpp"

namespace geodesic {

// Fill entries of u, which are 0, from neighbours with a value, ring by ring.
//
// u_i becomes sum |a_ij| u_j / (|sum a_ij| + sum |a_ij|) over the neighbours j with a value. `rows`
// are the entries to fill, and come out in another order.
void fill(const MatrixView& matrix, std::span<double> solution, Index stride, std::span<Row> rows);

}  // namespace geodesic
