// The triangles around vertices, each as one of its corners sees it.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// The other two vertices of a triangle, how far they are, and how far apart: less than zero where
// the surface ends in the edge between them.
//
// Every length is there twice, so that a vertex finds all of its triangles in one piece of memory.
struct Corner {
  std::uint32_t a, b;
  double to_a, to_b, edge;
};

// Vertex v has the corners around[starts[v], starts[v + 1]), but where stars overlap its own star
// first, which ends before ends[v].
struct Corners {
  Array<Row> starts, ends;
  Array<Corner> around;
  Index n_vertices() const { return ends.size(); }
};

// The corners of triangles, (E, 3), with inverse frames, of fewer than 2^31 corners. An element
// (i, j, j) is a segment. If they are `stars`, a triangle is part of that of its first vertex only.
//
// Corners go round a vertex as far as they hang together (a front then finds what it has passed on
// one side and the rest on the other, which takes a fifth less time than any order), and are
// otherwise in the order of the elements.
Corners gather_corners(std::span<const Index> elements, std::span<const double> frames, bool stars,
                       Index n_vertices);

// Make the edges less than zero that one triangle alone has, both of whose ends are at the
// boundary.
void close_rims(Corners& corners, std::span<const bool> boundary);

// Let vertices listen to triangles that both others have in their stars, but they have not.
//
// The star of a vertex whose normal is off has gaps, which those of its neighbours fill. What a
// single neighbour has in its star is as often a bridge.
void tell_missed(Corners& corners);

}  // namespace geodesic
