#include "paths/chains.hpp"

#include <algorithm>
#include <limits>

#include "paths/loops.hpp"
#include "paths/turns.hpp"

namespace geodesic {
namespace {

// A strip from one vertex to another.
struct Leg {
  Strip strip;
  Index first, last;
};

// The faces around a vertex from one edge to another, those of the least angle together; none where
// they do not hang together there.
Strip fan(const Surface& surface, Index vertex, Index from, Index to) {
  struct Spoke {
    Index end;
    double angle;
    std::size_t before;
    Index face;
    bool is_done;
  };
  std::vector<Spoke> spokes{{from, 0.0, 0, 0, false}};
  for (;;) {
    std::size_t least = spokes.size();
    for (std::size_t i = 0; i < spokes.size(); ++i)
      if (!spokes[i].is_done && (least == spokes.size() || spokes[i].angle < spokes[least].angle))
        least = i;
    if (least == spokes.size()) return {};
    if (spokes[least].end == to) {
      Strip faces;
      for (std::size_t i = least; i != 0; i = spokes[i].before) faces.push_back(spokes[i].face);
      std::ranges::reverse(faces);
      return faces;
    }
    spokes[least].is_done = true;
    for (const Index face : surface.at_edge(vertex, spokes[least].end)) {
      const Index end = surface.third(face, vertex, spokes[least].end);
      const double angle = spokes[least].angle + surface.angle(face, vertex);
      const auto known = std::ranges::find(spokes, end, &Spoke::end);
      if (known == spokes.end())
        spokes.push_back({end, angle, least, face, false});
      else if (!known->is_done && angle < known->angle)
        known->angle = angle, known->before = least, known->face = face;
    }
  }
}

// The strips beside a chain; more than one where the surface hangs together at a vertex only.
std::vector<Leg> legs_of(const Surface& surface, const Chain& chain) {
  std::vector<Leg> legs;
  Strip strip;
  Index first = chain.front();
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const Strip faces =
        i + 1 < chain.size() ? fan(surface, chain[i], chain[i - 1], chain[i + 1]) : Strip{};
    strip.insert(strip.end(), faces.begin(), faces.end());
    if (!faces.empty()) continue;
    if (strip.empty()) strip.push_back(surface.at_edge(chain[i - 1], chain[i]).front());
    legs.push_back({std::move(strip), first, chain[i]});
    strip.clear();
    first = chain[i];
  }
  return legs;
}

void append(std::vector<Crossing>& points, const std::vector<Crossing>& more) {
  points.insert(points.end(), more.begin(), more.end());
}

}  // namespace

Line pulled_along(const Surface& surface, const Chain& chain, bool is_held) {
  Line line;
  for (const Leg& leg : legs_of(surface, chain)) {
    Path path = shortest_path(surface, leg.strip, leg.first, leg.last);
    path =
        is_held ? beside_cones(surface, std::move(path)) : shorter_beside(surface, std::move(path));
    append(line.points, crossings(surface, path));
  }
  line.length = length_of(surface, line.points);
  return line;
}

Line pulled_around(const Surface& surface, Chain chain, double min_length) {
  chain = ring_without_returns(chain);
  if (chain.size() < 3) return {};
  Strip ring;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const std::size_t n = chain.size();
    const Strip faces = fan(surface, chain[i], chain[(i + n - 1) % n], chain[(i + 1) % n]);
    ring.insert(ring.end(), faces.begin(), faces.end());
    if (!faces.empty()) continue;
    // Held where the surface hangs together at a vertex only.
    std::ranges::rotate(chain, chain.begin() + static_cast<std::ptrdiff_t>(i));
    chain.push_back(chain.front());
    return pulled_along(surface, chain);
  }
  const Loop loop = shorter_beside(surface, shortest_loop(surface, ring, min_length), min_length);
  if (loop.ring.empty()) return {};
  std::vector<Crossing> points = crossings(surface, loop);
  const double length = length_of(surface, points);
  return {std::move(points), length};
}

Drawn geodesic_through(const Surface& surface, const Course& course) {
  std::vector<Index> stops = course.stops;
  if (course.is_closed) stops.push_back(stops.front());
  Array<bool> is_end(surface.n_vertices(), false);
  Drawn result;
  Chain chain{stops.front()};
  for (std::size_t i = 1; i < stops.size(); ++i) {
    is_end[stops[i]] = true;
    const Route route = along_edges(surface, stops[i - 1], is_end);
    is_end[stops[i]] = false;
    if (route.stops.empty()) {
      const auto stop = static_cast<Index>(i);
      result.unreached = stop % count(std::span(course.stops));
      return result;
    }
    if (course.is_held)
      append(result.points, pulled_along(surface, route.stops).points);
    else
      chain.insert(chain.end(), route.stops.begin() + 1, route.stops.end());
  }
  if (course.is_held) return result;
  if (course.is_closed)
    result.points = pulled_around(surface, std::move(chain), course.min_length).points;
  else
    result.points = pulled_along(surface, without_returns(chain), false).points;
  return result;
}

}  // namespace geodesic
