// Vectors in space.
#pragma once

#include <cmath>

#include "core/array.hpp"

namespace geodesic {

struct Vector3 {
  double x, y, z;
  friend Vector3 operator-(const Vector3& a, const Vector3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
};
inline double dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(const Vector3& a) { return std::sqrt(dot(a, a)); }
inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vector3 scaled(const Vector3& a, double by) { return {a.x * by, a.y * by, a.z * by}; }
inline Vector3 sum(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
// A vector of length 1, or another one where there is no direction.
inline Vector3 unit(const Vector3& a, const Vector3& otherwise) {
  const double size = length(a);
  return size > 0 ? scaled(a, 1 / size) : otherwise;
}
// Row v of a table of vectors, (N, 3).
inline Vector3 at(std::span<const double> table, Index v) {
  const double* const row = table.data() + 3 * v;
  return {row[0], row[1], row[2]};
}

}  // namespace geodesic
