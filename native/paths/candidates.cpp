#include "paths/candidates.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace geodesic {
namespace {

// Paths over a vertex up to so many times as long as the shortest are straightened and compared:
// refined distances err by some per cent on coarse meshes.
constexpr double kMaxLengthRatio = 1.05;
// Such vertices that are tried, those of the shortest paths.
constexpr std::size_t kMaxCandidates = 12;

// Vertices over which a path is nearly the shortest, and shorter than beside them.
std::vector<Index> between(const Surface& surface, std::span<const double> height,
                           std::span<const double> back) {
  const auto total = [&](Index v) { return height[v] + back[v]; };
  double least = std::numeric_limits<double>::infinity();
  for (Index v = 0; v < surface.n_vertices(); ++v)
    if (!surface.around(v).empty()) least = std::min(least, total(v));
  std::vector<std::pair<double, Index>> found;
  for (Index v = 0; v < surface.n_vertices(); ++v) {
    if (surface.around(v).empty() || !(total(v) <= kMaxLengthRatio * least)) continue;
    const bool lowest = std::ranges::all_of(surface.around(v), [&](Index face) {
      const auto [p, q] = surface.others(face, v);
      return total(v) <= total(p) && total(v) <= total(q);
    });
    if (lowest) found.push_back({total(v), v});
  }
  std::ranges::sort(found);
  if (found.size() > kMaxCandidates) found.resize(kMaxCandidates);
  std::vector<Index> vertices;
  for (const auto& [_, vertex] : found) vertices.push_back(vertex);
  return vertices;
}

// Paths from a vertex to ends: down, and where none arrives along edges.
std::vector<Route> routes_of(const Surface& surface, std::span<const double> height,
                             std::span<const double> back, Index start,
                             std::span<const bool> is_end) {
  std::vector<Route> routes;
  Route first = descend(surface, height, start);
  if (is_end[first.stops.back()]) routes.push_back(std::move(first));
  std::vector<Index> seen;
  for (const Index face : surface.around(start)) {
    const auto [p, q] = surface.others(face, start);
    for (const Index neighbour : {p, q}) {
      const bool known = std::ranges::find(seen, neighbour) != seen.end();
      if (known || !(height[neighbour] < height[start])) continue;
      seen.push_back(neighbour);
      Route route = descend(surface, height, neighbour);
      if (!is_end[route.stops.back()]) continue;
      route.stops.insert(route.stops.begin(), start);
      route.strips.insert(route.strips.begin(), Strip{face});
      routes.push_back(std::move(route));
    }
  }
  for (const Index vertex : between(surface, height, back)) {
    if (vertex == start) continue;
    const Route down = descend(surface, height, vertex);
    Route route = descend(surface, back, vertex);
    if (!is_end[down.stops.back()] || route.stops.back() != start) continue;
    std::ranges::reverse(route.stops);
    std::ranges::reverse(route.strips);
    for (Strip& strip : route.strips) std::ranges::reverse(strip);
    route.stops.insert(route.stops.end(), down.stops.begin() + 1, down.stops.end());
    route.strips.insert(route.strips.end(), down.strips.begin(), down.strips.end());
    routes.push_back(std::move(route));
  }
  if (routes.empty()) routes.push_back(along_edges(surface, start, is_end));  // out of hollows
  return routes;
}

// A strip from one vertex to another.
struct Leg {
  Strip strip;
  Index first, last;
};

// The strips of a route joined around the vertices between them; more than one where the surface
// hangs together at a vertex only.
std::vector<Leg> joined(const Surface& surface, const Route& route) {
  std::vector<Leg> legs;
  for (std::size_t i = 0; i < route.strips.size(); ++i) {
    const Strip& strip = route.strips[i];
    const Index from = route.stops[i], to = route.stops[i + 1];
    Strip chain;
    if (i > 0) chain = surface.chain(legs.back().strip.back(), strip.front(), from);
    if (chain.empty()) {
      legs.push_back({strip, from, to});
      continue;
    }
    Strip& whole = legs.back().strip;
    whole.insert(whole.end(), chain.begin() + 1, chain.end());
    whole.insert(whole.end(), strip.begin() + 1, strip.end());
    legs.back().last = to;
  }
  return legs;
}

}  // namespace

std::vector<Crossing> best_path(const Surface& surface, std::span<const double> height,
                                std::span<const double> back, Index start,
                                std::span<const Index> ends) {
  Array<bool> is_end(surface.n_vertices(), false);
  for (const Index end : ends) is_end[end] = true;
  std::vector<Path> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Route& route : routes_of(surface, height, back, start, is_end)) {
    std::vector<Path> paths;
    double length = 0;
    for (const Leg& leg : joined(surface, route)) {
      paths.push_back(shortest_path(surface, leg.strip, leg.first, leg.last));
      length += paths.back().length;
    }
    if (paths.empty() || !(length < least)) continue;
    best = std::move(paths);
    least = length;
  }
  std::vector<Crossing> points;
  for (Path& path : best) {
    const std::vector<Crossing> part = crossings(surface, beside_cones(surface, std::move(path)));
    points.insert(points.end(), part.begin(), part.end());
  }
  return points;
}

Distinct distinct_triangles(std::span<const Index> elements) {
  std::vector<std::array<Index, 3>> all;
  for (Index e = 0; e < count(elements); e += 3) {
    std::array<Index, 3> corners{elements[e], elements[e + 1], elements[e + 2]};
    std::ranges::sort(corners);
    if (corners[0] < corners[1] && corners[1] < corners[2]) all.push_back(corners);
  }
  std::ranges::sort(all);
  Distinct result;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || all[i] != all[i - 1]) {
      result.triangles.insert(result.triangles.end(), all[i].begin(), all[i].end());
      result.stars.push_back(0);
    }
    ++result.stars.back();
  }
  return result;
}

}  // namespace geodesic
