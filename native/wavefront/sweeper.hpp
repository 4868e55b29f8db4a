// Refined distances: a front that knows the curvature of the surface, swept over its triangles.
//
// The heat method's order is right, or nearly: K. Crane, C. Weischedel, M. Wardetzky, Geodesics in
// heat, ACM Transactions on Graphics 32, 2013, https://doi.org/10.1145/2516971.2516977. In that
// order each vertex takes its distance from triangles whose other corners have theirs, by unfolding
// into the plane, with the curvature of the front carried along by its Riccati equation.
#pragma once

#include "core/near.hpp"
#include "wavefront/falling.hpp"
#include "wavefront/fans.hpp"

namespace geodesic {

// Vertices at and around the sources of each set, [begins[k], begins[k + 1]); their distances,
// which are taken as exact, and the geodesic curvature of the front there. Of each set also the
// improvement below which a vertex is left as it is, and of all whether distances begin at numbers
// other than zero at some sources.
struct Sources {
  std::span<const Index> begins, vertices;
  std::span<const double> distances, curvatures, tolerances;
  bool have_offsets = false;
};

// How far sweeps go.
struct Effort {
  Index returns;      // times that a sweep may go back in its order
  Index steady;       // sweeps that do not go back, to begin with
  Index most_sweeps;  // after which improvement stops, unless some vertex has not been reached
};

class Sweeper {
 public:
  // Curvature of the surface at vertices, and whether fronts turn about them.
  Sweeper(const Corners& corners, std::span<const double> curvature, std::span<const bool> reflex);

  Index n_vertices() const { return curvature_.size(); }

  // Write the distances of all vertices from each set, a row each, infinite where no triangle
  // connects, and if there is workspace for it the curvature of the front there. The heat of each
  // set gives the order of visits.
  void sweep(const HeatTable& heat, const Sources& sources, const Effort& effort,
             std::span<double> distances, std::span<double> kappas, int n_threads) const;

  // The same, to the bit, of the vertices up to limits[k] from set k, and of others near them: as
  // vertices come in the order of the heat, a sweep ends when those that follow are farther.
  NearRows sweep_near(const HeatTable& heat, const Sources& sources, const Effort& effort,
                      std::span<const double> limits, int n_threads) const;

  // Write the distances from one set alone of the vertices that a front reaches before the distance
  // `latest` there, infinite elsewhere, in at most so many visits. No heat is needed: vertices are
  // visited as fronts come to them.
  void sweep_limited(const Sources& sources, std::span<const double> latest, Index most_visits,
                     std::span<double> distances) const;

 private:
  Fans fans_;
  Array<double> curvature_;
  Array<bool> reflex_;
};

}  // namespace geodesic
