// Steepest descent of a piecewise linear function over triangles.
#pragma once

#include "paths/surface.hpp"

namespace geodesic {

// Faces, each sharing an edge with the next.
using Strip = std::vector<Index>;

// The vertices on a path, and the faces passed between each and the next.
struct Route {
  std::vector<Index> stops;
  std::vector<Strip> strips;
};

// The path down from a vertex to one that has no lower neighbour.
Route descend(const Surface& surface, std::span<const double> height, Index start);

// The shortest path along edges from a vertex to the nearest of several; without a stop if none can
// be reached.
Route along_edges(const Surface& surface, Index start, std::span<const bool> is_end);

}  // namespace geodesic
