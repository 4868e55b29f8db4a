// Edges and faces of a surface that is taken apart where it hangs together at a vertex only.
#pragma once

#include "paths/surface.hpp"

namespace geodesic {

// An edge between two vertices of the sheets, and its faces: the second is kNone at a boundary.
struct SheetEdge {
  Row ends[2], faces[2];
  Row n_faces;
  double length;

  Row other_end(Row end) const { return ends[0] == end ? ends[1] : ends[0]; }
  Row other_face(Row face) const { return faces[0] == face ? faces[1] : faces[0]; }
};

// A vertex of the surface has a copy for each of the fans of faces around it that share edges of
// two faces. Sheets of a surface without edges of three faces or more are manifolds.
class Sheets {
 public:
  explicit Sheets(const Surface& surface);

  Index n_vertices() const { return count(std::span(originals_)); }
  Index n_faces() const { return count(std::span(edges_of_)) / 3; }
  Index n_holes() const { return n_holes_; }
  Index n_edges() const { return count(std::span(edges_)); }
  const SheetEdge& edge(Row number) const { return edges_[static_cast<std::size_t>(number)]; }
  // The vertex of the surface.
  Row original(Row vertex) const { return originals_[static_cast<std::size_t>(vertex)]; }
  // The copies of a vertex of the surface, [first, last).
  std::pair<Row, Row> copies(Index original) const {
    return {first_copies_[original], first_copies_[original + 1]};
  }
  std::span<const Row> edges_at(Row vertex) const {
    return {at_.data() + starts_[vertex], at_.data() + starts_[vertex + 1]};
  }
  std::span<const Row, 3> edges_of(Row face) const {
    return std::span<const Row, 3>(edges_of_.data() + 3 * static_cast<std::size_t>(face), 3);
  }
  // The number of the closed line of boundary edges that has an edge; kNone inside.
  Row hole(Row edge) const { return holes_[edge]; }

 private:
  void join_edges(const Surface& surface);
  void number_copies(const Surface& surface);
  void list_edges();
  void find_holes();

  std::vector<SheetEdge> edges_;
  std::vector<Row> edges_of_, originals_;
  Array<Row> first_copies_, starts_, at_, holes_;
  Index n_holes_ = 0;
};

}  // namespace geodesic
