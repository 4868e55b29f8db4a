#include "paths/loops.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "paths/turns.hpp"

namespace geodesic {
namespace {

// Turns of a ring that are unfolded at first, and at most.
constexpr Position kFirstPeriods = 2, kMaxPeriods = 64;
// Bends in the middle of a path over several turns that are tried as a base.
constexpr std::size_t kMaxBases = 4;
// Angle by which the bends that are turned together differ at most. The sharpest first, as edge
// flips have it, ends in shorter geodesics: of 300 loops on two scanned surfaces 4, 5 and 7 are
// longer than by flips at 0, 0.05 and 0.2, in 10.3, 7.5 and 4.8 ms each. Of 136 loops on four other
// meshes 0, 0 and 1 are longer and 96, 96 and 97 shorter, in 4.3, 2.5 and 1.7 times their time.
constexpr double kSharpestAngles = 0.05;
// Share of the length within which a path over several turns is the closed one, repeated.
constexpr double kLengthTolerance = 1e-12;

Strip repeated(const Strip& ring, Position periods) {
  Strip many;
  many.reserve(ring.size() * static_cast<std::size_t>(periods));
  for (Position k = 0; k < periods; ++k) many.insert(many.end(), ring.begin(), ring.end());
  return many;
}

// Whether a vertex belongs to all faces, so that a closed path through them shrinks to it.
bool is_star(const Surface& surface, const Strip& ring) {
  const Index* const c = surface.corners(ring.front());
  return std::ranges::any_of(std::initializer_list<Index>{c[0], c[1], c[2]}, [&](Index vertex) {
    return std::ranges::all_of(ring, [&](Index face) { return surface.has(face, vertex); });
  });
}

// The shortest closed path through a vertex at the edge after a face of a ring.
Loop based_at(const Surface& surface, Strip ring, Position portal, Index vertex) {
  std::ranges::rotate(ring, ring.begin() + (portal + 1) % std::ssize(ring));
  const double length = straightened(surface, ring, vertex, vertex).length;
  return {std::move(ring), vertex, length, {}};
}

// The bends of a path, those nearest to its middle first.
std::vector<Knot> from_the_middle(const std::vector<Knot>& knots) {
  struct Placed {
    double off;
    Knot knot;
  };
  const double half = length_of(knots) / 2;
  std::vector<Placed> placed;
  double along = 0;
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    along += std::abs(knots[i].place - knots[i - 1].place);
    placed.push_back({std::abs(along - half), knots[i]});
  }
  std::ranges::stable_sort(placed, {}, &Placed::off);
  std::vector<Knot> result;
  for (const auto& [_, knot] : placed) result.push_back(knot);
  return result;
}

// Where a closed path bends, in the order of the ring, from what it is unfolded twice.
std::vector<Bend> bends_of(const Unfolded& twice, const std::vector<Knot>& knots, Position n) {
  std::vector<Bend> bends;
  for (Bend bend : bends_of(twice, knots)) {
    if (bend.portal < n / 2 || bend.portal >= n / 2 + n) continue;  // once, its base among them
    bend.portal %= n;
    bends.push_back(bend);
  }
  std::ranges::sort(bends, {}, &Bend::portal);
  return bends;
}

// A shorter closed path through the same ring; none where it is the shortest, in which case
// `bends` becomes its bends.
std::optional<Loop> released(const Surface& surface, Loop& loop) {
  const Position n = std::ssize(loop.ring);
  for (Position periods = kFirstPeriods; periods <= kMaxPeriods; periods *= 2) {
    const Unfolded flat = unfolded(surface, repeated(loop.ring, periods), loop.base, loop.base);
    const std::vector<Knot> knots = funnel(flat);
    const double repeated_length = static_cast<double>(periods) * loop.length;
    const bool is_taut = length_of(knots) >= repeated_length * (1 - kLengthTolerance);
    if (periods == kFirstPeriods) loop.bends = bends_of(flat, knots, n);
    if (is_taut) return std::nullopt;
    std::vector<Knot> middle = from_the_middle(knots);
    if (middle.size() > kMaxBases) middle.resize(kMaxBases);
    for (const Knot& knot : middle) {
      const Portal& edge = flat.portals[static_cast<std::size_t>(knot.portal)];
      Loop other =
          based_at(surface, loop.ring, knot.portal % n, knot.right ? edge.right : edge.left);
      if (other.length < loop.length * (1 - kMinShortening)) return other;
    }
  }
  return std::nullopt;
}

// A vertex that the faces before and after an edge of a ring share, the one that is hoped for if
// there is such an edge.
struct Base {
  Position portal;
  Index vertex;
};

Base base_of(const Surface& surface, const Strip& ring, Index hoped) {
  const auto next = [&](Position i) { return ring[(i + 1) % std::ssize(ring)]; };
  for (Position i = 0; i < std::ssize(ring); ++i)
    if (surface.has(ring[i], hoped) && surface.has(next(i), hoped)) return {i, hoped};
  const Index* const c = surface.corners(ring.back());
  for (const Index vertex : {c[0], c[1]})
    if (surface.has(ring.front(), vertex)) return {std::ssize(ring) - 1, vertex};
  return {std::ssize(ring) - 1, c[2]};
}

Loop taut(const Surface& surface, const Strip& faces, Index hoped, double min_length) {
  Strip ring = ring_without_returns(faces);
  if (ring.size() < 3 || is_star(surface, ring)) return {};
  const Base base = base_of(surface, ring, hoped);
  Loop loop = based_at(surface, std::move(ring), base.portal, base.vertex);
  while (std::optional<Loop> shorter = released(surface, loop)) loop = std::move(*shorter);
  return loop.length > min_length ? std::move(loop) : Loop{};
}

// The vertex of the bend that is farthest from an edge of the ring; kNone where there is no bend.
Index far_bend(const Loop& loop, Position portal) {
  const Position n = std::ssize(loop.ring);
  Index found = kNone;
  Position most = -1;
  for (const Bend& bend : loop.bends) {
    const Position off = std::abs(bend.portal - portal % n), apart = std::min(off, n - off);
    if (apart > most) most = apart, found = bend.vertex;
  }
  return found;
}

// A ring begun at the first of the runs of some turns, these as they lie there, and a vertex that
// the loop will probably pass.
struct Turnable {
  Strip ring;
  std::vector<Turn> turns;
  Index hoped = kNone;
};

Turnable begun_at(const Strip& thrice, std::vector<Turn> turns) {
  const Position n = std::ssize(thrice) / 3;
  std::erase_if(turns, [n](const Turn& turn) { return turn.run.last - turn.run.first >= n; });
  if (turns.empty()) return {};
  const Position shift = turns.front().run.first;
  if (turns.back().run.last - shift >= n) turns.pop_back();  // it reaches around to the first
  for (Turn& turn : turns) turn.run.first -= shift, turn.run.last -= shift;
  return {Strip(thrice.begin() + shift, thrice.begin() + shift + n), std::move(turns), kNone};
}

// The turns at the sharpest bends, as far as they do not overlap.
Turnable turns_of(const Surface& surface, const Loop& loop, const Tried& tried) {
  struct Found {
    double angle;  // on the other side
    Turn turn;
  };
  const Strip thrice = repeated(loop.ring, 3);
  std::vector<Found> found;
  double least = std::numeric_limits<double>::infinity();
  for (Bend bend : loop.bends) {
    bend.portal += std::ssize(loop.ring);
    for (Turn& turn : turns_of(surface, thrice, {bend}, tried)) {
      found.push_back({surface.total_angle(bend.vertex) - bend.angle, std::move(turn)});
      least = std::min(least, found.back().angle);
    }
  }
  std::vector<Turn> turns;
  for (auto& [angle, turn] : found)
    if (angle <= least + kSharpestAngles &&
        (turns.empty() || turn.run.first > turns.back().run.last))
      turns.push_back(std::move(turn));
  const Index hoped = turns.empty() ? kNone : far_bend(loop, turns.front().run.first);
  Turnable result = begun_at(thrice, std::move(turns));
  result.hoped = hoped;
  return result;
}

// A ring led around the other side of a vertex; none where it has no other side.
Strip led_around(const Surface& surface, const Strip& ring, Index vertex, Position portal) {
  const Strip thrice = repeated(ring, 3);
  const Run run = run_around(surface, thrice, vertex, portal + std::ssize(ring));
  const auto [begun, turns, _] =
      begun_at(thrice, {{run, other_side(surface, thrice, vertex, run), {}}});
  if (turns.empty() || turns.front().faces.empty()) return {};
  return ring_without_returns(turned(begun, turns));
}

// The ring beside that of a loop: led around all vertices on its left, or on its right.
Strip beside(const Surface& surface, const Loop& loop, bool on_the_left) {
  const Unfolded flat = unfolded(surface, repeated(loop.ring, 2), loop.base, loop.base);
  std::vector<Index> vertices;
  for (Position i = 0; i < std::ssize(loop.ring); ++i) {
    const Portal& edge = flat.portals[static_cast<std::size_t>(i)];
    const Index vertex = on_the_left ? edge.left : edge.right;
    if (vertices.empty() || vertices.back() != vertex) vertices.push_back(vertex);
  }
  Strip ring = loop.ring;
  for (const Index vertex : vertices) {
    const auto [portal, shared] = base_of(surface, ring, vertex);
    if (shared != vertex) continue;
    Strip other = led_around(surface, ring, vertex, portal);
    if (other.size() > 2) ring = std::move(other);
  }
  return ring;
}

}  // namespace

