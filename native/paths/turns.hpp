// Turns: a strip is led around the other side of a vertex.
#pragma once

#include <optional>
#include <set>

#include "paths/unfolding.hpp"

namespace geodesic {

// Changes of side after which a path is taken as it is: each made it shorter all the same.
inline constexpr Index kMaxTurns = 100'000;
// Share of the length by which a path must be shorter to be another one.
inline constexpr double kMinShortening = 1e-13;

// Without the same face twice in a row, and without there-and-back.
Strip without_returns(const Strip& strip);

// The faces of a strip around a vertex that share a portal, [first, last].
struct Run {
  Position first, last;
};

Run run_around(const Surface& surface, const Strip& strip, Index vertex, Position portal);

// The faces on the other side of a vertex, from the first of a run to its last: of a run all around
// it what is beyond a full turn. None where the vertex has no other side.
Strip other_side(const Surface& surface, const Strip& strip, Index vertex, const Run& run);

// The replacement of a run, and the key of the run: its vertex and its faces.
struct Turn {
  Run run;
  Strip faces, key;
};

using Turns = std::span<const Turn>;
using Tried = std::set<Strip>;  // keys of turns that do not help

// Apply turns, which do not overlap and are sorted, to a strip.
Strip turned(const Strip& strip, Turns turns);

// The turns that shorten a path where they are, as far as they do not overlap.
std::vector<Turn> turns_of(const Surface& surface, const Strip& strip,
                           const std::vector<Bend>& bends, const Tried& tried);

// The strip after all turns, straightened; if it is not shorter, after half of them, and so on.
template <class Straighten>
auto shortened(const Strip& strip, double length, Turns turns, Tried& tried,
               const Straighten& straighten) -> std::optional<decltype(straighten(strip))> {
  if (turns.empty()) return std::nullopt;
  auto other = straighten(turned(strip, turns));
  if (other.length < length * (1 - kMinShortening)) return other;
  if (turns.size() == 1) {
    tried.insert(turns.front().key);
    return std::nullopt;
  }
  const std::size_t half = turns.size() / 2;
  auto found = shortened(strip, length, turns.first(half), tried, straighten);
  return found ? found : shortened(strip, length, turns.subspan(half), tried, straighten);
}

// A vertex beside a strip: an end of portals, of which this is the last.
struct Beside {
  Index vertex;
  Position portal;
};

// All of them, in the order of vertices.
std::vector<Beside> ends_of_portals(const Surface& surface, const Strip& strip);

struct Cone {
  double angle;
  Index vertex;
  Position portal;
};

// The most pointed vertices of the inner edges of a strip, each with the last of these.
std::vector<Cone> cones_of(const Surface& surface, const Strip& strip);

}  // namespace geodesic
