#include "paths/sheets.hpp"

#include "triangles/half_edges.hpp"

namespace geodesic {

namespace {

// The place of a vertex on a line whose hole has been closed.
constexpr Row kClosed = -2;

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
  Array<Row> edge_to(surface.n_vertices(), kNone);  // from the current vertex
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

// Boundary lines are closed, and what lies between two passes of a vertex is a hole of its own:
// where fans of a vertex are on several lines, or passes cross, it is not known which fans a hole
// joins.
void Sheets::fill_holes(const Surface& surface, DisjointSets& fans, double min_hole) {
  Array<Row> n_fans(surface.n_vertices(), 0);
  for (Row v = 0; v < surface.n_vertices(); ++v)
    for (const Index face : surface.around(v))
      if (const Index at = corner(surface, static_cast<Row>(face), v); fans.find(at) == at)
        ++n_fans[v];
  Array<Row> n_passes(surface.n_vertices(), 0), place(surface.n_vertices(), kNone);
  for (const std::vector<Pass>& line : boundary_lines(surface, fans)) {
    for (const Pass& pass : line) ++n_passes[pass.vertex];
    std::vector<Pass> open;  // passes of vertices that no hole is closed at
    const auto close = [&](std::size_t begin) {
      double length = 0;
      std::vector<Row> hole;
      Row unclear = kNone;
      for (std::size_t i = begin; i < open.size(); ++i) {
        hole.push_back(open[i].edge);
        length += edge(open[i].edge).length;
        if (n_passes[open[i].vertex] != n_fans[open[i].vertex]) unclear = open[i].vertex;
        place[open[i].vertex] = kClosed;
      }
      open.resize(begin);
      if (length >= min_hole) return;
      if (unclear == kNone)
        fill(surface, fans, hole);
      else
        unclear_ = unclear;
    };
    for (const Pass& pass : line) {
      if (place[pass.vertex] == kClosed) ++n_passes[pass.vertex];  // passes cross
      if (place[pass.vertex] >= 0) close(static_cast<std::size_t>(place[pass.vertex]));
      place[pass.vertex] = static_cast<Row>(open.size());
      open.push_back(pass);
    }
    close(0);
    for (const Pass& pass : line) n_passes[pass.vertex] = 0, place[pass.vertex] = kNone;
  }
}

std::vector<std::vector<Sheets::Pass>> Sheets::boundary_lines(const Surface& surface,
                                                              DisjointSets& fans) const {
  struct Rim {
    Row edges[2] = {kNone, kNone};
  };
  std::vector<Rim> rims(static_cast<std::size_t>(3 * surface.n_faces()));  // of fans
  const auto rim = [&](Row e, Row end) -> Rim& {
    return rims[static_cast<std::size_t>(fans.find(corner(surface, edge(e).faces[0], end)))];
  };
  for (Row e = 0; e < n_edges(); ++e) {
    if (edge(e).n_faces != 1) continue;
    for (const Row end : edge(e).ends) {
      Rim& at = rim(e, end);
      (at.edges[0] == kNone ? at.edges[0] : at.edges[1]) = e;
    }
  }
  std::vector<std::vector<Pass>> lines;
  std::vector<bool> is_known(edges_.size(), false);
  for (Row first = 0; first < n_edges(); ++first) {
    if (edge(first).n_faces != 1 || is_known[static_cast<std::size_t>(first)]) continue;
    std::vector<Pass> line{{edge(first).ends[0], first}};
    for (;;) {
      const Pass last = line.back();
      is_known[static_cast<std::size_t>(last.edge)] = true;
      const Row vertex = edge(last.edge).other_end(last.vertex);
      const Rim& at = rim(last.edge, vertex);
      const Row next = at.edges[at.edges[0] == last.edge ? 1 : 0];
      if (next == first) lines.push_back(line);
      if (next == kNone || is_known[static_cast<std::size_t>(next)]) break;
      line.push_back({vertex, next});
    }
  }
  return lines;
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