Strip ring_without_returns(const Strip& ring) {
  const Strip kept = without_returns(ring);
  auto first = kept.begin(), last = kept.end();
  while (last - first > 1) {
    if (*first == last[-1] || *first == last[-2])
      --last;
    else if (first[1] == last[-1])
      ++first;
    else
      break;
  }
  return {first, last};
}

Loop shortest_loop(const Surface& surface, const Strip& ring, double min_length) {
  Loop loop = taut(surface, ring, kNone, min_length);
  Tried tried;
  for (Index i = 0; i < kMaxTurns && !loop.ring.empty(); ++i) {
    const auto [begun, turns, hoped] = turns_of(surface, loop, tried);
    if (turns.empty()) break;
    const auto pulled = [&, base = hoped](const Strip& faces) {
      return taut(surface, faces, base, min_length);
    };
    if (std::optional<Loop> shorter = shortened(begun, loop.length, turns, tried, pulled))
      loop = std::move(*shorter);
  }
  return loop;
}

Loop shorter_beside(const Surface& surface, Loop loop, double min_length) {
  const auto is_shorter = [&](const Loop& other) {
    return !other.ring.empty() && other.length < loop.length * (1 - kMinShortening);
  };
  for (bool found = !loop.ring.empty(); found;) {
    found = false;
    std::vector<Strip> rings{beside(surface, loop, true), beside(surface, loop, false)};
    for (const auto& [vertex, portal] : ends_of_portals(surface, loop.ring))
      rings.push_back(led_around(surface, loop.ring, vertex, portal));
    for (const Strip& ring : rings) {
      if (ring.empty()) continue;
      Loop other = shortest_loop(surface, ring, min_length);
      found = is_shorter(other);
      if (!found) continue;
      loop = std::move(other);
      break;
    }
  }
  return loop;
}

std::vector<Crossing> crossings(const Surface& surface, const Loop& loop) {
  return crossings(surface, straightened(surface, loop.ring, loop.base, loop.base));
}

}  // namespace geodesic
