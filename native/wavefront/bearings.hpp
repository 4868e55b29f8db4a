// The directions in which a vertex sees the corners of its triangles.
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
// `triangle_turns` makes them of bisectors: its inverse. How angles are scaled about a vertex is
// told by neighbours, which `twin` has for each half-edge, or -1; without any by 1.
Directions directions_of(std::span<const Index> elements, std::span<const double> lengths,
                         std::span<const double> turns, std::span<const bool> mirrored,
                         std::span<const Index> twin);

struct DirectionsView {
  std::span<const double> angles, scales;
};

// In the order of `corners`, which were gathered from such elements, (E, 3), of edges `lengths`
// opposite the corners. In their planes the elements have such edges as `flat` tells.
Array<Bearing> bearings_of(const Corners& corners, std::span<const Index> elements,
                           std::span<const double> lengths, std::span<const double> flat,
                           const DirectionsView& directions);

}  // namespace geodesic
