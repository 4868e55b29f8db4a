// Straightest lines over triangles: the exponential map.
//
// K. Polthier, M. Schmies, Straightest Geodesics on Polyhedral Surfaces, 1998,
// https://doi.org/10.1145/1185657.1185664
#pragma once

#include "core/array.hpp"

namespace geodesic {

// The points of each line, those of line i from begins[i] on: where it starts, where it crosses
// edges, where it ends. Each lies in a face, with a weight for each of its corners.
struct StraightLines {
  Array<Index> begins, faces;
  Array<double> weights;  // (P, 3)
  Array<double> missing;  // the rest of each length where the surface ends
};

// Lines from places in faces, (Q, 3) weights, in directions that are angles to half-edge 3 f of the
// face f, of the given lengths.
//
// `lengths` has the edge opposite each corner, `twin` is that of `twins`, coherent. A line of more
// crossings than `most` ends there.
StraightLines straight_lines(std::span<const double> lengths, std::span<const Index> twin,
                             std::span<const Index> faces, std::span<const double> weights,
                             std::span<const double> angles, std::span<const double> distances,
                             Index most);

}  // namespace geodesic
