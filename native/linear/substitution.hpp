// Solves with the panels of a factor.
#pragma once

#include "core/half.hpp"
#include "linear/analysis.hpp"

namespace geodesic {

inline constexpr int kBlock = 16;  // columns of a block, which is always computed in full

// Write x with L L' x = b, and return whether it is finite; x may be b itself.
//
// The value of vertex v is b[v * stride]; the values of a block start there.
template <class T>
bool solve_column(const Analysis& analysis, const T* panels, const double* b, double* x,
                  Index stride);
template <class T>
bool solve_block(const Analysis& analysis, const T* panels, const double* b, double* x,
                 Index stride, Index n_columns);

// The same of an analysis in pairs, for n_columns of real and imaginary parts in turn, by rows.
bool solve_pairs(const Analysis& analysis, const double* panels, std::span<const double> b,
                 std::span<double> x, Index n_columns);

}  // namespace geodesic
