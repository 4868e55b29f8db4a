#include "bounds/bounds.hpp"

#include <cmath>
#include <queue>
#include <utility>

namespace geodesic {
namespace {

// Share of a distance by which rounding may make it longer than the sum of two others.
constexpr double kRounding = 1e-13;

double square_of_length(const double* a, const double* b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

class Edges {
 public:
  Edges(const Surface& surface, std::span<double> distances)
      : vertices_(surface.vertices), triangles_(surface.triangles), distances_(distances) {}

  // Lower what lies behind edges that are too short; return whether there were any.
  bool find() {
    for (std::size_t i = 0; i < triangles_.size(); i += 3) {
      const Index* const corners = &triangles_[i];
      compare(corners[0], corners[1]);
      compare(corners[1], corners[2]);
      compare(corners[2], corners[0]);
    }
    return !fronts_.empty();
  }

  // Carry that on along edges.
  void settle() {
    gather_rings();
    while (!fronts_.empty()) {
      const auto [distance, vertex] = fronts_.top();
      fronts_.pop();
      if (distance > distances_[vertex]) continue;  // lowered again since
      for (Index i = starts_[vertex]; i < starts_[vertex + 1]; ++i) compare(vertex, ring_[i]);
    }
  }

 private:
  using Front = std::pair<double, Index>;

  // What the edge from a to b allows; nothing, as a rule.
  void compare(Index a, Index b) {
    const double gap = distances_[a] - distances_[b];
    const double square = square_of_length(&vertices_[3 * a], &vertices_[3 * b]);
    if (gap * gap > square) [[unlikely]]
      lower(gap > 0 ? b : a, gap > 0 ? a : b, std::sqrt(square));
  }

  void lower(Index near, Index far, double edge) {
    const double most = distances_[near] + edge, now = distances_[far];
    if (now - most <= kRounding * now || !(now < std::numeric_limits<double>::infinity())) return;
    distances_[far] = most;
    fronts_.emplace(most, far);
  }

  // The other two corners of every triangle around a vertex.
  void gather_rings() {
    const Index n_vertices = count(distances_);
    starts_ = Array<Index>(n_vertices + 1, Index{0});
    for (const Index vertex : triangles_) starts_[vertex + 1] += 2;
    for (Index v = 0; v < n_vertices; ++v) starts_[v + 1] += starts_[v];
    ring_ = Array<Index>(starts_[n_vertices]);
    Array<Index> next(n_vertices);
    std::copy_n(starts_.begin(), n_vertices, next.begin());
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::size_t first = i - i % 3;
      for (const std::size_t step : {std::size_t{1}, std::size_t{2}})
        ring_[next[triangles_[i]]++] = triangles_[first + (i - first + step) % 3];
    }
  }

  std::span<const double> vertices_;
  std::span<const Index> triangles_;
  std::span<double> distances_;
  std::priority_queue<Front, std::vector<Front>, std::greater<>> fronts_;
  Array<Index> starts_, ring_;
};

}  // namespace

void raise_to_straight_line(std::span<const double> vertices, const Starts& starts,
                            std::span<double> distances) {
  Places places(starts);
  for (Index v = 0; v < count(distances); ++v) {
    double& distance = distances[v];
    const double* const vertex = &vertices[3 * v];
    if (places.last_reads_at_most(distance, vertex)) continue;
    distance = std::max(distance, places.straight(vertex, distance));
  }
}

void lower_to_edges(const Surface& surface, std::span<double> distances) {
  Edges edges(surface, distances);
  if (edges.find()) edges.settle();
}

}  // namespace geodesic
