// Characteristics of swept fronts: their paths, and the data carried along these.
//
// After sweeps each vertex has its distance and the curvature of the front. These determine the
// edge through which the front came to a vertex, the place where it crossed that edge, and its
// direction of arrival. From vertex to vertex such a path carries the data of its source:
// - an angle: the direction in which the shortest geodesic leaves a point, which is constant along
//   it, so that angle and distance are the logarithmic map; of a curve the place on it;
// - the spread of geodesics, how far those are apart at the vertex that leave a unit of angle
//   apart: a Jacobi field, which weights angles along an edge;
// - parallel transport along it: by how much a vector from the source turns, in the frames of both
//   vertices. It depends on edges alone, so that distances that are off where fronts meet do no
//   harm;
// - the number of the source.
#pragma once

#include "wavefront/bearings.hpp"

namespace geodesic {

// Results of the sweeps of one set of sources at vertices.
struct SweptFronts {
  std::span<const double> distances, kappas;
};

// Vertices at and around sources, as they were given to the sweeps with their distances. The angle
// of each, the spread, the direction of arrival and the number of its source count unless the
// sweeps have found a shorter path to it. About a vertex of distance zero itself all directions are
// known.
struct Seeds {
  std::span<const Index> vertices;
  std::span<const double> distances, angles, spreads, arrivals;
  std::span<const Row> labels;
};

// The numbers that angles are counted by.
struct Circle {
  double period;    // angles that differ by it are the same; infinite for places along a line
  bool clockwise;   // true if angles fall from a to b for all corners, seen from a front
  bool directions;  // true for directions at points
};

// The data carried to vertices: NaN, and -1 as label, at vertices without a connection.
//
// The front came to a vertex between vertices `a` and `b`, of which the second has `share` of the
// angle that the front spans at its centre; from `a` alone where both are the same, and
// sources have neither.
struct Carried {
  Array<double> angles, spreads, arrivals, rotations, shares;
  Array<Row> labels, a, b;
};

class Tracer {
 public:
  // Curvature of the surface at vertices, and whether fronts turn about them.
  Tracer(Corners corners, Array<Bearing> bearings, std::span<const double> curvature,
         std::span<const bool> reflex);

  Index n_vertices() const { return curvature_.size(); }

  Carried carry(const SweptFronts& fronts, const Seeds& seeds, const Circle& circle) const;

 private:
  Corners corners_;
  Array<Bearing> bearings_;
  Array<double> curvature_;
  Array<bool> reflex_;
};

}  // namespace geodesic
