#include "paths/turns.hpp"

#include <algorithm>
#include <numbers>

namespace geodesic {
namespace {

constexpr double kPi = std::numbers::pi;

// Angle within which a bend is none.
constexpr double kStraightAngle = 1e-9;
// Angle that is missing to 2 pi at a pointed vertex.
constexpr double kMinAngleDefect = 0.25;
// The most pointed vertices along a path whose other side is tried.
constexpr std::size_t kMaxCones = 16;

Strip key_of(const Strip& strip, Index vertex, const Run& run) {
  Strip key{vertex};
  key.insert(key.end(), strip.begin() + run.first, strip.begin() + run.last + 1);
  return key;
}

}  // namespace

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

Run run_around(const Surface& surface, const Strip& strip, Index vertex, Position portal) {
  Run run{portal, portal + 1};
  while (run.first > 0 && surface.has(strip[run.first - 1], vertex)) --run.first;
  while (run.last + 1 < std::ssize(strip) && surface.has(strip[run.last + 1], vertex)) ++run.last;
  return run;
}

Strip other_side(const Surface& surface, const Strip& strip, Index vertex, const Run& run) {
  Strip ring = surface.ring(vertex, strip[run.first]);
  if (ring.empty()) return {};
  const Position beyond = run.last - run.first - std::ssize(ring);
  if (beyond >= 0) return {strip.begin() + run.first, strip.begin() + run.first + beyond + 1};
  if (ring[1] == strip[run.first + 1]) std::reverse(ring.begin() + 1, ring.end());
  ring.erase(std::ranges::find(ring, strip[run.last]) + 1, ring.end());
  return ring;
}

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

std::vector<Turn> turns_of(const Surface& surface, const Strip& strip,
                           const std::vector<Bend>& bends, const Tried& tried) {
  std::vector<Turn> turns;
  for (const auto& [vertex, portal, angle] : bends) {
    const Run run = run_around(surface, strip, vertex, portal);
    if (!turns.empty() && run.first <= turns.back().run.last) continue;
    if (surface.total_angle(vertex) - angle >= kPi - kStraightAngle) continue;
    Strip key = key_of(strip, vertex, run);
    if (tried.contains(key)) continue;
    Strip faces = other_side(surface, strip, vertex, run);
    if (faces.empty()) continue;
    turns.push_back({run, std::move(faces), std::move(key)});
  }
  return turns;
}

std::vector<Beside> ends_of_portals(const Surface& surface, const Strip& strip) {
  std::vector<Beside> ends;
  for (Position i = 0; i + 1 < std::ssize(strip); ++i) {
    const Index* const c = surface.corners(strip[i]);
    for (const Index vertex : {c[0], c[1], c[2]})
      if (surface.has(strip[i + 1], vertex)) ends.push_back({vertex, i});
  }
  const auto by_vertex = [](const Beside& a, const Beside& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.portal < b.portal;
  };
  std::ranges::sort(ends, by_vertex);
  std::vector<Beside> last;
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (i + 1 == ends.size() || ends[i + 1].vertex != ends[i].vertex) last.push_back(ends[i]);
  return last;
}

std::vector<Cone> cones_of(const Surface& surface, const Strip& strip) {
  std::vector<Cone> cones;
  for (const auto& [vertex, portal] : ends_of_portals(surface, strip)) {
    const double angle = surface.total_angle(vertex);
    if (angle < 2 * kPi - kMinAngleDefect) cones.push_back({angle, vertex, portal});
  }
  std::ranges::sort(cones, {}, [](const Cone& cone) { return std::pair(cone.angle, cone.vertex); });
  if (cones.size() > kMaxCones) cones.resize(kMaxCones);
  return cones;
}

}  // namespace geodesic
