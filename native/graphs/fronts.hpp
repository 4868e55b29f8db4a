// Distances on a graph by fronts that cross its corners.
#pragma once

#include <span>

#include "core/near.hpp"
#include "graphs/corners.hpp"

namespace geodesic {

// The distances of all vertices from each of several sets of them, (K, n) in `distances`; infinite
// where no edge leads. Set k has vertices[begins[k]] to vertices[begins[k + 1]], each of which
// starts with its own distance, of any sign.
//
// Distances become final from the nearest to the farthest, as in Dijkstra's algorithm. One that is
// final offers its neighbours the path along the edge, which therefore bounds them. At every
// corner of which two ends are final, and at three corners at right angles or so, it also offers
// the straight line from the point at the distances of the ends, if that line passes between them.
void cross_corners(const GraphCorners& corners, std::span<const Index> begins,
                   std::span<const Index> vertices, std::span<const double> starts,
                   std::span<double> distances, int n_threads);

// The same, to the bit, of the vertices up to limits[k] from set k alone.
//
// Only the vertices around are visited, and a few more: a vertex may still be reached across a
// corner from two that are farther, but by less than their edges to it, and its path along these is
// known. So it has to become final if that path is within the limit and twice its longest edge.
NearRows cross_corners_near(const GraphCorners& corners, std::span<const Index> begins,
                            std::span<const Index> vertices, std::span<const double> starts,
                            std::span<const double> limits, int n_threads);

}  // namespace geodesic
