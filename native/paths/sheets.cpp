#include "paths/sheets.hpp"

#include "triangles/half_edges.hpp"

namespace geodesic {

namespace {

// The number of a corner of a face.
Index corner(const Surface& surface, Row face, Index vertex) {
  const Index* const c = surface.corners(face);
  return 3 * Index{face} + (c[0] == vertex ? 0 : c[1] == vertex ? 1 : 2);
}

}  // namespace

Sheets::Sheets(const Surface& surface, double min_hole)
    : edges_of_(static_cast<std::size_t>(3 * surface.n_faces())),
      first_copies_(surface.n_vertices() + 1) {
  for (Row first = 0; first <= 3 * surface.n_faces(); first += 3) face_starts_.push_back(first);
  join_edges(surface);
  DisjointSets fans(3 * surface.n_faces());  // of corners
  for (const SheetEdge& edge : edges_)
    if (edge.n_faces == 2)
      for (const Row end : edge.ends)
        fans.unite(corner(surface, edge.faces[0], end), corner(surface, edge.faces[1], end));
  if (min_hole > 0) fill_holes(surface, fans, min_hole);
  number_copies(surface, fans);
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

// Lines along the boundary are closed; what lies between two passes of a vertex is a hole of its
// own.
void Sheets::fill_holes(const Surface& surface, DisjointSets& fans, double min_hole) {
  struct Rim {
    Row edges[2] = {kNone, kNone};
  };
  std::vector<Rim> rims(static_cast<std::size_t>(3 * surface.n_faces()));  // of fans
  const auto rim = [&](Row e, Row end) -> Rim& {
    const Index at = fans.find(corner(surface, edges_[static_cast<std::size_t>(e)].faces[0], end));
    return rims[static_cast<std::size_t>(at)];
  };
  const auto n = static_cast<Row>(edges_.size());
  for (Row e = 0; e < n; ++e)
    if (const SheetEdge& edge = edges_[static_cast<std::size_t>(e)]; edge.n_faces == 1)
      for (const Row end : edge.ends) {
        Rim& at = rim(e, end);
        (at.edges[0] == kNone ? at.edges[0] : at.edges[1]) = e;
      }
  std::vector<std::vector<Row>> holes;
  std::vector<bool> is_known(edges_.size(), false);
  Array<Row> place(surface.n_vertices(), kNone);  // on the line at hand, in edges from its start
  for (Row first = 0; first < n; ++first) {
    if (edges_[static_cast<std::size_t>(first)].n_faces != 1) continue;
    std::vector<Row> line, passed{edges_[static_cast<std::size_t>(first)].ends[0]};
    place[passed.front()] = 0;
    for (Row e = first; e != kNone && !is_known[static_cast<std::size_t>(e)];) {
      is_known[static_cast<std::size_t>(e)] = true;
      line.push_back(e);
      const Row vertex = edges_[static_cast<std::size_t>(e)].other_end(passed.back());
      const Rim& next = rim(e, vertex);
      e = next.edges[next.edges[0] == e ? 1 : 0];
      if (place[vertex] == kNone) {
        place[vertex] = static_cast<Row>(line.size());
        passed.push_back(vertex);
        continue;
      }
      const auto begin = static_cast<std::size_t>(place[vertex]);
      holes.emplace_back(line.begin() + place[vertex], line.end());
      line.resize(begin);
      for (std::size_t i = begin + 1; i < passed.size(); ++i) place[passed[i]] = kNone;
      passed.resize(begin + 1);
    }
    for (const Row vertex : passed) place[vertex] = kNone;
  }
  for (const std::vector<Row>& hole : holes) {
    double length = 0;
    for (const Row e : hole) length += edges_[static_cast<std::size_t>(e)].length;
    if (length < min_hole) fill(surface, fans, hole);
  }
}

void Sheets::fill(const Surface& surface, DisjointSets& fans, std::span<const Row> hole) {
  const auto face = static_cast<Row>(n_faces());
  for (std::size_t i = 0; i < hole.size(); ++i) {
    SheetEdge& edge = edges_[static_cast<std::size_t>(hole[i])];
    const SheetEdge& next = edges_[static_cast<std::size_t>(hole[(i + 1) % hole.size()])];
    edge.faces[1] = face, edge.n_faces = 2;
    for (const Row end : edge.ends)
      if (end == next.ends[0] || end == next.ends[1])
        fans.unite(corner(surface, edge.faces[0], end), corner(surface, next.faces[0], end));
  }
  edges_of_.insert(edges_of_.end(), hole.begin(), hole.end());
  face_starts_.push_back(static_cast<Row>(edges_of_.size()));
}

void Sheets::number_copies(const Surface& surface, DisjointSets& fans) {
  Array<Row> copy_of(3 * surface.n_faces(), kNone);
  for (Row v = 0; v < surface.n_vertices(); ++v) {
    first_copies_[v] = static_cast<Row>(originals_.size());
    for (const Index face : surface.around(v)) {
      Row& copy = copy_of[fans.find(corner(surface, static_cast<Row>(face), v))];
      if (copy != kNone) continue;
      copy = static_cast<Row>(originals_.size());
      originals_.push_back(v);
    }
  }
  first_copies_[surface.n_vertices()] = static_cast<Row>(originals_.size());
  for (SheetEdge& edge : edges_)
    for (Row& end : edge.ends) end = copy_of[fans.find(corner(surface, edge.faces[0], end))];
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
