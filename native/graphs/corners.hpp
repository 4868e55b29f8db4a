// The corners of a graph: two edges of a vertex whose ends are known to be how far apart.
#pragma once

#include <span>
#include <vector>

#include "core/array.hpp"

namespace geodesic {

// A graph in compressed rows, chords among its edges, and the corners at every vertex.
//
// Slot s of vertex x is an edge from x to ends[s], and back[s] the same edge in reverse. The
// corners of slot s are those of edge s and edge other[k] of the same vertex, for k from begins[s]
// to begins[s + 1], whose ends are a distance apart of which across[k] is the square.
struct GraphCorners {
  std::vector<Index> starts;
  std::vector<Row> ends;
  std::vector<double> lengths;
  std::vector<Row> back;
  std::vector<Index> begins;
  std::vector<Row> other;
  std::vector<double> across;
  std::vector<double> reaches;  // the length of the longest edge or chord of each vertex
  bool solid = false;           // whether fronts cross the triangles of three corners as well
  bool lattice = false;         // whether nearly all corners are those of rectangles
  double covered = 0;           // share of the junctions whose edges corners connect
  double growth = 0;            // vertices up to two edges away, for each neighbour
  double closed = 0;  // share of the edges that triangles surround: their third corners connect

  Index n_vertices() const { return static_cast<Index>(starts.size()) - 1; }
};

// Edges are (E, 2), each once and without loops, and lengths positive.
//
// Corners are those of triangles of the graph; of its quadrangles without diagonals, if the graph
// does not fill them otherwise, each laid out in the plane so that its area is the largest, as a
// rectangle where opposite sides are equal; and of edges of one lattice along different axes.
GraphCorners corners_of(Index n_vertices, std::span<const Index> edges,
                        std::span<const double> lengths);

}  // namespace geodesic
