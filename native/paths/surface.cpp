#include "paths/surface.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace geodesic {
namespace {

// Squared area of a triangle, to the product of two squared edges, below which it has none.
constexpr double kMinSquaredArea = 1e-24;

struct Step {
  double x, y, z;
};

double dot(Step p, Step q) { return p.x * q.x + p.y * q.y + p.z * q.z; }

Step step(std::span<const double> places, Index from, Index to) {
  const double *const p = &places[3 * from], *const q = &places[3 * to];
  return {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
}

}  // namespace

Surface::Surface(std::span<const double> places, std::span<const Index> faces)
    : places_(places),
      faces_(faces),
      starts_(count(places) / 3 + 1, Index{0}),
      around_(count(faces)),
      total_angles_(count(places) / 3, -1.0) {
  for (const Index vertex : faces) ++starts_[vertex + 1];
  for (Index v = 0; v < n_vertices(); ++v) starts_[v + 1] += starts_[v];
  Array<Index> free(n_vertices());
  std::copy_n(starts_.begin(), n_vertices(), free.begin());
  for (Index c = 0; c < count(faces); ++c) around_[free[faces[c]]++] = c / 3;
}

std::vector<Index> Surface::at_edge(Index a, Index b) const {
  std::vector<Index> found;
  for (const Index face : around(a))
    if (has(face, b)) found.push_back(face);
  return found;
}

Index Surface::third(Index face, Index a, Index b) const {
  const Index* const c = corners(face);
  return c[0] != a && c[0] != b ? c[0] : c[1] != a && c[1] != b ? c[1] : c[2];
}

std::pair<Index, Index> Surface::others(Index face, Index vertex) const {
  const Index* const c = corners(face);
  if (c[0] == vertex) return {c[1], c[2]};
  return {c[0], c[1] == vertex ? c[2] : c[1]};
}

double Surface::length(Index a, Index b) const {
  const Step along = step(places_, a, b);
  return std::sqrt(dot(along, along));
}

Planar Surface::shape(Index a, Index b, Index c) const {
  const Step p = step(places_, a, b), q = step(places_, a, c);
  const Step normal{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  const double squared = dot(p, p);
  return Planar(dot(p, q), std::sqrt(dot(normal, normal))) / (squared > 0 ? squared : 1.0);
}

double Surface::angle(Index face, Index vertex) const {
  const auto [p, q] = others(face, vertex);
  return std::arg(shape(vertex, p, q));
}

double Surface::total_angle(Index vertex) const {
  const std::atomic_ref<double> kept(total_angles_[vertex]);
  double total = kept.load(std::memory_order_relaxed);
  if (total >= 0) return total;
  total = 0;
  for (const Index face : around(vertex)) total += angle(face, vertex);
  kept.store(total, std::memory_order_relaxed);
  return total;
}

std::vector<Index> Surface::chain(Index first, Index last, Index vertex) const {
  std::vector<std::pair<Index, std::size_t>> came{{first, 0}};  // a face, and which led there
  for (std::size_t at = 0; at < came.size() && came.back().first != last; ++at) {
    const auto [p, q] = others(came[at].first, vertex);
    for (const Index corner : {p, q}) {
      for (const Index beside : around(vertex)) {
        if (!has(beside, corner)) continue;
        const bool known =
            std::ranges::any_of(came, [&](auto& one) { return one.first == beside; });
        if (!known && came.back().first != last) came.push_back({beside, at});
      }
    }
  }
  if (came.back().first != last) return {};
  std::vector<Index> path{last};
  for (std::size_t at = came.size() - 1; at != 0;) {
    at = came[at].second;
    path.push_back(came[at].first);
  }
  std::ranges::reverse(path);
  return path;
}

std::vector<Index> Surface::ring(Index vertex, Index first) const {
  const std::size_t size = around(vertex).size();
  std::vector<Index> faces{first};
  for (Index edge = others(first, vertex).second;;) {
    Index beside = -1;
    for (const Index face : around(vertex)) {
      if (face == faces.back() || !has(face, edge)) continue;
      if (beside >= 0) return {};
      beside = face;
    }
    if (beside == first && faces.size() == size) return faces;
    if (beside < 0 || beside == first || faces.size() == size) return {};
    faces.push_back(beside);
    edge = third(beside, vertex, edge);
  }
}

bool Surface::descent(const Index (&corners)[3], std::span<const double> height,
                      double (&rates)[3]) const {
  const auto [a, b, c] = corners;
  const double rise_u = height[b] - height[a], rise_v = height[c] - height[a];
  if (!std::isfinite(rise_u) || !std::isfinite(rise_v)) return false;
  const Step u = step(places_, a, b), v = step(places_, a, c);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v);
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > kMinSquaredArea * uu * vv)) return false;
  rates[1] = -(vv * rise_u - uv * rise_v) / determinant;
  rates[2] = -(uu * rise_v - uv * rise_u) / determinant;
  rates[0] = -rates[1] - rates[2];
  return true;
}

}  // namespace geodesic
