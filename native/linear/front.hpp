// Partial Cholesky factorisation of a frontal matrix: it factorises the pivot block and updates the
// trailing block.
//
//     P = [ P1 ]  ->  [ L1        ]        L1 L1' = P1,
//         [ P2 ]      [ P2 L1^-T  ]        U = -(P2 L1^-T) (P2 L1^-T)'.
//
// Products of thin matrices are most of a factorisation, and three quarters of the matrices have
// fewer rows than the kernels of a BLAS are made for. Tiles of four columns stay in registers; rows
// at an end are taken under a mask, and nothing is copied or padded before. Columns come in fours,
// those in chunks: within a chunk four columns are brought up to date when their turn comes, and
// behind it all that follow at once.
#pragma once

#include "core/array.hpp"

namespace geodesic::front {

// The size of the workspace, in numbers, that `eliminate` needs for fronts of up to `height` rows.
Index packed_size(Index tallest);

// Eliminate the `width` columns of a front in place; return the first with a pivot <= 0, or kNone.
//
// They become those of L, except that the diagonal becomes the inverse of L's. `update` receives
// the lower triangle of U, square and of `height - width` rows; `workspace` has `packed_size`
// numbers.
//
// `in_pairs` the front is one of complex numbers in their real form: only its even columns count,
// and only those of `update` are written. The odd columns of the panel are spoilt.
Index eliminate(double* panel, double* update, Index height, Index width, bool in_pairs,
                double* workspace);

}  // namespace geodesic::front
