// The update of a triangle by a front of distance.
//
// Every vertex that the front has reached holds its distance d and the radius of the front there,
// 1 / kappa with its geodesic curvature kappa: that of a circle that spreads, huge for a straight
// front, negative for one that converges. At a source it is 0.
#pragma once

#include <limits>

#include "core/vectors.hpp"

namespace geodesic {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Difference of kappa at the two ends of an edge, times its length, above which the ends belong to
// different fronts; the front is then taken for a circle about the source. Distances from sources
// with offsets are not radii of circles about them: there it is that of the mean radius.
inline constexpr double kDisagreement = 0.5;

// Least curvature of a front, times edge length: below it circles lose their last digits.
inline constexpr double kStraight = 1e-6;

// The radius of a front without curvature, and more than any other; its square is a number.
inline constexpr double kHuge = 1e150;

// The front at a vertex.
struct Front {
  double distance, radius;
};

// The radius of a front from its curvature.
inline double inverse(double kappa) {
  const double radius = 1 / kappa;
  return std::abs(radius) < kHuge ? radius : kHuge;
}

// The radius one straight `step` further on a flat surface.
inline double wider(double radius, double step) {
  const double sum = radius + step;
  return radius == 0 || sum / radius > 1e-9 ? sum : 1e-9 * step;
}

// The same on one of Gaussian curvature K, that is `bend`.
//
// The Riccati equation kappa' = -kappa^2 - K, split: exact on the plane, then the kick of K.
inline double bent(double radius, double step, double bend) {
  const double result = radius / (1 - bend * step * radius);
  return std::abs(result) < kHuge ? result : kHuge;
}

template <class Lanes>
GT_INLINE Lanes lesser(const Lanes& a, const Lanes& b) {
  return choose(a, b, a, b);
}

// Edges from a to b with the front at both ends, and how far these are from the third vertex; a few
// of them at a time. Nothing comes across an edge that is less than zero long. The sign of the
// length to b has no effect.
template <class Lanes>
struct Edges {
  Lanes distance_a, distance_b, radius_a, radius_b, edge, to_a, to_b;

  // How far along the edges the third vertices lie, times twice their length.
  GT_INLINE Lanes twice_along() const { return edge * edge + (to_a - to_b) * (to_a + to_b); }
};

// The update of the third vertex: its distance, infinite if no ray through it crosses the edge, the
// radius of the front there on a flat surface, and the length of the ray from the mean distance of
// the edge.
template <class Lanes>
struct Arrivals {
  Lanes distance, radius, step;
};

// The radius of the front where it crosses an edge.
//
// Of two circles that both spread, or both converge, the mean radius (with the mean curvature
// already the first ring about a source would be wrong, and with it the order of the method);
// otherwise that of the mean curvature.
template <bool kOffsets = false, class Lanes>
GT_INLINE Lanes radius_on(const Edges<Lanes>& it, const Lanes& mean_distance) {
  const Lanes product = it.radius_a * it.radius_b, sum = it.radius_a + it.radius_b;
  const Lanes other = (product + product) / sum;
  Lanes radius = choose(Lanes::zeros(), product, Lanes::spread(0.5) * sum, other);
  radius = choose(product, Lanes::spread(kHuge), radius, other);
  if constexpr (!kOffsets) {
    const Lanes disagreement = size(it.radius_a - it.radius_b) * it.edge;
    radius =
        choose(disagreement, Lanes::spread(kDisagreement) * size(product), radius, mean_distance);
  }
  const Lanes straight = it.edge * Lanes::spread(1 / kStraight);
  return choose(size(radius), straight, radius, straight);
}

// The updates across edges.
//
// In the plane, with a at the origin, b at (edge, 0) and the third vertex at (x, y), the front on
// the edge is a circle whose centre lies below, or above if it converges. The ray through the third
// vertex is at a right angle to it. Where there is no such circle, or no edge, nothing arrives.
template <bool kOffsets = false, class Lanes>
GT_INLINE Arrivals<Lanes> across(const Edges<Lanes>& it) {
  const Lanes zero = Lanes::zeros(), half = Lanes::spread(0.5);
  const Lanes per_edge = Lanes::spread(1.0) / it.edge, x = half * it.twice_along() * per_edge;
  const Lanes square = it.to_a * it.to_a - x * x, y = root(choose(square, zero, zero, square));
  const Lanes ahead = it.distance_a - it.distance_b, mean = half * (it.distance_a + it.distance_b);
  const Lanes radius = radius_on<kOffsets>(it, mean), radius_a = radius + half * ahead;
  const Lanes centre_x = half * it.edge + radius * (ahead * per_edge), aside = x - centre_x;
  // Over the centre, in the direction of the front.
  const Lanes rise = signed_by(radius, y) + root(radius_a * radius_a - centre_x * centre_x);
  const Lanes crossing = x * rise - signed_by(radius, aside * y);  // along the edge, times the rise
  const Lanes none = Lanes::spread(kInfinity);
  Lanes start = choose(size(ahead), it.edge, mean, none);
  start = choose(Lanes::spread(1e-9) * size(radius), rise, start, none);
  start = choose(crossing, zero, none, start);
  start = choose(it.edge * rise, crossing, none, start);
  const Lanes reached = signed_by(radius, root(aside * aside + rise * rise));
  const Lanes step = reached - radius, distance = start + step;
  return {choose(lesser(it.distance_a, it.distance_b), distance, distance, none), reached, step};
}

// The edges, one bit each, across which the third vertex may get less than `limit`.
//
// At x on the edge, between 0 and its length, the distance is at least d_a - x and d_b - edge +
// x, plus the length to the vertex: this bound is least where both are equal.
template <class Lanes>
GT_INLINE unsigned may_gain(const Lanes& limit, const Edges<Lanes>& it) {
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
