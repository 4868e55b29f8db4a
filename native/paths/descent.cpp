#include "paths/descent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace geodesic {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Share of an edge within which a point of it counts as its end.
constexpr double kVertexTolerance = 1e-9;

constexpr Index kNowhere = -1;

class Walk {
 public:
  Walk(const Surface& surface, std::span<const double> height)
      : surface_(surface), height_(height) {}

  // Go down until the next vertex, add the faces passed, and return it; kNowhere where nothing is
  // lower.
  Index from(Index vertex, Strip& strip) const {
    double steepest = 0, share = -1;
    Index through = kNowhere, corner = kNowhere;
    for (const Index face : surface_.around(vertex)) {
      const auto [p, q] = surface_.others(face, vertex);
      for (const Index end : {p, q}) {
        const double length = surface_.length(vertex, end), drop = height_[vertex] - height_[end];
        const double slope = length > 0 ? drop / length : drop > 0 ? kInfinite : drop;
        if (slope > steepest) steepest = slope, through = face, corner = end, share = -1;
      }
      double down[3];
      if (!surface_.descent({vertex, p, q}, height_, down) || !(down[1] > 0 && down[2] > 0))
        continue;
      const double slope = std::sqrt(drop_along(down, {vertex, p, q}));
      if (slope >= steepest)
        steepest = slope, through = face, corner = p, share = down[2] / (down[1] + down[2]);
    }
    if (through == kNowhere) return kNowhere;
    strip.push_back(through);
    const Index next =
        share < 0 ? corner : across(corner, surface_.third(through, vertex, corner), share, strip);
    return height_[next] < height_[vertex] ? next : kNowhere;  // rounding must not lead in a circle
  }

 private:
  double drop_along(const double (&down)[3], const Index (&corners)[3]) const {
    return down[1] * (height_[corners[0]] - height_[corners[1]]) +
           down[2] * (height_[corners[0]] - height_[corners[2]]);
  }

  // Go on from a point of an edge (a, b) of the last face of a strip until a vertex.
  Index across(Index a, Index b, double share, Strip& strip) const {
    for (Index steps = 0; steps < 4 * surface_.n_faces(); ++steps) {
      if (share < kVertexTolerance) return a;
      if (share > 1 - kVertexTolerance) return b;
      double steepest = 0, rates[3] = {0, 0, 0};
      Index through = kNowhere, apex = kNowhere;
      for (const Index beside : surface_.around(a)) {
        if (beside == strip.back() || !surface_.has(beside, b)) continue;
        const Index c = surface_.third(beside, a, b);
        double down[3];
        if (!surface_.descent({a, b, c}, height_, down) || !(down[2] > 0)) continue;
        const double slope = drop_along(down, {a, b, c});
        if (through != kNowhere && !(slope > steepest)) continue;
        steepest = slope, through = beside, apex = c;
        std::copy_n(down, 3, rates);
      }
      if (through == kNowhere) break;
      strip.push_back(through);
      // Barycentric weights (1 - share, share, 0) change at these rates; one of the first two
      // reaches 0 first, and the path leaves through the edge opposite.
      const double to_b = rates[0] < 0 ? (1 - share) / -rates[0] : kInfinite;
      const double to_a = rates[1] < 0 ? share / -rates[1] : kInfinite;
      share = std::clamp(std::min(to_a, to_b) * rates[2], 0.0, 1.0);
      if (to_b <= to_a) a = b;
      b = apex;
    }
    return height_[a] < height_[b] ? a : b;
  }

  const Surface& surface_;
  std::span<const double> height_;
};

}  // namespace

Route descend(const Surface& surface, std::span<const double> height, Index start) {
  const Walk walk(surface, height);
  Route route{{start}, {}};
  for (;;) {
    Strip strip;
    const Index next = walk.from(route.stops.back(), strip);
    if (next == kNowhere) return route;
    route.stops.push_back(next);
    route.strips.push_back(std::move(strip));
  }
}

Route along_edges(const Surface& surface, Index start, std::span<const bool> is_end) {
  struct Reached {
    double distance;
    Index vertex;
    bool operator<(const Reached& other) const { return distance > other.distance; }  // least first
  };
  std::vector<double> distance(surface.n_vertices(), kInfinite);
  std::vector<Index> before(surface.n_vertices(), kNowhere);
  std::priority_queue<Reached> queue;
  distance[start] = 0;
  queue.push({0, start});
  while (!queue.empty()) {
    const Reached at = queue.top();
    queue.pop();
    if (at.distance > distance[at.vertex]) continue;
    if (is_end[at.vertex]) {
      Route route{{at.vertex}, {}};
      for (Index v = at.vertex; v != start; v = before[v]) {
        route.strips.push_back({surface.at_edge(v, before[v]).front()});
        route.stops.push_back(before[v]);
      }
      std::ranges::reverse(route.stops);
      std::ranges::reverse(route.strips);
      return route;
    }
    for (const Index face : surface.around(at.vertex)) {
      const auto [p, q] = surface.others(face, at.vertex);
      for (const Index end : {p, q}) {
        const double there = at.distance + surface.length(at.vertex, end);
        if (!(there < distance[end])) continue;
        distance[end] = there, before[end] = at.vertex;
        queue.push({there, end});
      }
    }
  }
  return {};
}

}  // namespace geodesic
