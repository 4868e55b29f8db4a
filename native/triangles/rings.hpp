// The neighbours of vertices in triangles, and the neighbours of these.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// The one-ring of each vertex, each neighbour once.
class Rings {
 public:
  // Number of neighbours above which a vertex adds none to the two rings of another, and has none
  // itself: where thousands of edges meet, those of each vertex nearby would have thousands.
  static constexpr Index kMostNeighbours = 64;

  Rings(std::span<const Index> faces, Index n_vertices);

  Index n_vertices() const { return starts_.size() - 1; }
  Index size(Index v) const { return starts_[v + 1] - starts_[v]; }
  std::span<const Row> of(Index v) const {
    return {near_.data() + starts_[v], static_cast<std::size_t>(size(v))};
  }
  // Whether faces surround a vertex: as many as it has edges.
  bool is_inside(Index v) const { return is_inside_[v]; }

 private:
  Array<Row> starts_;
  Array<Row> near_;  // with some numbers behind the last, which are copied along with it
  Array<bool> is_inside_;
};

// Gathers both rings of one vertex after the other.
class TwoRings {
 public:
  explicit TwoRings(const Rings& rings);

  // The vertices of both rings, until the next call; none on the boundary, and where too many edges
  // meet.
  std::span<const Row> of(Index v);

 private:
  const Rings& rings_;
  Array<Row> met_at_;  // the vertex in whose rings each one was met last
  Array<Row> all_, both_;
};

}  // namespace geodesic
