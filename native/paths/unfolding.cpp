#include "paths/unfolding.hpp"

#include <algorithm>
#include <numbers>

namespace geodesic {
namespace {

constexpr double kPi = std::numbers::pi;
// Sine of the angle within which two directions are one. On lattices vertices lie on a line except
// for rounding, and a strip that folds back there would be taken to go straight on.
constexpr double kSameDirection = 1e-12;

}  // namespace

double side(Planar p, Planar q) {
  const double across = cross(p, q);
  const double least = kSameDirection * kSameDirection * std::norm(p) * std::norm(q);
  return across * across <= least ? 0.0 : across;
}

Unfolded unfolded(const Surface& surface, const Strip& strip, Index start, Index end) {
  struct {
    Index vertex[3];
    Planar place[3];
    Planar of(Index v) const { return place[v == vertex[0] ? 0 : v == vertex[1] ? 1 : 2]; }
  } flat;
  const Index* const c = surface.corners(strip.front());
  std::copy_n(c, 3, flat.vertex);
  const double length = surface.length(c[0], c[1]);
  flat.place[0] = 0.0, flat.place[1] = length;
  flat.place[2] = length * surface.shape(c[0], c[1], c[2]);
  Unfolded result{{}, flat.of(start), {}};
  result.portals.reserve(strip.size());
  for (std::size_t i = 1; i < strip.size(); ++i) {
    const Index following = strip[i];
    Index p = flat.vertex[0], q = flat.vertex[1];
    if (!surface.has(following, p)) p = flat.vertex[2];
    if (!surface.has(following, q)) q = flat.vertex[2];
    const Index opposite = surface.third(strip[i - 1], p, q);
    if (cross(flat.of(q) - flat.of(p), flat.of(opposite) - flat.of(p)) > 0) std::swap(p, q);
    const Planar at_p = flat.of(p), at_q = flat.of(q);
    result.portals.push_back({p, q, at_p, at_q});
    const Index apex = surface.third(following, p, q);
    flat = {{p, q, apex}, {at_p, at_q, at_p + (at_q - at_p) * surface.shape(p, q, apex)}};
  }
  result.last = flat.of(end);
  return result;
}

std::vector<Knot> funnel(const Unfolded& flat) {
  const Position n = std::ssize(flat.portals);
  std::vector<Knot> knots{{-1, false, flat.first}};
  Planar apex = flat.first, left = apex, right = apex;
  Position at_left = 0, at_right = 0;
  const auto bend = [&](Position portal, bool to_right, Planar place) {
    if (portal < n) knots.push_back({portal, to_right, place});
    apex = left = right = place;
    at_left = at_right = portal;
    return portal + 1;
  };
  for (Position i = 0; i <= n;) {
    const Planar new_left = i < n ? flat.portals[i].at_left : flat.last;
    const Planar new_right = i < n ? flat.portals[i].at_right : flat.last;
    if (right == apex || side(right - apex, new_right - apex) >= 0) {
      if (right == apex || left == apex || side(left - apex, new_right - apex) < 0) {
        right = new_right, at_right = i;
      } else {
        i = bend(at_left, false, left);
        continue;
      }
    }
    if (left == apex || side(left - apex, new_left - apex) <= 0) {
      if (left == apex || right == apex || side(right - apex, new_left - apex) > 0) {
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

double length_of(const std::vector<Knot>& knots) {
  double length = 0;
  for (std::size_t i = 1; i < knots.size(); ++i)
    length += std::abs(knots[i].place - knots[i - 1].place);
  return length;
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

}  // namespace geodesic
