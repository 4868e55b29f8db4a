// The stiffness L = G' W G of linear functions on triangles, L = -Delta positive semidefinite.
#pragma once

#include "core/matrix.hpp"
#include "triangles/half_edges.hpp"

namespace geodesic {

struct EdgeSums {
  Matrix edges;               // the strict upper triangle of L, in no order within its rows
  Array<double> lumped_mass;  // a third of the measure of the elements around each vertex
  Array<bool> boundary;       // vertices of edges that one element has
};

EdgeSums edge_sums(std::span<const Index> faces, const HalfEdges& half_edges,
                   std::span<const double> frames, std::span<const double> measure);
// A stiffness from what lies right of its diagonal: symmetric to the bit, L 1 = 0.
Matrix mirrored(const MatrixView& edges);
// The mean length of the edges of a pattern.
double mean_edge_length(std::span<const double> vertices, const Pattern& pattern);

}  // namespace geodesic
