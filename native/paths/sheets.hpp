// Edges and faces of a surface that is taken apart where it hangs together at a vertex only.
#pragma once

#include "core/disjoint_sets.hpp"
#include "paths/surface.hpp"

namespace geodesic {

// An edge between two vertices of the sheets, and its faces: the second is kNone at a hole.
struct SheetEdge {
  Row ends[2], faces[2];
  Row n_faces;
  double length;

  Row other_end(Row end) const { return ends[0] == end ? ends[1] : ends[0]; }
};

// A vertex of the surface has a copy for each of the fans of faces around it that share edges of
// two faces. Sheets of a surface without edges of three faces or more are manifolds.
class Sheets {
 public:
  // Holes whose boundary is shorter than `min_hole` are filled, each with one more face.
  Sheets(const Surface& surface, double min_hole);

  Index n_vertices() const { return count(std::span(originals_)); }
  Index n_faces() const { return count(std::span(face_starts_)) - 1; }
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
  std::span<const Row> edges_of(Row face) const {
    const auto f = static_cast<std::size_t>(face);
    return {edges_of_.data() + face_starts_[f], edges_of_.data() + face_starts_[f + 1]};
  }
  // A vertex at which holes that are to be filled meet in such a way that it is not known what to
  // join; kNone otherwise.
  Row unclear() const { return unclear_; }
  // The number of the closed line of boundary edges that has an edge; kNone inside.
  Row hole(Row edge) const { return holes_[edge]; }

 private:
  // A vertex on a boundary line, and the edge after it.
  struct Pass {
    Row vertex, edge;
  };

  void join_edges(const Surface& surface);
  void fill_holes(const Surface& surface, DisjointSets& fans, double min_hole);
  std::vector<std::vector<Pass>> boundary_lines(const Surface& surface, DisjointSets& fans) const;
  void fill(const Surface& surface, DisjointSets& fans, std::span<const Row> edges);
  void number_copies(const Surface& surface, DisjointSets& fans);
  void list_edges();
  void find_holes();

  std::vector<SheetEdge> edges_;
  std::vector<Row> edges_of_, face_starts_, originals_;
  Array<Row> first_copies_, starts_, at_, holes_;
  Index n_holes_ = 0;
  Row unclear_ = kNone;
};

}  // namespace geodesic
