#include "paths/strips.hpp"

#include <algorithm>
#include <cmath>

#include "paths/turns.hpp"

namespace geodesic {
namespace {

// From the last face at the start to the first face at the end after it.
Strip trimmed(const Surface& surface, const Strip& strip, Index start, Index end) {
  auto first = strip.begin(), last = strip.end() - 1;
  while (first != last && surface.has(first[1], start)) ++first;
  while (last != first && surface.has(last[-1], end)) --last;
  return {first, last + 1};
}

// A strip led around the other side of a vertex; none where it has no other side.
Strip led_around(const Surface& surface, const Strip& strip, Index vertex, Position portal) {
  const Run run = run_around(surface, strip, vertex, portal);
  const Turn turn{run, other_side(surface, strip, vertex, run), {}};
  return turn.faces.empty() ? Strip{} : turned(strip, {&turn, 1});
}

// The strip beside that of a path: led around all vertices on its left, or on its right.
Strip beside(const Surface& surface, const Path& path, bool on_the_left) {
  Strip strip = path.strip;
  Index before = kNone;
  for (const Portal& edge : unfolded(surface, strip, path.start, path.end).portals) {
    const Index vertex = on_the_left ? edge.left : edge.right;
    if (vertex == before) continue;
    before = vertex;
    for (Position i = 0; i + 1 < std::ssize(strip); ++i) {
      if (!surface.has(strip[i], vertex) || !surface.has(strip[i + 1], vertex)) continue;
      Strip other = led_around(surface, strip, vertex, i);
      if (!other.empty()) strip = std::move(other);
      break;
    }
  }
  return strip;
}

// A path, led into the first of some strips beside it whose geodesic is shorter, time and again.
template <class StripsBeside>
Path shorter_among(const Surface& surface, Path path, const StripsBeside& strips_beside) {
  for (bool found = true; found;) {
    found = false;
    for (const Strip& strip : strips_beside(path)) {
      if (strip.empty()) continue;
      Path other = shortest_path(surface, strip, path.start, path.end);
      found = other.length < path.length * (1 - kMinShortening);
      if (!found) continue;
      path = std::move(other);
      break;
    }
  }
  return path;
}

}  // namespace

Path straightened(const Surface& surface, const Strip& strip, Index start, Index end) {
  Path path{start, end, trimmed(surface, strip, start, end), 0.0, {}};
  const Unfolded flat = unfolded(surface, path.strip, start, end);
  const std::vector<Knot> knots = funnel(flat);
  path.length = length_of(knots);
  path.bends = bends_of(flat, knots);
  return path;
}

Path shortest_path(const Surface& surface, const Strip& strip, Index start, Index end) {
  const auto pulled = [&](const Strip& faces) { return straightened(surface, faces, start, end); };
  Path path = pulled(without_returns(strip));
  Tried tried;
  for (Index i = 0; i < kMaxTurns; ++i) {
    const std::vector<Turn> turns = turns_of(surface, path.strip, path.bends, tried);
    if (turns.empty()) break;
    if (auto shorter = shortened(path.strip, path.length, turns, tried, pulled))
      path = std::move(*shorter);
  }
  return path;
}

Path beside_cones(const Surface& surface, Path path) {
  return shorter_among(surface, std::move(path), [&](const Path& from) {
    std::vector<Strip> strips;
    for (const Cone& cone : cones_of(surface, from.strip))
      strips.push_back(led_around(surface, from.strip, cone.vertex, cone.portal));
    return strips;
  });
}

Path shorter_beside(const Surface& surface, Path path) {
  return shorter_among(surface, std::move(path), [&](const Path& from) {
    std::vector<Strip> strips{beside(surface, from, true), beside(surface, from, false)};
    for (const auto& [vertex, portal] : ends_of_portals(surface, from.strip))
      strips.push_back(led_around(surface, from.strip, vertex, portal));
    return strips;
  });
}

std::vector<Crossing> crossings(const Surface& surface, const Path& path) {
  const Unfolded flat = unfolded(surface, path.strip, path.start, path.end);
  const std::vector<Knot> knots = funnel(flat);
  std::vector<Crossing> points{{path.strip.front(), path.start, path.start, 0.0}};
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const Planar p = knots[i - 1].place, q = knots[i].place;
    const Position last = std::min(knots[i].portal, std::ssize(flat.portals) - 1);
    for (Position portal = knots[i - 1].portal + 1; portal <= last; ++portal) {
      const auto& [left, right, a, b] = flat.portals[portal];
      const double across = side(b - a, q - p);
      // Where the path runs along the edge it is on its way to one end: to q.
      const double share = across != 0 ? cross(p - a, q - p) / across : q != a;
      points.push_back({path.strip[portal], left, right, std::clamp(share, 0.0, 1.0)});
    }
  }
  points.push_back({path.strip.back(), path.end, path.end, 0.0});
  return points;
}

double length_of(const Surface& surface, std::span<const Crossing> points) {
  double length = 0, last[3];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [_, left, right, share] = points[i];
    const double *const a = surface.place(left), *const b = surface.place(right);
    double squared = 0;
    for (int c = 0; c < 3; ++c) {
      const double here = (1 - share) * a[c] + share * b[c];
      if (i > 0) squared += (here - last[c]) * (here - last[c]);
      last[c] = here;
    }
    length += std::sqrt(squared);
  }
  return length;
}

}  // namespace geodesic
