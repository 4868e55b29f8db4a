// Exact distances on a polyhedron: windows, propagated over its faces.
//
// A window is an interval of an edge that is seen straight from a source, or from a vertex about
// which paths turn, through a sequence of faces that are unfolded into one plane. J. Chen, Y. Han,
// Shortest paths on a polyhedron, 1990, https://doi.org/10.1145/98524.98601, with the order and the
// filter of S.-Q. Xin, G.-J. Wang, Improving Chen and Han's algorithm on the discrete geodesic
// problem, 2009, https://doi.org/10.1145/1559755.1559761.
#pragma once

#include "windows/polyhedron.hpp"

namespace geodesic {

// Points as convex combinations of vertices of one face, [begins[p], begins[p + 1]): one vertex,
// two or three; how far each vertex is from its point, and the distance that each point starts
// with.
struct PointsOnFaces {
  std::span<const Index> begins, vertices;
  std::span<const double> shares, distances, starts;
};

// Write the distance of every vertex from the nearest point, infinite where no face connects.
// Return false, with distances that are too long, after more than `most` windows.
bool exact_distances(const Polyhedron& shape, const PointsOnFaces& points, Index most,
                     std::span<double> distances);

}  // namespace geodesic
