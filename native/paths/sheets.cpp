#include "paths/sheets.hpp"

#include "core/disjoint_sets.hpp"
#include "triangles/half_edges.hpp"

namespace geodesic {

Sheets::Sheets(const Surface& surface)
    : edges_of_(static_cast<std::size_t>(3 * surface.n_faces())),
      first_copies_(surface.n_vertices() + 1) {
  join_edges(surface);
  number_copies(surface);
  list_edges();
  find_holes();
}

void Sheets::join_edges(const Surface& surface) {
  const HalfEdges sorted = sorted_half_edges(surface.faces(), surface.n_vertices());
  Array<Row> edge_to(surface.n_vertices(), kNone);  // from the vertex at hand
  for (Row v = 0; v < sorted.n_vertices(); ++v) {
    const auto first = static_cast<Row>(edges_.size());
    for (Row place = sorted.starts[v]; place < sorted.starts[v + 1]; ++place) {
      const auto [head, signed_half] = sorted.halves[place];
      const Row half = number(signed_half), face = half / 3;
      Row& edge = edge_to[head];
      if (edge < first) {
        edge = static_cast<Row>(edges_.size());
        edges_.push_back({{v, head}, {face, kNone}, 0, surface.length(v, head)});
      }
      SheetEdge& found = edges_[static_cast<std::size_t>(edge)];
      if (++found.n_faces == 2) found.faces[1] = face;
      edges_of_[static_cast<std::size_t>(half)] = edge;
    }
  }
}

void Sheets::number_copies(const Surface& surface) {
  const auto corner = [&](Row face, Row vertex) {
    const Index* const c = surface.corners(face);
    return 3 * face + (c[0] == vertex ? 0 : c[1] == vertex ? 1 : 2);
  };
  DisjointSets fans(3 * surface.n_faces());  // of corners
  for (const SheetEdge& edge : edges_)
    if (edge.n_faces == 2)
      for (const Row end : edge.ends)
        fans.unite(corner(edge.faces[0], end), corner(edge.faces[1], end));
  Array<Row> copy_of(3 * surface.n_faces(), kNone);
  for (Row v = 0; v < surface.n_vertices(); ++v) {
    first_copies_[v] = static_cast<Row>(originals_.size());
    for (const Index face : surface.around(v)) {
      Row& copy = copy_of[fans.find(corner(static_cast<Row>(face), v))];
      if (copy != kNone) continue;
      copy = static_cast<Row>(originals_.size());
      originals_.push_back(v);
    }
  }
  first_copies_[surface.n_vertices()] = static_cast<Row>(originals_.size());
  for (SheetEdge& edge : edges_)
    for (Row& end : edge.ends) end = copy_of[fans.find(corner(edge.faces[0], end))];
}

void Sheets::list_edges() {
  starts_ = Array<Row>(n_vertices() + 1, 0);
  at_ = Array<Row>(2 * count(std::span(edges_)));
  for (const SheetEdge& edge : edges_)
    for (const Row end : edge.ends) ++starts_[end + 1];
  for (Index v = 0; v < n_vertices(); ++v) starts_[v + 1] += starts_[v];
  Array<Row> free(n_vertices());
  std::copy_n(starts_.begin(), n_vertices(), free.begin());
  for (std::size_t e = 0; e < edges_.size(); ++e)
    for (const Row end : edges_[e].ends) at_[free[end]++] = static_cast<Row>(e);
}

void Sheets::find_holes() {
  const Index n = count(std::span(edges_));
  DisjointSets lines(n_vertices());
  holes_ = Array<Row>(n, kNone);
  for (const SheetEdge& edge : edges_)
    if (edge.n_faces == 1) lines.unite(edge.ends[0], edge.ends[1]);
  Array<Row> numbers(n_vertices(), kNone);
  for (Row e = 0; e < n; ++e) {
    const SheetEdge& edge = edges_[static_cast<std::size_t>(e)];
    if (edge.n_faces != 1) continue;
    Row& number = numbers[lines.find(edge.ends[0])];
    if (number == kNone) number = static_cast<Row>(n_holes_++);
    holes_[e] = number;
  }
}

}  // namespace geodesic
