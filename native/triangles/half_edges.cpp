#include "triangles/half_edges.hpp"

#include "core/processor.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 48;  // corners of prefetch distance: places come in no order

// Half-edges between two vertices: none, one, two that run against or along one another, more.
enum class Met : std::int8_t { kNobody, kOne, kAgainst, kAlong, kMore };

}  // namespace

HalfEdges sorted_half_edges(std::span<const Index> faces, Index n_vertices) {
  const Index n_half_edges = count(faces);
  HalfEdges result{Array<Row>(n_vertices + 1, 0), Array<HalfEdge>(n_half_edges)};
  Row* const start = result.starts.data();
  Array<Row> free(n_vertices);
  for (Index f = 0; f < n_half_edges; f += 3) {
    const Index i = faces[f], j = faces[f + 1], k = faces[f + 2];
    ++start[std::min(j, k) + 1];
    ++start[std::min(k, i) + 1];
    ++start[std::min(i, j) + 1];
  }
  for (Index v = 0; v < n_vertices; ++v) {
    free[v] = start[v];
    start[v + 1] += start[v];
  }
  Row half = 0;
  const auto put = [&](Index tail, Index head) {
    result.halves[free[std::min(tail, head)]++] = {static_cast<Row>(std::max(tail, head)),
                                                   tail < head ? half : ~half};
    ++half;
  };
  for (Index f = 0; f < n_half_edges; f += 3) {
    const Index soon = std::min(f + kPrefetchDistance, n_half_edges - 3);
    const Index a = faces[soon], b = faces[soon + 1], c = faces[soon + 2];
    prefetch(&result.halves[free[std::min(b, c)]]);
    prefetch(&result.halves[free[std::min(c, a)]]);
    prefetch(&result.halves[free[std::min(a, b)]]);
    const Index i = faces[f], j = faces[f + 1], k = faces[f + 2];
    put(j, k);
    put(k, i);
    put(i, j);
  }
  return result;
}

Twins twins(const HalfEdges& half_edges) {
  const Index n = half_edges.n_vertices();
  Array<Index> twin(half_edges.halves.size());
  Array<Row> first(n);
  Array<Met> met(n, Met::kNobody);
  bool coherent = true;
  for (Index v = 0; v < n; ++v) {
    for (Row place = half_edges.starts[v]; place < half_edges.starts[v + 1]; ++place) {
      const auto [other, signed_half] = half_edges.halves[place];
      const Index half = number(signed_half);
      prefetch(&twin[half]);
      twin[half] = -1;
      if (met[other] == Met::kNobody) {
        first[other] = signed_half;
        met[other] = Met::kOne;
        continue;
      }
      const Index mate = number(first[other]);
      if (met[other] == Met::kOne) {
        twin[half] = mate;
        twin[mate] = half;
        met[other] = (first[other] < 0) != (signed_half < 0) ? Met::kAgainst : Met::kAlong;
      } else {
        if (twin[mate] >= 0) {
          twin[twin[mate]] = -1;
          twin[mate] = -1;
        }
        met[other] = Met::kMore;
      }
    }
    for (Row place = half_edges.starts[v]; place < half_edges.starts[v + 1]; ++place) {
      Met& seen = met[half_edges.halves[place].head];
      coherent &= seen != Met::kAlong;
      seen = Met::kNobody;
    }
  }
  return {std::move(twin), coherent};
}

}  // namespace geodesic
