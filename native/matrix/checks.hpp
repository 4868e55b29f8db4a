// Checks of a stiffness: components, soundness, signs, diagonal.
#pragma once

#include "core/matrix.hpp"

namespace geodesic {

// The connected component of every vertex, numbered by their first vertices. Entries on one side of
// the diagonal are enough.
Array<Index> components(const Pattern& edges);
// Of edges, (E, 2).
Array<Index> components(std::span<const Index> edges, Index n_vertices);
// True if a stiffness is finite, symmetric, kills constants and has no negative diagonal.
bool is_sound(const MatrixView& stiffness);
// The share of entries with the wrong sign around each vertex, over so many rings.
Array<double> obtuse_excess(const MatrixView& stiffness, std::span<const double> mass, Index rings);

// Where the diagonal entries of a pattern are, row by row; of rows that have one.
Array<Index> diagonal_places(const Pattern& pattern);
// The entries of diag(diagonal) + diag(scales) A on the pattern of A, whose every row has a
// diagonal entry at its place; one scale of all rows, or one of each.
Array<double> plus_diagonal(const MatrixView& matrix, std::span<const Index> places,
                            std::span<const double> scales, std::span<const double> diagonal);
// The sum of the entries of each row.
Array<double> row_sums(const MatrixView& matrix);

}  // namespace geodesic
