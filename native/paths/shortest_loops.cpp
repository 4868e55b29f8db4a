#include "paths/shortest_loops.hpp"

#include <limits>

#include "paths/tree_loops.hpp"
#include "paths/turns.hpp"

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Length of a loop of edges, in lengths of a loop that is pulled taut, up to which it may become a
// shorter one. On a grid of squares cut one way paths of edges are too long by up to the root of 2.
constexpr double kMostStretch = 1.5;
// Distance along the cut, in lengths of the shortest loop, within which a vertex that was searched
// from stands for others.
constexpr double kMaxGap = 0.05;

// Share of their length by which loops of edges of one class are longer than the shortest of them
// and pulled taut, too. Through the vertices of three uneven tori, 5 of 12,576 loops are longer
// than one of a neighbour allows at 0, by 0.8 % at most, and none at 0.02 and 0.05, in 1.7 and 2.6
// times the time.
constexpr double kSpread = 0.02;
// Vertices of the shortest loop that are searched from, to find one that is shorter still.
constexpr std::size_t kFinalRoots = 8;

// A loop of edges, and its length when it is held at its first vertex and pulled taut.
struct HeldLoop {
  double length;
  Chain chain;
};

// Pulls loops of a tree taut, held at its root, as far as they are at most `best` times
// kMostStretch long before; lowers `best` to the shortest.
void pull_held(const Surface& surface, const TreeLoops& loops, std::span<const Closing> closings,
               double& best, std::vector<HeldLoop>& held) {
  for (const auto& [length, edge] : closings) {
    if (length > kMostStretch * best) return;
    Chain chain = loops.loop(edge);
    const double pulled = pulled_along(surface, chain).length;
    best = std::min(best, pulled);
    held.push_back({pulled, std::move(chain)});
  }
}

// Held loops from vertices of the cut of a component, which lie so close together that the shortest
// loop is near one of them. The tree is that of a vertex of the component.
void search(const Surface& surface, const Sheets& sheets, TreeLoops& loops, double& best,
            std::vector<HeldLoop>& held) {
  std::vector<Closing> closings = loops.shortest_of_classes();
  if (closings.empty()) return;
  const std::vector<Row> cut = loops.cut();
  std::vector<double> gap(cut.size(), kInfinity);
  for (;;) {
    pull_held(surface, loops, closings, best, held);
    // A loop through a vertex at distance d is shorter by 2 d at most.
    const double covered = std::max(0.0, (closings.front().length / kMostStretch - best) / 2);
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < cut.size(); ++i) {
      gap[i] = std::min(gap[i], loops.distance(cut[i]) - covered);
      if (gap[i] > gap[farthest]) farthest = i;
    }
    if (gap[farthest] <= kMaxGap * best) return;
    loops.set_root(sheets.original(cut[farthest]));
    closings = loops.shortest_of_classes();
  }
}

// Shortens a loop to the shortest of those that held ones are pulled to when they are released;
// false where none is shorter.
bool release(const Surface& surface, std::vector<HeldLoop> held, Line& shortest) {
  const double before = shortest.length;
  std::ranges::stable_sort(held, {}, &HeldLoop::length);
  for (HeldLoop& loop : held) {
    if (loop.length > (1 + 2 * kMaxGap) * shortest.length) break;
    loop.chain.pop_back();  // the first vertex again
    Line pulled = pulled_around(surface, std::move(loop.chain), 0.0);
    if (!pulled.points.empty() && pulled.length < shortest.length * (1 - kMinShortening))
      shortest = std::move(pulled);
  }
  return shortest.length < before;
}

// Held loops from vertices of a loop.
std::vector<HeldLoop> held_along(const Surface& surface, TreeLoops& loops, const Line& line) {
  std::vector<HeldLoop> held;
  double best = line.length;
  for (std::size_t k = 0; k < kFinalRoots; ++k) {
    loops.set_root(line.points[k * line.points.size() / kFinalRoots].left);
    pull_held(surface, loops, loops.shortest_of_classes(kSpread), best, held);
  }
  return held;
}

ShortestLoop crowded_at(const Sheets& sheets, Row edge) {
  const SheetEdge& found = sheets.edge(edge);
  return {{}, {sheets.original(found.ends[0]), sheets.original(found.ends[1])}};
}

}  // namespace

ShortestLoop shortest_loop_through(const Surface& surface, Index vertex, double min_hole) {
  const Sheets sheets(surface, min_hole);
  if (sheets.unclear() != kNone) return {{}, {sheets.unclear(), kNone}};
  TreeLoops loops(sheets);
  loops.set_root(vertex);
  if (loops.crowded_edge() != kNone) return crowded_at(sheets, loops.crowded_edge());
  double best = kInfinity;
  std::vector<HeldLoop> held;
  pull_held(surface, loops, loops.shortest_of_classes(kSpread), best, held);
  if (held.empty()) return {};
  return {pulled_along(surface, std::ranges::min(held, {}, &HeldLoop::length).chain)};
}

ShortestLoop shortest_loop_anywhere(const Surface& surface, double min_hole) {
  const Sheets sheets(surface, min_hole);
  if (sheets.unclear() != kNone) return {{}, {sheets.unclear(), kNone}};
  TreeLoops loops(sheets);
  double best = kInfinity;
  std::vector<HeldLoop> held;
  std::vector<bool> is_known(static_cast<std::size_t>(sheets.n_vertices()), false);
  for (Row v = 0; v < sheets.n_vertices(); ++v) {
    if (is_known[static_cast<std::size_t>(v)]) continue;
    loops.set_root(sheets.original(v));
    if (loops.crowded_edge() != kNone) return crowded_at(sheets, loops.crowded_edge());
    for (const Row reached : loops.reached()) is_known[static_cast<std::size_t>(reached)] = true;
    search(surface, sheets, loops, best, held);
  }
  if (held.empty()) return {};
  Line shortest = pulled_along(surface, std::ranges::min(held, {}, &HeldLoop::length).chain);
  while (release(surface, std::move(held), shortest)) held = held_along(surface, loops, shortest);
  return {std::move(shortest)};
}

}  // namespace geodesic
