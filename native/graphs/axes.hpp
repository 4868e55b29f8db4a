// Which edges of a lattice run along the same axis.
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

// The axis of every edge, so that edges of one lattice with different ones are at right angles.
//
// Opposite sides of rectangles are parallel, neighbouring ones at right angles. `frames` are three
// edges of a vertex each that are mutually at right angles: where a lattice has one, an edge that
// is at right angles to two axes runs along the third. Two numbers from 3k to 3k + 2 are two axes
// of lattice k; -1 is an edge of which rectangles do not tell.
std::vector<Row> axes_of_edges(Row n_edges, std::span<const Rectangle> rectangles,
                               std::span<const std::array<Row, 3>> frames);

}  // namespace geodesic
