// The half-edges of triangles, sorted by the vertices at their ends.
//
// Half-edge 3 f + c of face f is opposite its corner c. It runs from corner c + 1 to
// corner c + 2. Those of one edge meet at its vertex of lower index: there stiffness adds them up,
// and edge flips find twins.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// A half-edge as the end of lower index has it: the other end and the number of the half-edge, or
// ~number where it runs down from there.
struct HalfEdge {
  Row head, half;
};
inline Row number(Row signed_half) { return signed_half < 0 ? ~signed_half : signed_half; }

// The half-edges of vertex v are halves[starts[v], starts[v + 1]), in the order of the triangles.
struct HalfEdges {
  Array<Row> starts;
  Array<HalfEdge> halves;
  Index n_vertices() const { return starts.size() - 1; }
};

// There must be fewer than 2^31 half-edges.
HalfEdges sorted_half_edges(std::span<const Index> faces, Index n_vertices);

// The twin of each half-edge or -1, as where its edge has not two of them, and whether twins run
// against each other everywhere.
struct Twins {
  Array<Index> of;
  bool coherent = true;
};
Twins twins(const HalfEdges& half_edges);

}  // namespace geodesic
