#include "bounds/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace geodesic {
namespace {

// Share of a distance by which rounding may make it longer than the sum of two others.
constexpr double kRelativeRounding = 1e-13;

// A number of single precision that is less than a length, be that beyond their range.
float below(double length) {
  using Single = std::numeric_limits<float>;
  const double less = length * (1 - 1e-6);  // by more than it is rounded
  return less < Single::min() ? 0.0f : static_cast<float>(std::min<double>(less, Single::max()));
}

double square_of_length(const double* a, const double* b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

void raise(SourceTree& places, const double* vertex, double& distance) {
  if (places.last_reads_at_most(distance, vertex)) return;
  distance = std::max(distance, places.straight(vertex, distance));
}

// A search along edges from those that are too short.
class Search {
 public:
  Search(std::span<const double> vertices, const Pattern& edges, std::span<double> distances)
      : vertices_(vertices), edges_(edges), distances_(distances) {}

  // Lower the larger of the distances of a and b to what the edge between them allows.
  void compare(Index a, Index b) {
    const double gap = distances_[a] - distances_[b];
    const double square = square_of_length(&vertices_[3 * a], &vertices_[3 * b]);
    if (gap * gap > square) lower(gap > 0 ? b : a, gap > 0 ? a : b, std::sqrt(square));
  }

  // Carry on what was lowered.
  void settle() {
    while (!fronts_.empty()) {
      const auto [distance, vertex] = fronts_.top();
      fronts_.pop();
      if (distance > distances_[vertex]) continue;  // lowered again since
      for (Row i = edges_.indptr[vertex]; i < edges_.indptr[vertex + 1]; ++i)
        compare(vertex, edges_.indices[i]);
    }
  }

 private:
  using Front = std::pair<double, Index>;

  void lower(Index near, Index far, double edge) {
    const double most = distances_[near] + edge, now = distances_[far];
    if (now - most <= kRelativeRounding * now || !(now < std::numeric_limits<double>::infinity()))
      return;
    distances_[far] = most;
    fronts_.emplace(most, far);
  }

  std::span<const double> vertices_;
  Pattern edges_;
  std::span<double> distances_;
  std::priority_queue<Front, std::vector<Front>, std::greater<>> fronts_;
};

}  // namespace

Matrix edges_of(std::span<const Index> triangles, Index n_vertices) {
  Matrix rings{Array<Row>(n_vertices + 1, 0), Array<Row>(2 * count(triangles)), {}};
  Row *const starts = rings.indptr.data(), *const ring = rings.indices.data();
  for (const Index vertex : triangles) starts[vertex + 1] += 2;
  for (Index v = 0; v < n_vertices; ++v) starts[v + 1] += starts[v];
  Array<Row> next(n_vertices);
  std::copy_n(starts, n_vertices, next.begin());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::size_t step : {std::size_t{1}, std::size_t{2}})
      ring[next[triangles[i]]++] = static_cast<Row>(triangles[i - i % 3 + (i + step) % 3]);
  Row kept = 0;  // each neighbour is there for both of its triangles
  for (Index v = 0; v < n_vertices; ++v) {
    Row *const begin = ring + std::exchange(starts[v], kept), *const end = ring + next[v];
    std::sort(begin, end);
    kept += static_cast<Row>(std::unique_copy(begin, end, ring + kept) - (ring + kept));
  }
  starts[n_vertices] = kept;
  rings.indices.shorten(kept);
  return rings;
}

void raise_to_straight_line(std::span<const double> vertices, const SourceValues& starts,
                            std::span<double> distances) {
  SourceTree places(starts);
  for (Index v = 0; v < count(distances); ++v) raise(places, &vertices[3 * v], distances[v]);
}

void raise_to_straight_line(std::span<const double> vertices, std::span<const Index> near,
                            const SourceValues& starts, std::span<double> distances) {
  SourceTree places(starts);
  for (std::size_t i = 0; i < near.size(); ++i) raise(places, &vertices[3 * near[i]], distances[i]);
}

EdgeBounds::EdgeBounds(std::span<const double> vertices, const Pattern& edges)
    : vertices_(vertices), edges_(edges) {
  Index size = 0;
  for (Index v = 0; v < edges.size(); ++v)
    for (Row i = edges.indptr[v]; i < edges.indptr[v + 1]; ++i) size += edges.indices[i] > v;
  spans_ = {Array<Row>(size), Array<Row>(size), Array<float>(size)};
  Index k = 0;
  for (Index v = 0; v < edges.size(); ++v) {
    for (Row i = edges.indptr[v + 1]; i-- > edges.indptr[v] && edges.indices[i] > v; ++k) {
      const Row head = edges.indices[i];
      spans_.tails[k] = static_cast<Row>(v);
      spans_.heads[k] = head;
      spans_.lengths[k] = below(std::sqrt(square_of_length(&vertices[3 * v], &vertices[3 * head])));
    }
  }
}

void EdgeBounds::lower(std::span<double> distances) const {
  Search search(vertices_, edges_, distances);
  const Row *const tails = spans_.tails.data(), *const heads = spans_.heads.data();
  const float* const lengths = spans_.lengths.data();
  for (Index k = 0; k < spans_.tails.size(); ++k) {
    const double gap = distances[tails[k]] - distances[heads[k]];
    if (std::abs(gap) > lengths[k]) [[unlikely]]
      search.compare(tails[k], heads[k]);
  }
  search.settle();
}

bool EdgeBounds::lower_near(std::span<const Index> near, double limit,
                            std::span<double> distances) const {
  Search search(vertices_, edges_, distances);
  for (const Index v : near)  // in the same order as above
    for (Row i = edges_.indptr[v + 1]; i-- > edges_.indptr[v] && edges_.indices[i] > v;)
      search.compare(v, edges_.indices[i]);
  search.settle();
  for (const Index v : near) {
    if (!(distances[v] <= limit)) continue;
    for (Row i = edges_.indptr[v]; i < edges_.indptr[v + 1]; ++i) {
      const Index w = edges_.indices[i];
      if (std::isfinite(distances[w])) continue;
      const double square = square_of_length(&vertices_[3 * v], &vertices_[3 * w]);
      if (distances[v] + std::sqrt(square) <= limit) return false;
    }
  }
  return true;
}

}  // namespace geodesic
