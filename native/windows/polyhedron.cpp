#include "windows/polyhedron.hpp"

#include <cmath>
#include <numbers>
#include <tuple>

namespace geodesic {
namespace {

// Angle beyond 2π that rounding may make of a flat vertex.
constexpr double kAngleTolerance = 1e-10;

double distance(const double* a, const double* b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}  // namespace

Polyhedron::Polyhedron(std::span<const double> vertices, std::span<const Index> faces)
    : turns_(vertices.size() / 3, 0) {
  const Index n_half_edges = count(faces);
  half_edges_.reserve(n_half_edges);
  std::vector<Index> thirds;
  thirds.reserve(n_half_edges);
  for (Index s = 0; s < n_half_edges; ++s) {
    const Index face = s - s % 3, next = face + (s + 1) % 3, last = face + (s + 2) % 3;
    const Index tail = faces[s], head = faces[next], third = faces[last];
    const double* const at = vertices.data();
    const double length = distance(at + 3 * tail, at + 3 * head),
                 to_tail = distance(at + 3 * tail, at + 3 * third),
                 to_head = distance(at + 3 * head, at + 3 * third);
    const double beyond = length > 0 ? (to_tail - to_head) * ((to_tail + to_head) / length) : 0.0;
    const double x = (length + beyond) / 2;
    // Two roots, as a product of small lengths may be 0.
    const double y = std::sqrt(std::max(0.0, to_tail - x)) * std::sqrt(std::max(0.0, to_tail + x));
    half_edges_.push_back({tail, head, third, length, x, y, next, last});
    thirds.push_back(third);
  }
  const Index n_edges = number_edges();
  half_edges_of_ = sorted_by(edge_, n_edges);
  opposite_ = sorted_by(thirds, n_vertices());
  find_turns(n_edges);
}

Polyhedron::Lists Polyhedron::sorted_by(std::span<const Index> keys, Index n_keys) {
  Lists lists{std::vector<Index>(n_keys + 1, 0), std::vector<Index>(keys.size())};
  for (const Index key : keys) ++lists.starts[key + 1];
  for (Index i = 0; i < n_keys; ++i) lists.starts[i + 1] += lists.starts[i];
  std::vector<Index> next(lists.starts.begin(), lists.starts.end() - 1);
  for (Index i = 0; i < count(keys); ++i) lists.entries[next[keys[i]]++] = i;
  return lists;
}

Index Polyhedron::number_edges() {
  std::vector<std::tuple<Index, Index, Index>> ends;
  for (Index s = 0; s < count(std::span(half_edges_)); ++s) {
    const HalfEdge& half_edge = half_edges_[s];
    ends.emplace_back(std::min(half_edge.tail, half_edge.head),
                      std::max(half_edge.tail, half_edge.head), s);
  }
  std::ranges::sort(ends);
  edge_.resize(ends.size());
  Index n_edges = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const auto [low, high, s] = ends[i];
    const bool same = i > 0 && std::get<0>(ends[i - 1]) == low && std::get<1>(ends[i - 1]) == high;
    n_edges += !same;
    edge_[s] = n_edges - 1;
  }
  return n_edges;
}

void Polyhedron::find_turns(Index n_edges) {
  std::vector<double> angles(turns_.size(), 0.0);
  for (const HalfEdge& half_edge : half_edges_)
    angles[half_edge.tail] += std::atan2(half_edge.y, half_edge.x);
  for (std::size_t v = 0; v < angles.size(); ++v)
    turns_[v] = angles[v] > 2 * std::numbers::pi + kAngleTolerance;
  for (const HalfEdge& half_edge : half_edges_)
    if (half_edge.length == 0) turns_[half_edge.tail] = turns_[half_edge.head] = 1;
  for (Index edge = 0; edge < n_edges; ++edge) {
    const std::span<const Index> half_edges = half_edges_of_.at(edge);
    if (half_edges.size() != 2)
      turns_[half_edges_[half_edges[0]].tail] = turns_[half_edges_[half_edges[0]].head] = 1;
  }
  for (Index v = 0; v < n_vertices(); ++v) turns_[v] |= !is_one_fan(v);
}

// True if one comes from every face around a vertex to every other across edges at the vertex.
bool Polyhedron::is_one_fan(Index v) const {
  std::vector<Index> left(opposite(v).begin(), opposite(v).end()), reached;
  while (!left.empty()) {
    if (reached.empty() && std::ssize(left) < std::ssize(opposite(v))) return false;
    if (reached.empty()) {
      reached.push_back(left.back());
      left.pop_back();
    }
    const HalfEdge& half_edge = half_edges_[reached.back()];
    reached.pop_back();
    for (const Index at : {half_edge.next, half_edge.last})
      for (const Index other : beside(at)) {
        const Index face = other / 3;
        const auto found = std::ranges::find(left, face, [](Index s) { return s / 3; });
        if (found == left.end()) continue;
        reached.push_back(*found);
        left.erase(found);
      }
  }
  return true;
}

}  // namespace geodesic
