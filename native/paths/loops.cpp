#include "paths/loops.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "paths/turns.hpp"

namespace geodesic {
namespace {

// Turns of a ring that are unfolded at first, and at most.
constexpr Position kFirstPeriods = 4, kMaxPeriods = 64;
// Bends in the middle of a path over several turns that are tried as a base.
constexpr std::size_t kMaxBases = 4;
// Bends that a closed geodesic is led over to the other side, if that leads to a shorter one.
constexpr std::size_t kMaxMovedBends = 8;
// Angle by which the bends that are turned together differ at most. Sharp ones first, as edge flips
// have them, end in shorter geodesics: of 80 loops on two scanned surfaces 76 are the same from 0
// to infinity, and four shorter by 0.002 to 10 % up to 0.2; at 0.5 two of these are lost. Half of
// it takes twice the time.
constexpr double kSharpestAngles = 0.2;
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

// A shorter closed path through the same ring; none where it is the shortest.
std::optional<Loop> released(const Surface& surface, const Loop& loop) {
  for (Position periods = kFirstPeriods; periods <= kMaxPeriods; periods *= 2) {
    const Unfolded flat = unfolded(surface, repeated(loop.ring, periods), loop.base, loop.base);
    const std::vector<Knot> knots = funnel(flat);
    const double repeated_length = static_cast<double>(periods) * loop.length;
    if (length_of(knots) >= repeated_length * (1 - kLengthTolerance)) return std::nullopt;
    std::vector<Knot> middle = from_the_middle(knots);
    if (middle.size() > kMaxBases) middle.resize(kMaxBases);
    for (const Knot& knot : middle) {
      const Portal& edge = flat.portals[static_cast<std::size_t>(knot.portal)];
      const Position portal = knot.portal % std::ssize(loop.ring);
      Loop other = based_at(surface, loop.ring, portal, knot.right ? edge.right : edge.left);
      if (other.length < loop.length * (1 - kMinShortening)) return other;
    }
  }
  return std::nullopt;
}

// Where a closed path bends, in the order of the ring.
std::vector<Bend> bends_of(const Surface& surface, const Loop& loop) {
  const Position n = std::ssize(loop.ring);
  const Unfolded flat = unfolded(surface, repeated(loop.ring, 3), loop.base, loop.base);
  std::vector<Bend> bends;
  for (Bend bend : bends_of(flat, funnel(flat))) {
    if (bend.portal < n - 1 || bend.portal >= 2 * n - 1) continue;
    bend.portal %= n;
    bends.push_back(bend);
  }
  std::ranges::sort(bends, {}, &Bend::portal);
  return bends;
}

Loop taut(const Surface& surface, const Strip& faces, double min_length) {
  Strip ring = ring_without_returns(faces);
  if (ring.size() < 3 || is_star(surface, ring)) return {};
  const Unfolded first = unfolded(surface, repeated(ring, 2), surface.corners(ring.front())[0],
                                  surface.corners(ring.back())[0]);
  const Position last = std::ssize(ring) - 1;
  const Index vertex = first.portals[static_cast<std::size_t>(last)].left;
  Loop loop = based_at(surface, std::move(ring), last, vertex);
  while (std::optional<Loop> shorter = released(surface, loop)) loop = std::move(*shorter);
  if (!(loop.length > min_length)) return {};
  loop.bends = bends_of(surface, loop);
  return loop;
}

// A ring begun at the first of the runs of some turns, and these as they lie there.
struct Turnable {
  Strip ring;
  std::vector<Turn> turns;
};

Turnable begun_at(const Strip& thrice, std::vector<Turn> turns) {
  const Position n = std::ssize(thrice) / 3;
  std::erase_if(turns, [n](const Turn& turn) { return turn.run.last - turn.run.first >= n; });
  if (turns.empty()) return {};
  const Position shift = turns.front().run.first;
  if (turns.back().run.last - shift >= n) turns.pop_back();  // it reaches around to the first
  for (Turn& turn : turns) turn.run.first -= shift, turn.run.last -= shift;
  return {Strip(thrice.begin() + shift, thrice.begin() + shift + n), std::move(turns)};
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
  return begun_at(thrice, std::move(turns));
}

// A vertex of a ring, and an edge of the ring there.
struct Movable {
  Index vertex;
  Position portal;
};

// The vertices to the other side of which a closed geodesic may be led: those it bends around, from
// the least angle on that side on, and pointed ones.
std::vector<Movable> movable(const Surface& surface, const Loop& loop) {
  std::vector<Bend> bends = loop.bends;
  std::ranges::sort(
      bends, {}, [&](const Bend& bend) { return surface.total_angle(bend.vertex) - bend.angle; });
  if (bends.size() > kMaxMovedBends) bends.resize(kMaxMovedBends);
  std::vector<Movable> result;
  for (const Bend& bend : bends) result.push_back({bend.vertex, bend.portal});
  for (const Cone& cone : cones_of(surface, loop.ring))
    result.push_back({cone.vertex, cone.portal});
  return result;
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
  const auto pulled = [&](const Strip& faces) { return taut(surface, faces, min_length); };
  Loop loop = pulled(ring);
  Tried tried;
  for (Index i = 0; i < kMaxTurns && !loop.ring.empty(); ++i) {
    const auto [begun, turns] = turns_of(surface, loop, tried);
    if (turns.empty()) break;
    if (std::optional<Loop> shorter = shortened(begun, loop.length, turns, tried, pulled))
      loop = std::move(*shorter);
  }
  return loop;
}

Loop beside_vertices(const Surface& surface, Loop loop, double min_length) {
  for (bool found = !loop.ring.empty(); found;) {
    found = false;
    const Strip thrice = repeated(loop.ring, 3);
    for (const auto& [vertex, portal] : movable(surface, loop)) {
      const Run run = run_around(surface, thrice, vertex, portal + std::ssize(loop.ring));
      const auto [begun, turns] =
          begun_at(thrice, {{run, other_side(surface, thrice, vertex, run), {}}});
      if (turns.empty() || turns.front().faces.empty()) continue;
      Loop other = shortest_loop(surface, turned(begun, turns), min_length);
      found = !other.ring.empty() && other.length < loop.length * (1 - kMinShortening);
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
