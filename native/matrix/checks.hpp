// What a stiffness is like: its parts, its soundness, its signs.
#pragma once

#include "core/matrix.hpp"

namespace geodesic {

// The connected component of every vertex, numbered by their first vertices. Entries on one side of
// the diagonal are enough.
Array<Index> components(const Pattern& edges);
// Of edges, (E, 2).
Array<Index> components(std::span<const Index> edges, Index n_vertices);
// Whether a stiffness is finite, symmetric, kills constants and has no negative diagonal.
bool is_sound(const MatrixView& stiffness);
// The share of entries with the wrong sign around each vertex, over so many rings.
Array<double> obtuse_excess(const MatrixView& stiffness, std::span<const double> mass, Index rings);

}  // namespace geodesic
