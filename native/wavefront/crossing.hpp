// A front of distance on its way across a triangle.
//
// Every vertex that the front has reached holds its distance d and the geodesic curvature kappa of
// the front there: 1/r for a circle of radius r that spreads, 0 for a straight front, negative for
// one that converges. At a source kappa is infinite.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

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

// What reaches a vertex: its distance, kappa of the front there on a flat surface, and how far the
// ray has come since the front left the mean distance of the edge that it crossed.
struct Arrival {
  double distance = kInfinity, kappa = 0.0, step = 0.0;
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

// kappa of the front where it crosses an edge, from kappa at its ends.
//
// Of two circles the mean radius (with the mean curvature already the first ring about a source
// would be wrong, and with it the order of the method).
inline double on_edge(double kappa_a, double kappa_b, double edge, double mean_distance) {
  if (std::isinf(kappa_a) || std::isinf(kappa_b)) return 1 / mean_distance;
  if (std::abs(kappa_a - kappa_b) * edge > kDisagreement) return 1 / mean_distance;
  if (kappa_a * kappa_b > 0) return 2 * kappa_a * kappa_b / (kappa_a + kappa_b);
  return (kappa_a + kappa_b) / 2;
}

// What reaches corner c of a triangle through its edge ab; infinite if no ray through c crosses it.
//
// In the plane, with a at the origin, b at (edge, 0) and c at (c_x, c_y), the front on the edge is
// a circle of curvature kappa whose centre lies below, or above if it converges. The ray through c
// is at a right angle to it.
inline Arrival across(double d_a, double d_b, double kappa, double edge, double c_x, double c_y) {
  if (std::abs(kappa) * edge < kStraight) kappa = kStraight / edge;
  const double sign = kappa > 0 ? 1.0 : -1.0;
  const double radius = sign / kappa, mean_distance = (d_a + d_b) / 2;
  const double radius_a = radius + sign * (d_a - mean_distance);
  const double radius_b = radius + sign * (d_b - mean_distance);
  if (radius_a < 0 || radius_b < 0 || radius_a + radius_b < edge) return {};
  const double centre_x = (radius_a * radius_a - radius_b * radius_b + edge * edge) / (2 * edge);
  const double below = radius_a * radius_a - centre_x * centre_x;
  if (below < 0) return {};
  const double centre_y = -sign * std::sqrt(below);
  const double rise = sign * (c_y - centre_y);
  if (rise <= 1e-9 * radius) return {};
  const double crossing = c_x - (c_x - centre_x) * c_y / (c_y - centre_y);
  if (crossing < 0 || crossing > edge) return {};
  const double x = c_x - centre_x, y = c_y - centre_y;
  const double radius_c = std::sqrt(x * x + y * y);
  const double step = sign * (radius_c - radius);
  return {mean_distance + step, sign / std::max(radius_c, 1e-12 * edge), step};
}

// Whether a corner at distance d may get less through the edge ab of its triangle.
//
// At x on the edge, between 0 and `edge`, the front is not sooner than d_a - x and d_b - edge + x,
// and then has the way to the corner before it: least where both are equal. `twice` is 2 `edge`
// times the place of the corner along the edge.
inline bool may_gain(double d, double d_a, double d_b, double edge, double to_a, double twice) {
  if (!(std::abs(d_a - d_b) < edge) || std::min(d_a, d_b) >= d)  // also where one is not reached
    return false;
  const double x = (edge + d_a - d_b) / 2, left = d - (d_a + d_b - edge) / 2;
  return left > 0 && edge * (left * left - to_a * to_a - x * x) + x * twice > 0;
}

// What reaches a corner through the opposite edge, from a to b, if that is less than `limit`;
// otherwise infinite. `to_a` and `to_b` are their distances from the corner.
inline Arrival through(double limit, const Front& a, const Front& b, double edge, double to_a,
                       double to_b) {
  const double twice = edge * edge + (to_a - to_b) * (to_a + to_b);
  if (!may_gain(limit, a.distance, b.distance, edge, to_a, twice)) return {};  // two thirds of all
  const double x = twice / (2 * edge);
  const double y = std::sqrt(std::max(to_a * to_a - x * x, 0.0));
  const double front = on_edge(a.kappa, b.kappa, edge, (a.distance + b.distance) / 2);
  const Arrival found = across(a.distance, b.distance, front, edge, x, y);
  const bool better = std::min(a.distance, b.distance) <= found.distance && found.distance < limit;
  return better ? found : Arrival{};
}

}  // namespace geodesic
