// The triangles around each vertex, as corners.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// The other two vertices of a triangle, the lengths of the edges to them, and the length of the
// edge between them, which is negative for a boundary edge.
//
// Every length is stored twice, so that the triangles of a vertex are contiguous in memory.
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
// Corners are sorted around a vertex as far as they are connected; this takes a fifth less time in
// sweeps than any order. Otherwise they are in the order of the elements.
Corners gather_corners(std::span<const Index> elements, std::span<const double> frames, bool stars,
                       Index n_vertices);

// Make the edges less than zero that one triangle alone has, both of whose ends are at the
// boundary. Where two triangles may disagree about the length of their edge, as where the cost of
// a surface jumps, triangles share an edge if its ends are the same.
void close_rims(Corners& corners, std::span<const bool> boundary, bool edges_agree = true);

// Add triangles to the stars of vertices that lack them although both other vertices have them.
//
// The star of a vertex with a wrong normal has gaps, which the stars of its neighbours fill. A
// triangle in the star of a single neighbour is as often a bridge.
void add_missed_triangles(Corners& corners);

}  // namespace geodesic
