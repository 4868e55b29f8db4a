// The axes along which edges of a lattice run.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/array.hpp"

namespace geodesic {

// Two neighbouring sides of a rectangle of the graph, and the sides opposite to them.
struct Rectangle {
  Row one, other, opposite_one, opposite_other;
};

// A graph as the search for axes needs it: edges by their numbers, around vertices in compressed
// rows.
struct EdgesAround {
  std::span<const Index> ends;  // two of each edge
  std::span<const double> lengths;
  std::span<const Index> starts;  // of the edges around each vertex
  std::span<const Row> edges;     // around the first vertex, the second, ...
};

// The axis of every edge, so that edges of one lattice with different ones are at right angles.
//
// Opposite sides of rectangles are parallel, neighbouring ones at right angles. `frames` are three
// edges of a vertex each that are mutually at right angles. From a frame on, an edge runs along the
// third axis where it is known not to run along two: it is at right angles to them, there are two
// such edges at one of its ends already, or its length is another and there are three at most.
// Two numbers from 3k to 3k + 2 are two axes of lattice k; -1 is an edge of which none is known.
std::vector<Row> axes_of_edges(const EdgesAround& graph, std::span<const Rectangle> rectangles,
                               std::span<const std::array<Row, 3>> frames);

}  // namespace geodesic
