#include "triangles/normals.hpp"

#include <cmath>

#include "core/threads.hpp"
#include "triangles/frames.hpp"
#include "triangles/height_fits.hpp"
#include "triangles/rings.hpp"
#include "triangles/vector3.hpp"

namespace geodesic {
namespace {

// Sum of normals, as a share of that of their lengths, below which they cancel.
constexpr double kCancelled = 1e-9;

void put(Array<double>& table, Index row, const Vector3& a) {
  table[3 * row] = a.x;
  table[3 * row + 1] = a.y;
  table[3 * row + 2] = a.z;
}

// Pass the normal of Max of every corner with its vertex: that of the face, whose length is twice
// the area, over the squares of both edges at the corner.
template <class Take>
void each_normal(std::span<const double> vertices, std::span<const Index> faces, Take take) {
  for (Index f = 0; f < count(faces); f += 3) {
    const Vector3 a = at(vertices, faces[f]), b = at(vertices, faces[f + 1]),
                  c = at(vertices, faces[f + 2]);
    const Vector3 ab = b - a, bc = c - b, ca = a - c;
    const double aside[3] = {dot(bc, bc), dot(ca, ca), dot(ab, ab)};
    const Vector3 normal = cross(ab, bc);
    for (int i = 0; i < 3; ++i) {
      const double one = aside[(i + 1) % 3], other = aside[(i + 2) % 3];
      if (!(one > 0 && other > 0)) continue;
      // In two steps: squares of squares of short lengths are 0.
      take(faces[f + i], scaled(scaled(normal, 1 / one), 1 / other));
    }
  }
}

// Sums of the normals of Max at each vertex, and of their lengths, in one table of four columns.
Array<double> sums_of_normals(std::span<const double> vertices, std::span<const Index> faces) {
  Array<double> sums(4 * (count(vertices) / 3), 0.0);
  each_normal(vertices, faces, [&](Index v, const Vector3& normal) {
    double* const sum = &sums[4 * v];
    const double more[4] = {normal.x, normal.y, normal.z, length(normal)};
    for (int k = 0; k < 4; ++k) sum[k] += more[k];
  });
  return sums;
}

Array<double> weighted_normals(std::span<const double> vertices, std::span<const Index> faces) {
  const Index n = count(vertices) / 3;
  const Array<double> sums = sums_of_normals(vertices, faces);
  Array<double> normals(3 * n);
  Array<bool> cancel(n);
  bool any = false;
  for (Index v = 0; v < n; ++v) {
    const Vector3 normal{sums[4 * v], sums[4 * v + 1], sums[4 * v + 2]};
    cancel[v] = sums[4 * v + 3] > 0 && !(length(normal) > kCancelled * sums[4 * v + 3]);
    any |= cancel[v];
    put(normals, v, unit(normal, {0, 0, 1}));
  }
  if (any)
    each_normal(vertices, faces, [&](Index v, const Vector3& normal) {
      if (!cancel[v] || !(length(normal) > 0)) return;
      put(normals, v, unit(normal, {0, 0, 1}));
      cancel[v] = false;
    });
  return normals;
}

// Correct the normals of the vertices [begin, end).
void correct_normals(Array<double>& normals, const Array<double>& axes, const Rings& rings,
                     std::span<const double> vertices, Index begin, Index end) {
  TwoRings both(rings);
  HeightFits fits;
  Index fitted[HeightFits::kAtOnce];
  const auto correct = [&] {
    const Index used = fits.used();
    const HeightFits::Slopes slopes = fits.fit();
    for (Index k = 0; k < used; ++k) {
      const Vector3 normal = at(normals, fitted[k]);
      put(normals, fitted[k], unit(normal - slopes.of[k], normal));
    }
  };
  for (Index v = begin; v < end; ++v) {
    const std::span<const Row> near = both.of(v);
    if (near.empty()) continue;
    const Vector3 normal = at(normals, v), x = at(axes, v);
    fitted[fits.used()] = v;
    fits.add({x, cross(normal, x), normal}, vertices, v, near);
    if (fits.is_full()) correct();
  }
  if (fits.used() > 0) correct();
}

}  // namespace

Array<double> vertex_normals(std::span<const double> vertices, std::span<const Index> faces,
                             int n_threads) {
  Array<double> normals = weighted_normals(vertices, faces);
  const Array<double> axes = tangent_axes(normals);
  const Rings rings(faces, count(vertices) / 3);
  const Index n = rings.n_vertices(), share = n / n_threads + 1;
  in_pieces(n, share, n_threads, [&](Index begin, Index end) {
    correct_normals(normals, axes, rings, vertices, begin, end);
  });
  return normals;
}

}  // namespace geodesic
