// Triangles laid out one by one in the plane, and how they hang together.
#pragma once

#include <vector>

#include "core/array.hpp"

namespace geodesic {

// HalfEdge 3 f + c of face f runs from its corner c to its corner c + 1. In the plane of the side
// its tail is the origin, its head (length, 0), and the third corner (x, y) with y at least 0.
struct HalfEdge {
  Index tail, head, third;
  double length, x, y;
  Index next, last;  // the half-edges from head to third and from third to tail, of the same face
};

class Polyhedron {
 public:
  // Vertices, (N, 3), and different faces, (E, 3), of three different vertices each.
  Polyhedron(std::span<const double> vertices, std::span<const Index> faces);

  Index n_vertices() const { return count(std::span(turns_)); }
  const HalfEdge& side(Index s) const { return half_edges_[s]; }

  // The half-edges of the edge of a half-edge, itself among them.
  std::span<const Index> beside(Index s) const { return half_edges_of_.at(edge_[s]); }
  // The half-edges opposite a vertex, one for each face around it.
  std::span<const Index> opposite(Index v) const { return opposite_.at(v); }
  // True if a shortest path may turn about a vertex: the angles there are more than 2π, it lies on
  // an edge that has not two faces, sheets meet there in this vertex alone, or it lies where one of
  // its neighbours does.
  bool turns(Index v) const { return turns_[v]; }

 private:
  // Lists of integers, one behind the other.
  struct Lists {
    std::vector<Index> starts, entries;
    std::span<const Index> at(Index i) const {
      return std::span(entries).subspan(starts[i], starts[i + 1] - starts[i]);
    }
  };
  static Lists sorted_by(std::span<const Index> keys, Index n_keys);
  Index number_edges();
  void find_turns(Index n_edges);
  bool is_one_fan(Index v) const;

  std::vector<HalfEdge> half_edges_;
  std::vector<Index> edge_;  // of each side
  Lists half_edges_of_, opposite_;
  std::vector<char> turns_;
};

}  // namespace geodesic
