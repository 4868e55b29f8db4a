// The shortest path through a strip of triangles, and through the strips beside it.
//
// Unfolded into the plane, the shortest path through a strip from one corner to another is found by
// the funnel algorithm. Where that bends around a vertex and the surface on the other side of it
// spans less than pi, the path around the other side is shorter (S.-Q. Xin, G.-J. Wang, Efficiently
// determining a locally exact shortest path on polyhedral surfaces, Computer-Aided Design 39, 2007,
// https://doi.org/10.1016/j.cad.2007.08.001). When no bend is left of that kind the path is a
// geodesic.
#pragma once

#include "paths/unfolding.hpp"

namespace geodesic {

// A point of a path: of a face, on its edge from `left` to `right`, with this share of the latter.
struct Crossing {
  Index face, left, right;
  double share;
};

// The shortest path through a strip.
struct Path {
  Index start, end;
  Strip strip;
  double length;
  std::vector<Bend> bends;
};

// The shortest path through a strip from a corner of the first face to one of the last.
Path straightened(const Surface& surface, const Strip& strip, Index start, Index end);

// The path from a corner of the first face to one of the last, made a geodesic.
Path shortest_path(const Surface& surface, const Strip& strip, Index start, Index end);

// A shorter geodesic, if there is one on the other side of a pointed vertex; else the same. A
// geodesic passes a vertex of less than 2 pi on one side or on the other, and neither path can be
// pulled over it.
Path beside_cones(const Surface& surface, Path path);

// The same, looked for on the other side of each vertex beside the strip, and of all on its left or
// on its right: where the surface bulges, several geodesics pass a place on one side, and edge
// flips end in any of them. Of 320 paths via a vertex on four meshes none is longer than by flips,
// and 142 are shorter; of the vertices that a path bends around and the pointed ones alone, 4 and
// 124.
Path shorter_beside(const Surface& surface, Path path);

// The points of a path: its start, where it crosses each edge, its end.
std::vector<Crossing> crossings(const Surface& surface, const Path& path);

// The length of the line through points in space. Through faces without area it is longer than what
// is unfolded.
double length_of(const Surface& surface, std::span<const Crossing> points);

}  // namespace geodesic
