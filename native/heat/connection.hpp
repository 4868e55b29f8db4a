// The connection Laplacian: that of a gradient whose coefficients are multiplied by turns.
//
// N. Sharp, Y. Soliman, K. Crane, The Vector Heat Method, ACM Transactions on Graphics 38, 2019,
// https://doi.org/10.1145/3243651
#pragma once

#include <optional>

#include "core/matrix.hpp"

namespace geodesic {

// Complex entries of G_c^H W G_c, as pairs of numbers, on a pattern with sorted rows; nothing where
// that is not symmetric or lacks the diagonal or an edge of the triangles, (E, 3). Hermitian and
// positive semidefinite, as L = -Delta is.
std::optional<Array<double>> connection_laplacian(const Pattern& pattern,
                                                  std::span<const Index> elements,
                                                  std::span<const double> frames,
                                                  std::span<const double> measure,
                                                  std::span<const double> turns);

// The turn from the frame of vertex j into that of vertex i for each entry (i, j) of a pattern, as
// pairs of numbers: the sum of those through the elements (E, m) that have both, 0 where none has.
Array<double> edge_turns(const Pattern& pattern, std::span<const Index> elements, int size,
                         std::span<const double> turns);

// The real matrix of twice as many unknowns, real and imaginary part of a vertex side by side, of
// diag(diagonal) + diag(scale) A for a complex A.
Matrix real_form(const Pattern& pattern, std::span<const double> entries,
                 std::span<const double> scale, std::span<const double> diagonal);

// Lengths of complex numbers in pairs, and the same numbers at length 1; both are 0 for zeros.
struct Polar {
  Array<double> sizes, directions;
};
Polar polar_form(std::span<const double> pairs);

}  // namespace geodesic
