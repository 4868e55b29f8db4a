// The numeric half of a factorisation.
#pragma once

#include "core/half.hpp"
#include "linear/analysis.hpp"

namespace geodesic {

struct Pivots {
  Index failed = kNone;  // the first column with a pivot <= 0
  Array<double> left;    // the share of each diagonal entry that elimination leaves
};

// Write the panels of L with A = L L', of whole numbers or of their upper halves.
//
// The panels hold the inverse of the diagonal of L, and of pairs of columns the first. `panels` has
// n_stored() + kPaddingRows numbers; the last ones become zero. `data` has the entries of A on the
// pattern that was analysed.
template <class T>
Pivots factorize(const Analysis& analysis, std::span<const double> data, std::span<T> panels);

}  // namespace geodesic
