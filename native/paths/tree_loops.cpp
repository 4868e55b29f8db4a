#include "paths/tree_loops.hpp"

#include <functional>
#include <limits>
#include <map>
#include <queue>

#include "core/disjoint_sets.hpp"

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// States of edges: of the tree or taken away; not so; not so, and its class is known.
constexpr std::int8_t kGone = 0, kLeft = 1, kKnown = 2;

}  // namespace

TreeLoops::TreeLoops(const Sheets& sheets)
    : sheets_(sheets),
      distance_(sheets.n_vertices(), kInfinity),
      before_(sheets.n_vertices(), kNone),
      up_(sheets.n_vertices(), kNone),
      part_(sheets.n_vertices(), kNone),
      state_(sheets.n_edges(), kGone),
      n_left_(sheets.n_faces(), 0) {}

void TreeLoops::set_root(Index original) {
  grow(original);
  list_edges();
  join_branches();
  take_away();
}

void TreeLoops::grow(Index original) {
  for (const Row v : order_) distance_[v] = kInfinity, part_[v] = kNone;
  order_.clear();
  n_parts_ = 0;
  using Reached = std::pair<double, Row>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> front;
  const auto reach = [&](Row v, double distance, Row before, Row edge) {
    distance_[v] = distance, before_[v] = before, up_[v] = edge;
    front.push({distance, v});
  };
  const auto [first, last] = sheets_.copies(original);
  for (Row copy = first; copy < last; ++copy) reach(copy, 0.0, kNone, kNone);
  while (!front.empty()) {
    const auto [distance, v] = front.top();
    front.pop();
    if (part_[v] != kNone) continue;
    part_[v] = up_[v] == kNone ? n_parts_++ : part_[before_[v]];
    order_.push_back(v);
    const auto [one, end] = sheets_.copies(sheets_.original(v));
    for (Row copy = one; copy < end; ++copy)
      if (part_[copy] == kNone && up_[v] != kNone) reach(copy, distance, v, kNone);
    for (const Row e : sheets_.edges_at(v)) {
      const SheetEdge& edge = sheets_.edge(e);
      const Row other = edge.other_end(v);
      if (part_[other] == kNone && distance + edge.length < distance_[other])
        reach(other, distance + edge.length, v, e);
    }
  }
}

void TreeLoops::list_edges() {
  edges_.clear();
  crowded_ = kNone;
  for (const Row v : order_) {
    for (const Row e : sheets_.edges_at(v)) {
      const SheetEdge& edge = sheets_.edge(e);
      if (edge.ends[0] != v) continue;
      edges_.push_back(e);
      state_[e] = up_[edge.ends[0]] == e || up_[edge.ends[1]] == e ? kGone : kLeft;
      if (edge.n_faces > 2) crowded_ = e;
    }
  }
}

void TreeLoops::join_branches() {
  joins_.clear();
  if (n_parts_ == 1) return;
  DisjointSets parts(n_parts_);
  for (const Row e : edges_) {
    const SheetEdge& edge = sheets_.edge(e);
    if (!parts.unite(part_[edge.ends[0]], part_[edge.ends[1]])) continue;
    state_[e] = kGone;
    joins_.push_back(e);
  }
}

void TreeLoops::take_away() {
  const auto faces = [&](Row e) -> std::span<const Row> {
    const SheetEdge& edge = sheets_.edge(e);
    return {edge.faces, edge.faces[1] == kNone ? std::size_t{1} : std::size_t{2}};
  };
  for (const Row e : edges_)
    for (const Row face : faces(e)) n_left_[face] = 0;
  for (const Row e : edges_)
    if (state_[e] == kLeft)
      for (const Row face : faces(e)) ++n_left_[face];
  std::vector<Row> ends;  // faces that are beside one edge only
  for (const Row e : edges_)
    if (state_[e] == kLeft)
      for (const Row face : faces(e))
        if (n_left_[face] == 1) ends.push_back(face);
  while (!ends.empty()) {
    const Row face = ends.back();
    ends.pop_back();
    if (n_left_[face] != 1) continue;
    for (const Row e : sheets_.edges_of(face)) {
      if (state_[e] == kGone) continue;
      state_[e] = kGone;
      for (const Row beside : faces(e))
        if (--n_left_[beside] == 1) ends.push_back(beside);
    }
  }
}

double TreeLoops::length(Row e) const {
  const SheetEdge& edge = sheets_.edge(e);
  return distance_[edge.ends[0]] + edge.length + distance_[edge.ends[1]];
}

