// Geodesics from chains of edges: pulled taut on the side of places on which the chain passes them.
#pragma once

#include "paths/strips.hpp"

namespace geodesic {

using Chain = std::vector<Index>;  // vertices, an edge from each to the next

// The points of a path or of a closed path, and its length.
struct Line {
  std::vector<Crossing> points;
  double length = 0;
};

// The geodesic from the first vertex of a chain to its last that the chain is pulled to, held where
// the chain is or led beside its vertices.
Line pulled_along(const Surface& surface, const Chain& chain, bool is_held = true);

// The closed geodesic that a chain, closed from its last vertex to its first, is pulled to; without
// points where that shrinks to a point, or to less than `min_length`.
Line pulled_around(const Surface& surface, Chain chain, double min_length);

// Where a path runs through stops, and how the stops are taken.
struct Course {
  std::vector<Index> stops;  // vertices; none is next to itself
  bool is_closed = false;    // from the last to the first
  bool is_held = false;      // through the stops, rather than pulled away from them
  double min_length = 0;     // of a closed path that is not held: a shorter one is a point
};

// The points of a path, none where a closed one shrinks to a point, and the stop that no triangle
// connects with the one before it, or kNoStop.
inline constexpr Index kNoStop = -1;
struct Drawn {
  std::vector<Crossing> points;
  Index unreached = kNoStop;
};

// Stops are joined by the shortest paths along edges; those make the strip of faces, on the side of
// the lesser angle at each vertex, that the geodesic starts from.
Drawn geodesic_through(const Surface& surface, const Course& course);

}  // namespace geodesic
