// The loops that edges close with the shortest paths along edges from one vertex, by their classes.
//
// The loop of an edge between two branches of the tree of shortest paths shrinks to a point if and
// only if the edge is on a part of the surface that the faces beside such edges, taken away from
// their free ends on, use up; holes are not taken away (J. Erickson, K. Whittlesey, Greedy optimal
// homotopy and homology generators, SODA 2005, https://dl.acm.org/doi/10.5555/1070432.1070581). Of
// the edges that are left those that follow one another without a branch close loops of one class.
#pragma once

#include "paths/sheets.hpp"

namespace geodesic {

// An edge, and the length of its loop.
struct Closing {
  double length;
  Row edge;
};

class TreeLoops {
 public:
  explicit TreeLoops(const Sheets& sheets);

  // The tree of shortest paths from a vertex of the surface, and the classes of its loops.
  void set_root(Index original);

  // The vertices that the root is connected with, the nearest first.
  std::span<const Row> reached() const { return order_; }
  double distance(Row vertex) const { return distance_[vertex]; }
  // An edge of more than two faces that is reached, or kNone. There the classes are not right.
  Row crowded_edge() const { return crowded_; }

  // The loops that do not shrink to a point, the shortest of each class and those that are longer
  // by a share `spread` at most, the shortest first.
  std::vector<Closing> shortest_of_classes(double spread = 0.0);
  // The loop of an edge as vertices of the surface, from the root back to it.
  std::vector<Index> loop(Row edge) const;
  // Vertices of lines along edges, from the root on, which every loop that does not shrink meets.
  std::vector<Row> cut();

 private:
  void grow(Index original);
  void list_edges();
  void join_branches();
  void take_away();
  std::vector<Index> path(Row vertex) const;
  double length(Row edge) const;
  // The parts of the tree that an edge lies between, the lesser number first.
  std::pair<Row, Row> parts(Row edge) const;
  std::vector<Closing> class_of(Row edge);

  const Sheets& sheets_;
  Array<double> distance_;  // from the root
  Array<Row> before_, up_;  // the next vertex on the path to the root, and the edge to it
  Array<Row> part_;         // parts of the tree each lie in one sheet
  std::vector<Row> order_;  // vertices
  std::vector<Row> edges_;  // between vertices that are reached
  std::vector<Row> joins_;  // edges that join parts of the tree that lie in one sheet
  Array<std::int8_t> state_;
  Array<Row> n_left_;  // edges of a face that are left
  Row n_parts_ = 0, crowded_ = kNone;
};

}  // namespace geodesic
