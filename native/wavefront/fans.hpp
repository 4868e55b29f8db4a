// One-rings of vertices, in fans of eight triangles side by side.
#pragma once

#include "wavefront/corners.hpp"

namespace geodesic {

inline constexpr int kSpokes = 8;

// Neighbours of a vertex in their order around it, the length of the edge to each, and the length
// of the edge to the next neighbour if the three are a triangle, else NaN. It is negative for a
// boundary edge, across which no update comes. The first neighbour follows the last. Unused spokes
// hold the vertex itself at an infinite length.
struct Fan {
  double to[kSpokes], edge[kSpokes];
  std::uint32_t neighbour[kSpokes];
};

// Vertex v is updated from the fans [starts[v], ends[v]); the vertices that it may update are in
// the fans [starts[v], starts[v + 1]). There is one more fan behind the last, so that prefetching
// at starts[v] is valid for a vertex without fans.
struct Fans {
  Array<Row> starts, ends;
  Array<Fan> fans;
};

Fans fans_of(const Corners& corners);

}  // namespace geodesic