std::pair<Row, Row> TreeLoops::parts(Row e) const {
  const SheetEdge& edge = sheets_.edge(e);
  return std::minmax(part_[edge.ends[0]], part_[edge.ends[1]]);
}

std::vector<Closing> TreeLoops::class_of(Row first) {
  const std::pair<Row, Row> own = parts(first);
  std::vector<Closing> found{{length(first), first}};
  state_[first] = kKnown;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const Row face : sheets_.edge(found[i].edge).faces) {
      if (face == kNone || n_left_[face] != 2) continue;
      for (const Row e : sheets_.edges_of(face)) {
        if (state_[e] != kLeft || parts(e) != own) continue;
        state_[e] = kKnown;
        found.push_back({length(e), e});
      }
    }
  }
  return found;
}

std::vector<Closing> TreeLoops::shortest_of_classes(double spread) {
  std::vector<Closing> shortest;
  const auto add = [&](std::span<const Closing> loops) {
    const double least = std::ranges::min(loops, {}, &Closing::length).length;
    for (const Closing& loop : loops)
      if (loop.length <= (1 + spread) * least) shortest.push_back(loop);
  };
  for (const Row e : edges_)
    if (state_[e] == kLeft) add(class_of(e));
  if (n_parts_ > 1) {
    // Loops through vertices at which sheets meet do not shrink, be their edge taken away or not.
    std::map<std::pair<Row, Row>, std::vector<Closing>> of_parts;
    for (const Row e : edges_)
      if (const auto [one, other] = parts(e); state_[e] == kGone && one != other)
        of_parts[{one, other}].push_back({length(e), e});
    for (const auto& [_, loops] : of_parts) add(loops);
  }
  std::ranges::sort(shortest, {},
                    [](const Closing& loop) { return std::pair(loop.length, loop.edge); });
  return shortest;
}

std::vector<Index> TreeLoops::path(Row vertex) const {
  std::vector<Index> vertices;
  for (Row v = vertex; v != kNone; v = before_[v])
    if (const Index original = sheets_.original(v); vertices.empty() || vertices.back() != original)
      vertices.push_back(original);
  return vertices;
}

std::vector<Index> TreeLoops::loop(Row e) const {
  const SheetEdge& edge = sheets_.edge(e);
  std::vector<Index> there = path(edge.ends[0]);
  std::ranges::reverse(there);
  const std::vector<Index> back = path(edge.ends[1]);
  there.insert(there.end(), back.begin(), back.end());
  return there;
}

std::vector<Row> TreeLoops::cut() {
  std::vector<Row> ends;
  const auto add = [&](Row e) {
    for (const Row end : sheets_.edge(e).ends) ends.push_back(end);
  };
  for (const Row e : joins_) add(e);
  // The shortest loops of as many edges as keep the faces, with the holes filled, connected.
  std::vector<Closing> left;
  for (const Row e : edges_)
    if (state_[e] != kGone) left.push_back({length(e), e});
  std::ranges::sort(left, [](const Closing& one, const Closing& other) {
    return std::pair(one.length, one.edge) > std::pair(other.length, other.edge);
  });
  DisjointSets filled(sheets_.n_faces() + sheets_.n_holes());
  std::vector<bool> is_met(static_cast<std::size_t>(sheets_.n_holes()), false);
  for (const auto& [_, e] : left) {
    const SheetEdge& edge = sheets_.edge(e);
    const Index beyond =
        edge.faces[1] == kNone ? sheets_.n_faces() + sheets_.hole(e) : Index{edge.faces[1]};
    if (!filled.unite(edge.faces[0], beyond)) add(e);
  }
  for (const Row v : order_) {  // the nearest vertex of each hole
    for (const Row e : sheets_.edges_at(v)) {
      const Row hole = sheets_.hole(e);
      if (hole == kNone || is_met[static_cast<std::size_t>(hole)]) continue;
      is_met[static_cast<std::size_t>(hole)] = true;
      ends.push_back(v);
    }
  }
  std::vector<bool> is_on(static_cast<std::size_t>(sheets_.n_vertices()), false);
  std::vector<Row> vertices;
  for (const Row end : ends) {
    for (Row v = end; v != kNone && !is_on[static_cast<std::size_t>(v)]; v = before_[v]) {
      is_on[static_cast<std::size_t>(v)] = true;
      vertices.push_back(v);
    }
  }
  return vertices;
}

}  // namespace geodesic
