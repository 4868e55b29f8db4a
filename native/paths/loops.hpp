// The shortest closed path through a ring of triangles, and through the rings beside it.
//
// A ring is a strip whose last face shares an edge with its first. Through one of its vertices the
// shortest closed path is that through a strip. Unfolded time and again, the ring lies in a plane
// of its own whose distances are convex (a space of no positive curvature); how far a point is from
// its image a turn later is a convex function then, so that the shortest path over several turns
// leads to points where that is less, and to the closed geodesic after a few steps. At its bends
// it is led around the other side, as with strips (paths/turns.hpp).
#pragma once

#include "paths/strips.hpp"

namespace geodesic {

// The shortest closed path through a ring; without faces where it shrinks to a point.
struct Loop {
  Strip ring;
  Index base = 0;  // a vertex that it passes, between the last face and the first
  double length = 0;
  std::vector<Bend> bends;
};

// A ring without the same face twice in a row, and without there-and-back.
Strip ring_without_returns(const Strip& ring);

// The closed path through a ring, made a geodesic; one shorter than `min_length` counts as a point.
Loop shortest_loop(const Surface& surface, const Strip& ring, double min_length);

// A shorter closed geodesic, if one is found beside this one; else the same. Where the surface
// bulges there are several in one class. It is looked for from the rings on the left and on the
// right, and on the other side of each vertex beside this one.
Loop shorter_beside(const Surface& surface, Loop loop, double min_length);

// The points of a closed path: its base, where it crosses each edge, its base again.
std::vector<Crossing> crossings(const Surface& surface, const Loop& loop);

}  // namespace geodesic
