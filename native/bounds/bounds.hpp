// What no distance along a surface can be: less than the straight line, more than along the edges.
#pragma once

#include "bounds/places.hpp"

namespace geodesic {

// Vertices, (N, 3), and the triangles between them, (E, 3). Vertices without a triangle may be NaN.
struct Surface {
  std::span<const double> vertices;
  std::span<const Index> triangles;
};

// Raise finite distances to what the straight line from the nearest place reads.
void raise_to_straight_line(std::span<const double> vertices, const Starts& starts,
                            std::span<double> distances);

// Lower distances to the shortest way along edges from any vertex. What is infinite stays.
//
// E. W. Dijkstra, A note on two problems in connexion with graphs, 1959,
// https://doi.org/10.1007/BF01386390, begun at the edges across which distances differ by more than
// their length; seldom are there any.
void lower_to_edges(const Surface& surface, std::span<double> distances);

}  // namespace geodesic
