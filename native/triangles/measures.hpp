// Triangles measured in planes of their own.
//
// A frame puts the corners at (0, 0), (l, 0) and (a, b), and (p, q, r) with [[p, 0], [q, r]] the
// inverse of [[l, 0], [a, b]] takes the differences of a linear function to its gradient.
#pragma once

#include <cmath>

#include "core/angles.hpp"
#include "core/array.hpp"

namespace geodesic {

struct Measures {
  Array<double> frames;  // (F, 3): (p, q, r)
  Array<double> areas;
};

struct Measured {
  Measures triangles;
  double total = 0.0;  // of all edge lengths
  double slack;        // the least by which two edges exceed the third, over the longest
};

Measured measure_triangles(std::span<const double> vertices, std::span<const Index> faces);
// By the edges opposite the corners, (F, 3), and back.
Measures measure_lengths(std::span<const double> lengths);
Array<double> edge_lengths(std::span<const double> frames);
// The area, doubled, of a triangle with such edges: Heron's formula in Kahan's order of operations,
// which does not cancel for thin ones.
inline double doubled_area(double p, double q, double r) {
  const double high = p > q ? p : q, low = p > q ? q : p;
  const double a = high > r ? high : r, rest = high > r ? r : high;
  const double b = rest > low ? rest : low, c = rest > low ? low : rest;
  const double product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
  return std::sqrt(product < 0 ? 0.0 : product) / 2;
}
// The angles at all corners, (F, 3), by the edges opposite them: Heron's formula as above.
Array<double> corner_angles(std::span<const double> lengths);
// The angle between two edges of a triangle, by the third.
inline double angle_between(double one, double other, double opposite) {
  return angle((one * one + other * other - opposite * opposite) / 2,
               doubled_area(one, other, opposite));
}

}  // namespace geodesic
