// Slopes of surfaces at vertices, by fits of the heights of their neighbours.
#pragma once

#include <vector>

#include "core/vectors.hpp"
#include "triangles/vector3.hpp"

namespace geodesic {

// Heights above a plane through a vertex as a polynomial of third degree, by least squares, for
// several vertices at once.
//
// Rows have the weight 1 / r^2. In terms of r^2, the squared distance in space, heights of a sphere
// are one term, and a fit on a sphere is exact. Terms but the slope are eliminated one by one from
// the normal equations, whose matrix is small: where terms depend on each other, one is left out.
class HeightFits {
 public:
  static constexpr int kAtOnce = 8;  // vertices

  // The plane through the vertex of a lane, as two axes and the normal.
  struct Plane {
    Vector3 x, y, normal;
  };

  bool is_full() const { return used_ == kAtOnce; }
  Index used() const { return used_; }

  // Take a vertex with the steps from there to its neighbours.
  void add(const Plane& plane, std::span<const double> vertices, Index v,
           std::span<const Row> near);

  // Return the slope in space of each vertex that was taken, as far as it is certain, and forget
  // these vertices.
  struct Slopes {
    Vector3 of[kAtOnce];
  };
  Slopes fit();

 private:
  using Lanes = Pack<kAtOnce>;
  static constexpr int kTerms = 7, kX = 7, kY = 8, kZ = 9, kColumns = 10;

  // The terms of a neighbour, its weight and the inverse of that; zeros where there is none.
  struct Terms {
    Lanes of[kColumns], weight, square;
  };
  // Products of columns, of which those from the diagonal on count; once eliminated, row k has the
  // equation of the k-th term.
  struct Normal {
    Lanes of[kColumns][kColumns];
  };
  // Heights a x + b y by least squares, and the sums of squares that give a and b.
  struct Fit {
    Lanes xx, xy, yy, determinant, a, b;
  };

  Lanes longest() const;
  Lanes write_terms();
  Normal products() const;
  template <int kFirst, int kLast, int kBegin, int kEnd>
  void add_products(Normal& normal) const;
  static Lanes eliminate(Normal& normal, Lanes (&inverse)[kTerms]);
  Lanes variance_of(const Fit& its, const Normal& normal, const Lanes (&inverse)[kTerms],
                    const Lanes& n_spare) const;

  Plane planes_[kAtOnce];
  Index n_near_[kAtOnce], used_ = 0, n_rows_ = 0;
  std::vector<double> steps_;  // (rows, 3, kAtOnce)
  std::vector<Terms> rows_;
};

}  // namespace geodesic
