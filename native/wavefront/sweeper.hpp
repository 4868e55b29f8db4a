// Refined distances: a front that knows the curvature of the surface, swept over its triangles.
//
// The heat method's order is right, or nearly: K. Crane, C. Weischedel, M. Wardetzky, Geodesics in
// heat, ACM Transactions on Graphics 32, 2013, https://doi.org/10.1145/2516971.2516977. In that
// order each vertex takes its distance from triangles whose other corners have theirs, by unfolding
// into the plane, with the curvature of the front carried along by its Riccati equation.
#pragma once

#include "wavefront/fans.hpp"

namespace geodesic {

// Vertices at and around the sources, their distances, which are taken as exact, and the geodesic
// curvature of the front there.
struct Sources {
  std::span<const Index> vertices;
  std::span<const double> distances, curvatures;
};

// How far sweeps go.
struct Effort {
  double tolerance;   // improvement below which a vertex is left as it is
  Index returns;      // times that a sweep may go back in its order
  Index steady;       // sweeps that do not go back, to begin with
  Index most_sweeps;  // after which improvement stops, unless some vertex has not been reached
};

class Sweeper {
 public:
  // Curvature of the surface at vertices, and whether fronts turn about them.
  Sweeper(const Corners& corners, std::span<const double> curvature, std::span<const bool> reflex);

  Index n_vertices() const { return curvature_.size(); }

  // Write the distance of each vertex, infinite where no triangle connects, and if there is room
  // for it the curvature of the front there. `log_heat` gives the order of visits.
  void sweep(std::span<const double> log_heat, const Sources& sources, const Effort& effort,
             std::span<double> distances, std::span<double> kappas) const;

 private:
  Fans fans_;
  Array<double> curvature_;
  Array<bool> reflex_;
};

}  // namespace geodesic
