// The triangles around vertices, eight of them side by side.
#pragma once

#include "wavefront/corners.hpp"

namespace geodesic {

inline constexpr int kSpokes = 8;

// Neighbours of a vertex in their order about it, how far each is, and how far from it the next one
// is, where the three make a triangle; otherwise no number. It is less than zero where the surface
// ends between them, as nothing comes across from there. The first follows on the last. Where no
// neighbour is left there is the vertex itself, infinitely far.
struct Fan {
  double to[kSpokes], edge[kSpokes];
  std::uint32_t neighbour[kSpokes];
};

// Vertex v listens to the fans [starts[v], ends[v]), and those who may listen to it are in the fans
// [starts[v], starts[v + 1]). Behind the last fan is one more, so that whoever looks ahead finds
// one at starts[v] where a vertex has none.
struct Fans {
  Array<Row> starts, ends;
  Array<Fan> fans;
};

Fans fans_of(const Corners& corners);

}  // namespace geodesic
