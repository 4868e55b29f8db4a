// A front of distance on its way across a triangle.
//
// Every vertex that the front has reached holds its distance d and the geodesic curvature kappa of
// the front there: 1/r for a circle of radius r that spreads, 0 for a straight front, negative for
// one that converges. At a source kappa is infinite.
#pragma once

#include <limits>

#include "core/vectors.hpp"

namespace geodesic {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Difference of kappa at the two ends of an edge, times its length, above which they did not see
// the same front; the front is then taken for a circle about the source.
inline constexpr double kDisagreement = 0.5;

// Least curvature of a front, times edge length: below it circles lose their last digits.
inline constexpr double kStraight = 1e-6;

// The front at a vertex.
struct Front {
  double distance, kappa;
};

// kappa one straight `step` further on a surface of Gaussian curvature K.
//
// The Riccati equation kappa' = -kappa^2 - K, split: exact on the plane, then the kick of K.
inline double along(double kappa, double step, double curvature) {
  if (kappa == kInfinity) return 1 / step;
  const double widened = 1 + kappa * step;
  const double planar = widened > 1e-9 ? kappa / widened : 1 / (1e-9 * step);
  return planar - curvature * step;
}

// What is said of a few triangles at a time.
using Lanes = Pack<8>;

GT_INLINE Lanes lesser(const Lanes& a, const Lanes& b) { return choose(a, b, a, b); }
GT_INLINE Lanes size(const Lanes& a) {
  const Lanes zero = Lanes::zeros();
  return choose(a, zero, zero - a, a);
}

// Edges from a to b with the front at both ends, and how far these are from the third vertex.
struct Edges {
  Lanes distance_a, distance_b, kappa_a, kappa_b, edge, to_a, to_b;

  // How far along the edges the third vertices lie, times twice their length.
  GT_INLINE Lanes twice_along() const { return edge * edge + (to_a - to_b) * (to_a + to_b); }
};

// What reaches the third vertex: its distance, infinite if no ray through it crosses the edge; the
// radius of the front there on a flat surface, negative if it converges; and how far the ray has
// come since the front left the mean distance of the edge.
struct Arrivals {
  Lanes distance, radius, step;
};

// The radius of the front where it crosses an edge, from kappa at its ends; negative if it
// converges.
//
// Of two circles the mean radius (with the mean curvature already the first ring about a source
// would be wrong, and with it the order of the method).
GT_INLINE Lanes radius_on(const Edges& it, const Lanes& mean_distance) {
  const Lanes zero = Lanes::zeros(), two = Lanes::spread(2.0);
  const Lanes product = it.kappa_a * it.kappa_b, sum = it.kappa_a + it.kappa_b;
  const Lanes radius = choose(zero, product, sum, two) / choose(zero, product, two * product, sum);
  const Lanes disagreement = size(it.kappa_a - it.kappa_b) * it.edge;  // no number at two sources
  const Lanes seen = choose(disagreement, Lanes::spread(kDisagreement), radius, mean_distance);
  const Lanes straight = it.edge * Lanes::spread(1 / kStraight);
  return choose(size(seen), straight, seen, straight);
}

// What comes across edges.
//
// In the plane, with a at the origin, b at (edge, 0) and the third vertex at (x, y), the front on
// the edge is a circle whose centre lies below, or above if it converges. The ray through the third
// vertex is at a right angle to it. No number stands for no circle.
GT_INLINE Arrivals across(const Edges& it) {
  const Lanes zero = Lanes::zeros(), half = Lanes::spread(0.5), one = Lanes::spread(1.0);
  const Lanes none = Lanes::spread(kInfinity);
  const Lanes over_twice_edge = half / it.edge, x = it.twice_along() * over_twice_edge;
  const Lanes square = it.to_a * it.to_a - x * x, y = root(choose(square, zero, zero, square));
  const Lanes ahead = it.distance_a - it.distance_b, mean = half * (it.distance_a + it.distance_b);
  const Lanes radius = radius_on(it, mean), sign = choose(radius, zero, zero - one, one);
  const Lanes radius_a = radius + half * ahead;
  const Lanes centre_x = half * it.edge + Lanes::spread(2.0) * radius * ahead * over_twice_edge;
  // Over the centre, in the direction of the front.
  const Lanes rise = sign * y + root(radius_a * radius_a - centre_x * centre_x);
  const Lanes aside = x - centre_x, crossing = x * rise - sign * aside * y;  // times the rise
  const Lanes reached = sign * root(aside * aside + rise * rise), step = reached - radius;
  Lanes distance = mean + step;
  distance = choose(distance, lesser(it.distance_a, it.distance_b), none, distance);
  distance = choose(size(ahead), it.edge, distance, none);
  distance = choose(Lanes::spread(1e-9) * size(radius), rise, distance, none);
  distance = choose(crossing, zero, none, distance);
  distance = choose(it.edge * rise, crossing, none, distance);
  return {distance, reached, step};
}

// Where the third vertex may get less than `limit` across an edge: a bit for each place.
//
// At x on the edge, between 0 and its length, the front is not sooner than d_a - x and d_b - edge +
// x, and then has the way to the vertex before it: least where both are equal.
GT_INLINE unsigned may_gain(const Lanes& limit, const Edges& it) {
  const Lanes zero = Lanes::zeros(), half = Lanes::spread(0.5);
  const Lanes ahead = it.distance_a - it.distance_b, x = half * (it.edge + ahead);
  const Lanes left = limit - half * (it.distance_a + it.distance_b - it.edge);
  Lanes gain = it.edge * (left * left - it.to_a * it.to_a - x * x) + x * it.twice_along();
  gain = choose(zero, left, gain, zero);
  gain = choose(size(ahead), it.edge, gain, zero);  // not where one has not been reached
  gain = choose(lesser(it.distance_a, it.distance_b), limit, gain, zero);
  return below(zero, gain);
}

}  // namespace geodesic
