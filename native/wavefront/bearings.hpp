// The directions of the corners of triangles from a vertex.
#pragma once

#include "triangles/frames.hpp"
#include "wavefront/corners.hpp"

namespace geodesic {

// Of a corner: the direction of its first other vertex in the frame of the vertex, and how far on
// the second one is; in radians of the frame, and less than zero where the triangle is turned over
// in it.
struct Bearing {
  double direction, turn;
};

// The directions of half-edges from the turns of the corners of elements, (E, 3), complex, as
// `triangle_turns` makes them of bisectors: its inverse. The scale of angles about a vertex
// follows from neighbours, which `twin` has for each half-edge, or -1; without neighbours it is 1.
Directions directions_of(std::span<const Index> elements, std::span<const double> lengths,
                         std::span<const double> turns, std::span<const bool> mirrored,
                         std::span<const Index> twin);

struct DirectionsView {
  std::span<const double> angles, scales;
};

// In the order of `corners`, which were gathered from such elements, (E, 3), of edges `lengths`
// opposite the corners. `flat` has the edges of the elements in their planes.
Array<Bearing> bearings_of(const Corners& corners, std::span<const Index> elements,
                           std::span<const double> lengths, std::span<const double> flat,
                           const DirectionsView& directions);

}  // namespace geodesic
