// Strips of triangles unfolded into the plane, and the shortest path there by the funnel algorithm.
#pragma once

#include "paths/descent.hpp"

namespace geodesic {

using Position = std::ptrdiff_t;  // in a strip

// The cross product, positive where q is on the left of p, or 0 where both are on a line except for
// rounding.
double side(Planar p, Planar q);

// An inner edge of a strip, and where it lies in the plane.
struct Portal {
  Index left, right;
  Planar at_left, at_right;
};

struct Unfolded {
  std::vector<Portal> portals;
  Planar first, last;
};

// A strip of faces in the plane, from a corner of the first to one of the last.
Unfolded unfolded(const Surface& surface, const Strip& strip, Index start, Index end);

// A corner of a path in the plane: at an end of which portal, on which side.
struct Knot {
  Position portal;
  bool right;
  Planar place;
};

// The corners of the shortest path, with its start and its end.
std::vector<Knot> funnel(const Unfolded& flat);

double length_of(const std::vector<Knot>& knots);

// A vertex that a path bends around: the edge of the strip, by number, at which it does, and the
// angle on the strip's side.
struct Bend {
  Index vertex, portal;
  double angle;
};

std::vector<Bend> bends_of(const Unfolded& flat, const std::vector<Knot>& knots);

}  // namespace geodesic
