// The shortest loop that does not shrink to a point, through a vertex or anywhere.
//
// J. Erickson, S. Har-Peled, Optimally cutting a surface into a disk, Discrete & Computational
// Geometry 31, 2004, https://doi.org/10.1007/s00454-003-2948-z: the shortest loop of edges through
// a vertex consists of two shortest paths and an edge, and every loop meets a cut of the surface.
#pragma once

#include "paths/chains.hpp"

namespace geodesic {

// A loop, pulled taut; without points where every loop shrinks.
struct ShortestLoop {
  Line line;
  // Why there are no classes of loops, or kNone: the ends of an edge of more than two faces, or a
  // vertex alone where short holes meet.
  Index unclear[2] = {kNone, kNone};
};

// Held at a vertex. Holes whose boundary is shorter than `min_hole` count as filled: a loop around
// nothing else shrinks.
ShortestLoop shortest_loop_through(const Surface& surface, Index vertex, double min_hole);

ShortestLoop shortest_loop_anywhere(const Surface& surface, double min_hole);

}  // namespace geodesic
