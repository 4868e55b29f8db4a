// Vertices in sight of places inside triangles or on edges: those that a straight line reaches.
//
// Fronts come to a vertex across an edge whose ends they have reached before. From a place just
// behind an edge the vertex opposite it may be nearer than both ends, and flipped edges may hide a
// place from the corners of its own triangle. Fronts begin at all that is in sight there.
#pragma once

#include <vector>

#include "core/array.hpp"

namespace geodesic {

// Place p lies between the vertices [begins[p], begins[p + 1]), two of an edge or three of a
// triangle, at these distances from them.
struct Places {
  std::span<const Index> begins, vertices;
  std::span<const double> distances;
};

// Triangles, (E, 3), with their inverse frames. Of `stars`, which overlap, each belongs to its
// first vertex.
struct Unfolded {
  std::span<const Index> elements;
  std::span<const double> frames;
  bool stars;
};

// Vertices besides those around the places, and where they lie in a plane about each place: the
// vertex around it that is farthest lies on the x axis, and the next one at y > 0.
struct Sight {
  std::vector<Index> places, vertices;
  std::vector<double> x, y;
};

// What is in sight of the places on edges, of those with a `hidden` vertex around them, and of
// those that are nearer to a vertex than both ends of an edge between. From other places fronts
// come to everything from the corners of the triangle.
Sight in_sight(const Places& places, const Unfolded& triangles, std::span<const bool> hidden);

}  // namespace geodesic
