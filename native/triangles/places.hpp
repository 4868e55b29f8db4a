// Places in space.
#pragma once

#include <cmath>

#include "core/array.hpp"

namespace geodesic {

struct Place {
  double x, y, z;
  friend Place operator-(const Place& a, const Place& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
};
inline double dot(const Place& a, const Place& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(const Place& a) { return std::sqrt(dot(a, a)); }
inline Place cross(const Place& a, const Place& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Row v of a table of places, (N, 3).
inline Place at(std::span<const double> table, Index v) {
  const double* const row = table.data() + 3 * v;
  return {row[0], row[1], row[2]};
}

}  // namespace geodesic
