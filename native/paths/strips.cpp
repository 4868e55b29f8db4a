#include "paths/strips.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

namespace geodesic {
namespace {

constexpr double kPi = std::numbers::pi;

// Changes of side after which a path is taken as it is: each made it shorter all the same.
constexpr Index kMaxTurns = 100'000;
// Angle within which a bend is none.
constexpr double kStraightAngle = 1e-9;
// Share of the length by which a path must be shorter to be another one.
constexpr double kMinShortening = 1e-13;
// Angle that is missing to 2 pi at a pointed vertex.
constexpr double kMinAngleDefect = 0.25;
// The most pointed vertices along a path whose other side is tried.
constexpr std::size_t kMaxCones = 16;

using Vector3 = std::ptrdiff_t;  // in a strip

// Without the same face twice in a row, and without there-and-back.
Strip without_returns(const Strip& strip) {
  Strip kept;
  for (const Index face : strip) {
    if (!kept.empty() && kept.back() == face) continue;
    if (kept.size() > 1 && kept[kept.size() - 2] == face)
      kept.pop_back();
    else
      kept.push_back(face);
  }
  return kept;
}

// From the last face at the start to the first face at the end after it.
Strip trimmed(const Surface& surface, const Strip& strip, Index start, Index end) {
  auto first = strip.begin(), last = strip.end() - 1;
  while (first != last && surface.has(first[1], start)) ++first;
  while (last != first && surface.has(last[-1], end)) --last;
  return {first, last + 1};
}

// An inner edge of a strip, and where it lies in the plane.
struct Portal {
  Index left, right;
  Planar at_left, at_right;
};

struct Unfolded {
  std::vector<Portal> portals;
  Planar first, last;
};

Unfolded unfolded(const Surface& surface, const Path& path) {
  struct {
    Index vertex[3];
    Planar place[3];
    Planar of(Index v) const { return place[v == vertex[0] ? 0 : v == vertex[1] ? 1 : 2]; }
  } flat;
  const Index* const c = surface.corners(path.strip.front());
  std::copy_n(c, 3, flat.vertex);
  const double length = surface.length(c[0], c[1]);
  flat.place[0] = 0.0, flat.place[1] = length;
  flat.place[2] = length * surface.shape(c[0], c[1], c[2]);
  Unfolded result{{}, flat.of(path.start), {}};
  result.portals.reserve(path.strip.size());
  for (std::size_t i = 1; i < path.strip.size(); ++i) {
    const Index following = path.strip[i];
    Index p = flat.vertex[0], q = flat.vertex[1];
    if (!surface.has(following, p)) p = flat.vertex[2];
    if (!surface.has(following, q)) q = flat.vertex[2];
    const Index opposite = surface.third(path.strip[i - 1], p, q);
    if (cross(flat.of(q) - flat.of(p), flat.of(opposite) - flat.of(p)) > 0) std::swap(p, q);
    const Planar at_p = flat.of(p), at_q = flat.of(q);
    result.portals.push_back({p, q, at_p, at_q});
    const Index apex = surface.third(following, p, q);
    flat = {{p, q, apex}, {at_p, at_q, at_p + (at_q - at_p) * surface.shape(p, q, apex)}};
  }
  result.last = flat.of(path.end);
  return result;
}

// A corner of a path in the plane: at an end of which portal, on which side.
struct Knot {
  Vector3 portal;
  bool right;
  Planar place;
};

// The corners of the shortest path, between its start and its end.
std::vector<Knot> funnel(const Unfolded& flat) {
  const Vector3 n = std::ssize(flat.portals);
  std::vector<Knot> knots{{-1, false, flat.first}};
  Planar apex = flat.first, left = apex, right = apex;
  Vector3 at_left = 0, at_right = 0;
  const auto bend = [&](Vector3 portal, bool to_right, Planar place) {
    if (portal < n) knots.push_back({portal, to_right, place});
    apex = left = right = place;
    at_left = at_right = portal;
    return portal + 1;
  };
  for (Vector3 i = 0; i <= n;) {
    const Planar new_left = i < n ? flat.portals[i].at_left : flat.last;
    const Planar new_right = i < n ? flat.portals[i].at_right : flat.last;
    if (right == apex || cross(right - apex, new_right - apex) >= 0) {
      if (right == apex || left == apex || cross(left - apex, new_right - apex) < 0) {
        right = new_right, at_right = i;
      } else {
        i = bend(at_left, false, left);
        continue;
      }
    }
    if (left == apex || cross(left - apex, new_left - apex) <= 0) {
      if (left == apex || right == apex || cross(right - apex, new_left - apex) > 0) {
        left = new_left, at_left = i;
      } else {
        i = bend(at_right, true, right);
        continue;
      }
    }
    ++i;
  }
  knots.push_back({n, false, flat.last});
  return knots;
}

std::vector<Bend> bends_of(const Unfolded& flat, const std::vector<Knot>& knots) {
  std::vector<Bend> bends;
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    const auto& [portal, right, at] = knots[i];
    const Planar inward = knots[i - 1].place - at, outward = knots[i + 1].place - at;
    if (inward == 0.0 || outward == 0.0) continue;
    const double turn = std::arg(outward / inward) * (right ? -1 : 1);
    double angle = turn < 0 ? turn + 2 * kPi : turn;
    if (angle < kPi - 1e-3) angle += 2 * kPi;  // a taut path leaves at least pi: a full turn more
    const Portal& edge = flat.portals[portal];
    bends.push_back({right ? edge.right : edge.left, portal, angle});
  }
  return bends;
}

Path straightened(const Surface& surface, const Strip& strip, Index start, Index end) {
  Path path{start, end, trimmed(surface, strip, start, end), 0.0, {}};
  const Unfolded flat = unfolded(surface, path);
  const std::vector<Knot> knots = funnel(flat);
  for (std::size_t i = 1; i < knots.size(); ++i)
    path.length += std::abs(knots[i].place - knots[i - 1].place);
  path.bends = bends_of(flat, knots);
  return path;
}

// The faces of a strip around a vertex that share a portal, [first, last].
struct Run {
  Vector3 first, last;
};

Run run_around(const Surface& surface, const Strip& strip, Index vertex, Vector3 portal) {
  Run run{portal, portal + 1};
  while (run.first > 0 && surface.has(strip[run.first - 1], vertex)) --run.first;
  while (run.last + 1 < std::ssize(strip) && surface.has(strip[run.last + 1], vertex)) ++run.last;
  return run;
}

// The faces on the other side of a vertex, from the first of a run to its last; none where there
// are none.
Strip other_side(const Surface& surface, const Strip& strip, Index vertex, const Run& run) {
  const Index first = strip[run.first], last = strip[run.last];
  if (first == last) return {};
  Strip ring = surface.ring(vertex, first);
  if (ring.empty()) return {};
  if (ring[1] == strip[run.first + 1]) std::reverse(ring.begin() + 1, ring.end());
  ring.erase(std::ranges::find(ring, last) + 1, ring.end());
  return ring;
}

// The replacement of a run, and the key of the run: its vertex and its faces.
struct Turn {
  Run run;
  Strip faces, key;
};

using Turns = std::span<const Turn>;

// Apply turns, which do not overlap and are sorted, to a strip.
Strip turned(const Strip& strip, Turns turns) {
  Strip result;
  auto at = strip.begin();
  for (const Turn& turn : turns) {
    result.insert(result.end(), at, strip.begin() + turn.run.first);
    result.insert(result.end(), turn.faces.begin(), turn.faces.end());
    at = strip.begin() + turn.run.last + 1;
  }
  result.insert(result.end(), at, strip.end());
  return without_returns(result);
}

using Tried = std::set<Strip>;  // keys of turns that do not help

Strip key_of(const Strip& strip, Index vertex, const Run& run) {
  Strip key{vertex};
  key.insert(key.end(), strip.begin() + run.first, strip.begin() + run.last + 1);
  return key;
}

// The turns that shorten a path where they are, as far as they do not overlap.
std::vector<Turn> turns_of(const Surface& surface, const Path& path, const Tried& tried) {
  std::vector<Turn> turns;
  for (const auto& [vertex, portal, angle] : path.bends) {
    const Run run = run_around(surface, path.strip, vertex, portal);
    if (!turns.empty() && run.first <= turns.back().run.last) continue;
    if (surface.total_angle(vertex) - angle >= kPi - kStraightAngle) continue;
    Strip key = key_of(path.strip, vertex, run);
    if (tried.contains(key)) continue;
    Strip faces = other_side(surface, path.strip, vertex, run);
    if (faces.empty()) continue;
    turns.push_back({run, std::move(faces), std::move(key)});
  }
  return turns;
}

// The path with all turns, or if that is not shorter with half of them, and so on.
std::optional<Path> shortened(const Surface& surface, const Path& path, Turns turns, Tried& tried) {
  if (turns.empty()) return std::nullopt;
  Path other = straightened(surface, turned(path.strip, turns), path.start, path.end);
  if (other.length < path.length * (1 - kMinShortening)) return other;
  if (turns.size() == 1) {
    tried.insert(turns.front().key);
    return std::nullopt;
  }
  const std::size_t half = turns.size() / 2;
  std::optional<Path> found = shortened(surface, path, turns.first(half), tried);
  return found ? found : shortened(surface, path, turns.subspan(half), tried);
}

struct Cone {
  double angle;
  Index vertex;
  Vector3 portal;
};

// The most pointed vertices of the inner edges of a strip, each with the last of these.
std::vector<Cone> cones_of(const Surface& surface, const Strip& strip) {
  std::vector<std::pair<Index, Vector3>> vertices;
  for (Vector3 i = 0; i + 1 < std::ssize(strip); ++i) {
    const Index* const c = surface.corners(strip[i]);
    for (const Index vertex : {c[0], c[1], c[2]})
      if (surface.has(strip[i + 1], vertex)) vertices.push_back({vertex, i});
  }
  std::ranges::sort(vertices);
  std::vector<Cone> cones;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto [vertex, portal] = vertices[i];
    if (i + 1 < vertices.size() && vertices[i + 1].first == vertex) continue;
    const double angle = surface.total_angle(vertex);
    if (angle < 2 * kPi - kMinAngleDefect) cones.push_back({angle, vertex, portal});
  }
  std::ranges::sort(cones, {}, [](const Cone& cone) { return std::pair(cone.angle, cone.vertex); });
  if (cones.size() > kMaxCones) cones.resize(kMaxCones);
  return cones;
}

}  // namespace

