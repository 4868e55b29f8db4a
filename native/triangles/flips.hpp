// Edge flips to an intrinsic Delaunay triangulation.
//
// M. Fisher, B. Springborn, P. Schroeder, A. I. Bobenko, An algorithm for the construction of
// intrinsic Delaunay triangulations with applications to digital geometry processing, Computing 81,
// 2007, https://doi.org/10.1007/s00607-007-0249-8
#pragma once

#include "core/array.hpp"

namespace geodesic {

// Flip edges in place until none has opposite angles of more than pi together; return how many.
//
// `lengths` has the edge opposite each corner, `twin` is that of `twins`, coherent. Edges of a held
// vertex stay. `angles` and `scales` of half-edges, as `polar_directions` has them, are carried
// along where they are given.
Index flip_edges(std::span<Index> faces, std::span<double> lengths, std::span<Index> twin,
                 std::span<const bool> held, std::span<double> angles = {},
                 std::span<double> scales = {});

}  // namespace geodesic
