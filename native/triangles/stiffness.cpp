#include "triangles/stiffness.hpp"

#include "core/processor.hpp"
#include "triangles/vector3.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 16;  // half-edges of prefetch distance

}  // namespace

EdgeSums edge_sums(std::span<const Index> faces, const HalfEdges& half_edges,
                   std::span<const double> frames, std::span<const double> measure) {
  const Index n = half_edges.n_vertices(), n_half_edges = half_edges.halves.size();
  EdgeSums result{{Array<Row>(n + 1), Array<Row>(n_half_edges), Array<double>(n_half_edges)},
                  Array<double>(n, 0.0),
                  Array<bool>(n, false)};
  Array<double> entries(n_half_edges);  // the stiffness of each half-edge
  for (Index e = 0; e < n_half_edges; e += 3) {
    const double p = frames[e], q = frames[e + 1], r = frames[e + 2], s = q + r;
    const double area = measure[e / 3];
    entries[e] = area * (q * r);
    entries[e + 1] = -(area * (s * r));
    entries[e + 2] = -(area * (p * p + s * q));
    for (int c = 0; c < 3; ++c) result.lumped_mass[faces[e + c]] += area / 3;
  }
  // Sides are added in their order, so that an edge's weight is one sum of one order. `edge_to` is
  // the edge from v to a vertex, plus 1; of earlier vertices it is less.
  Array<Row> edge_to(n, 0);
  Array<std::int8_t> single(n_half_edges);
  Row* const head_of = result.edges.indices.data();
  double* const sum_of = result.edges.data.data();
  const HalfEdge* const halves = half_edges.halves.data();
  Row count = 0;
  for (Index v = 0; v < n; ++v) {
    const Row old = result.edges.indptr[v] = count;
    for (Row side = half_edges.starts[v]; side < half_edges.starts[v + 1]; ++side) {
      prefetch(&entries[number(halves[std::min(side + kPrefetchDistance, n_half_edges - 1)].half)]);
      const Row head = halves[side].head;
      const double value = entries[number(halves[side].half)];
      if (head == v) continue;  // from a vertex to itself
      const Row edge = edge_to[head] - 1;
      if (edge < old) {
        head_of[count] = head;
        single[count] = 1;
        sum_of[count] = value;
        edge_to[head] = ++count;
      } else {
        single[edge] = 0;
        sum_of[edge] += value;
      }
    }
    for (Row edge = old; edge < count; ++edge) {
      result.boundary[v] |= single[edge] != 0;
      result.boundary[head_of[edge]] |= single[edge] != 0;
    }
  }
  result.edges.indptr[n] = count;
  result.edges.indices.shorten(count);
  result.edges.data.shorten(count);
  return result;
}

// Rows come out sorted without being sorted: the edges in the order of their lower ends fill what
// lies left of the diagonal, and then the rows in their order what lies right of it.
Matrix mirrored(const MatrixView& edges) {
  const Index n = edges.size(), n_edges = count(edges.indices);
  Matrix result{Array<Row>(n + 1, 0), Array<Row>(n + 2 * n_edges), Array<double>(n + 2 * n_edges)};
  Array<double> degree(n, 0.0);
  Array<Row> middle(n), free(n);
  const Row *const begin = edges.indptr.data(), *const head = edges.indices.data();
  const double* const weight = edges.data.data();
  Row *const start = result.indptr.data(), *const column = result.indices.data();
  double* const entry = result.data.data();
  for (Index v = 0; v < n; ++v) {
    start[v + 1] += begin[v + 1] - begin[v] + 1;
    for (Row edge = begin[v]; edge < begin[v + 1]; ++edge) {
      ++start[head[edge] + 1];
      degree[v] -= weight[edge];
      degree[head[edge]] -= weight[edge];
    }
  }
  for (Index v = 0; v < n; ++v) {
    middle[v] = start[v];  // the next place left of the diagonal, until all are taken
    start[v + 1] += start[v];
  }
  for (Index v = 0; v < n; ++v) {
    for (Row edge = begin[v]; edge < begin[v + 1]; ++edge) {
      const Row place = middle[head[edge]]++;
      column[place] = static_cast<Row>(v);
      entry[place] = weight[edge];
    }
  }
  for (Index v = 0; v < n; ++v) {
    column[middle[v]] = static_cast<Row>(v);
    entry[middle[v]] = degree[v];
    free[v] = middle[v] + 1;
  }
  for (Index row = 0; row < n; ++row) {
    for (Row left = start[row]; left < middle[row]; ++left) {
      const Row place = free[column[left]]++;
      column[place] = static_cast<Row>(row);
      entry[place] = entry[left];
    }
  }
  return result;
}

double mean_edge_length(std::span<const double> vertices, const Pattern& pattern) {
  double total = 0.0;
  Index count = 0;
  for (Index v = 0; v < pattern.size(); ++v) {
    for (Row entry = pattern.indptr[v]; entry < pattern.indptr[v + 1]; ++entry) {
      const Row head = pattern.indices[entry];
      if (head <= v) continue;
      total += length(at(vertices, head) - at(vertices, v));
      ++count;
    }
  }
  return total / static_cast<double>(count);
}

}  // namespace geodesic
