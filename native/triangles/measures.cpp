#include "triangles/measures.hpp"

#include <cmath>
#include <limits>

#include "triangles/vector3.hpp"

namespace geodesic {
namespace {

void write(Measures& triangles, Index f, double edge, double along, double doubled) {
  double* const frame = triangles.frames.data() + 3 * f;
  frame[0] = 1 / edge;
  frame[1] = -along / doubled;
  frame[2] = edge / doubled;
  triangles.areas[f] = doubled / 2;
}

}  // namespace

Measured measure_triangles(std::span<const double> vertices, std::span<const Index> faces) {
  const Index n_faces = count(faces) / 3;
  Measured result{{Array<double>(3 * n_faces), Array<double>(n_faces)},
                  0.0,
                  std::numeric_limits<double>::infinity()};
  for (Index f = 0; f < n_faces; ++f) {
    const Index i = faces[3 * f], j = faces[3 * f + 1], k = faces[3 * f + 2];
    const Vector3 u = at(vertices, j) - at(vertices, i), v = at(vertices, k) - at(vertices, i);
    const double ij = length(u), ik = length(v), jk = length(at(vertices, k) - at(vertices, j));
    const double sum = ij + ik + jk, longest = std::max({ij, ik, jk});
    result.total += sum;
    result.slack = std::min(result.slack, longest > 0 ? (sum - 2 * longest) / longest : 0.0);
    write(result.triangles, f, ij, dot(u, v) / ij, length(cross(u, v)));
  }
  return result;
}

Measures measure_lengths(std::span<const double> lengths) {
  const Index n_faces = count(lengths) / 3;
  Measures result{Array<double>(3 * n_faces), Array<double>(n_faces)};
  for (Index f = 0; f < n_faces; ++f) {
    const double jk = lengths[3 * f], ki = lengths[3 * f + 1], ij = lengths[3 * f + 2];
    const double along = (ij * ij + (ki - jk) * (ki + jk)) / (2 * ij);
    write(result, f, ij, along, doubled_area(jk, ki, ij));
  }
  return result;
}

Array<double> edge_lengths(std::span<const double> frames) {
  Array<double> lengths(count(frames));
  for (Index e = 0; e < lengths.size(); e += 3) {
    const double p = frames[e], q = frames[e + 1], r = frames[e + 2], s = q + r;
    const double spanned = std::abs(p * r);
    lengths[e] = std::sqrt(p * p + s * s) / spanned;
    lengths[e + 1] = std::sqrt(p * p + q * q) / spanned;
    lengths[e + 2] = std::abs(r) / spanned;
  }
  return lengths;
}

Array<double> corner_angles(std::span<const double> lengths) {
  Array<double> angles(count(lengths));
  for (Index f = 0; f < count(lengths); f += 3) {
    const double p = lengths[f], q = lengths[f + 1], r = lengths[f + 2];
    const double area = doubled_area(p, q, r);
    angles[f] = angle((q * q + r * r - p * p) / 2, area);
    angles[f + 1] = angle((r * r + p * p - q * q) / 2, area);
    angles[f + 2] = angle((p * p + q * q - r * r) / 2, area);
  }
  return angles;
}

}  // namespace geodesic
