// Point clouds and the neighbours of their points.
#pragma once

#include "triangles/vector3.hpp"

namespace geodesic {

struct Cloud {
  std::span<const double> points, normals;  // (N, 3); normals have length 1
  std::span<const Index> neighbours;        // (N, width), nearest first; or of some points only
  Index width;

  Index size() const { return count(points) / 3; }
  Index rows() const { return width == 0 ? 0 : count(neighbours) / width; }
  std::span<const Index> around(Index row) const {
    return neighbours.subspan(static_cast<std::size_t>(row * width),
                              static_cast<std::size_t>(width));
  }
};

// Points that a thread takes at a time.
inline constexpr Index kPointsAtOnce = 512;

// Throw std::invalid_argument if a neighbour is not a point of the cloud.
void check_neighbours(const Cloud& cloud, int n_threads);

}  // namespace geodesic