Path shortest_path(const Surface& surface, const Strip& strip, Index start, Index end) {
  Path path = straightened(surface, without_returns(strip), start, end);
  Tried tried;
  for (Index i = 0; i < kMaxTurns; ++i) {
    const std::vector<Turn> turns = turns_of(surface, path, tried);
    if (turns.empty()) break;
    if (std::optional<Path> shorter = shortened(surface, path, turns, tried))
      path = std::move(*shorter);
  }
  return path;
}

Path beside_cones(const Surface& surface, Path path) {
  for (bool found = true; found;) {
    found = false;
    for (const Cone& cone : cones_of(surface, path.strip)) {
      const Run run = run_around(surface, path.strip, cone.vertex, cone.portal);
      const Turn turn{run, other_side(surface, path.strip, cone.vertex, run), {}};
      if (turn.faces.empty()) continue;
      Path other = shortest_path(surface, turned(path.strip, {&turn, 1}), path.start, path.end);
      found = other.length < path.length * (1 - kMinShortening);
      if (!found) continue;
      path = std::move(other);
      break;
    }
  }
  return path;
}

std::vector<Crossing> crossings(const Surface& surface, const Path& path) {
  const Unfolded flat = unfolded(surface, path);
  const std::vector<Knot> knots = funnel(flat);
  std::vector<Crossing> points{{path.strip.front(), path.start, path.start, 0.0}};
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const Planar p = knots[i - 1].place, q = knots[i].place;
    const Vector3 last = std::min(knots[i].portal, std::ssize(flat.portals) - 1);
    for (Vector3 portal = knots[i - 1].portal + 1; portal <= last; ++portal) {
      const auto& [left, right, a, b] = flat.portals[portal];
      const double across = cross(b - a, q - p);
      // Where the path runs along the edge it is on its way to one end: to q.
      const double share = across != 0 ? cross(p - a, q - p) / across : q != a;
      points.push_back({path.strip[portal], left, right, std::clamp(share, 0.0, 1.0)});
    }
  }
  points.push_back({path.strip.back(), path.end, path.end, 0.0});
  return points;
}

}  // namespace geodesic
