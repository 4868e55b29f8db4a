// Bounds of distances along a surface: the straight line below, the path along edges above.
#pragma once

#include "bounds/source_tree.hpp"
#include "core/matrix.hpp"

namespace geodesic {

// The edges of triangles, (E, 3), as a pattern: in each row the neighbours of a vertex, sorted.
Matrix edges_of(std::span<const Index> triangles, Index n_vertices);

// Raise finite distances to what the straight line from the nearest place reads.
void raise_to_straight_line(std::span<const double> vertices, const SourceValues& starts,
                            std::span<double> distances);

// The same of some vertices, whose distances these are.
void raise_to_straight_line(std::span<const double> vertices, std::span<const Index> near,
                            const SourceValues& starts, std::span<double> distances);

// Edges from their lower ends, one after the other, each with a little less than its length: what
// most have to be looked at for.
struct Spans {
  Array<Row> tails, heads;
  Array<float> lengths;
};

// Vertices, (N, 3), those without an edge may be NaN, and the edges between them: a symmetric
// pattern with sorted rows, whose diagonal is of no account.
class EdgeBounds {
 public:
  EdgeBounds(std::span<const double> vertices, const Pattern& edges);

  // Lower distances to the shortest path along edges from any vertex. What is infinite stays.
  //
  // E. W. Dijkstra, A note on two problems in connexion with graphs, 1959,
  // https://doi.org/10.1007/BF01386390, begun at the edges across which distances differ by more
  // than their length: on most meshes there are a few, so a search begins in nearly every call.
  void lower(std::span<double> distances) const;

  // The same where all but some vertices, which ascend, are infinite because they are not known.
  // Return false if one of the others may be within the limit.
  bool lower_near(std::span<const Index> near, double limit, std::span<double> distances) const;

 private:
  std::span<const double> vertices_;
  Pattern edges_;
  Spans spans_;
};

}  // namespace geodesic
