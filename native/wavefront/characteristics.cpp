#include "wavefront/characteristics.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "core/angles.hpp"
#include "core/processor.hpp"
#include "wavefront/crossing.hpp"
#include "wavefront/falling.hpp"

namespace geodesic {
namespace {

constexpr int kAtOnce = 8;              // corners that are looked at together
constexpr Index kPrefetchDistance = 8;  // vertices of prefetch distance
using Lanes = Pack<kAtOnce>;

// Up to this many times the least distance an edge goes before what comes across one, as in sweeps.
constexpr double kTie = 1 + 1e-12;

// Share of a length by which a distance may differ from it and be that length: rounding.
constexpr double kSame = 1e-9;

// Share of the distance by which the best way through a vertex's own star may be longer than what
// sweeps found: then the front came through triangles of other stars.
constexpr double kMissed = 1e-3;

// Edge lengths by which what the ends of an edge carry may differ from what one front would have
// there; beyond that two fronts have met on the edge. Plateau: 0.5 to 3 give the same angles on
// bunny, spot and koala, against exact paths; 0.3 finds meetings where there are none.
constexpr double kMeeting = 0.75;

// Change of an angle after which those that were carried on from it are carried again.
constexpr double kSettled = 1e-9;

// Times that data are carried to a vertex at most: ends of edges that are farther than the vertex
// opposite take from it in turn, and their angles are constant after five to eight.
constexpr std::uint8_t kMostTimes = 30;

// Spread of geodesics that turn about a corner of the boundary: all leave their source at one
// angle.
constexpr double kShadow = 1e100;

// Error of a rotation that is carried, in parts of the holonomy about the edge that it crosses.
// With 1 to 100 transport on tubes is exact and that from ten sources on spheres the same; on five
// meshes, against exact paths, it is 2.75 degrees off with 1, and 2.6 with 30 and 100.
constexpr double kDoubt = 30;

// Spread from which on a geodesic has turned about a corner.
constexpr double kLit = 1e50;

// Least spread, in edge lengths, so that nothing is divided by zero where geodesics meet again.
constexpr double kFocus = 1e-3;

// How the front came to a vertex: from a along an edge, where b is the same, or across that from a
// to b. Radii are those at a, b and the vertex itself, without their sign.
struct Characteristic {
  Row a = kNone, b = kNone;
  double share = 0, radius_a = 0, radius_b = 0, radius = 0, step = 0, edge = 0, whole = 0;
  double arrival = 0;
  Row corner = kNone;    // of the vertex
  bool along_b = false;  // whether it is the second edge of that corner along which it came
};

// The vertices that a vertex takes its data from.
struct Ends {
  Row a = kNone, b = kNone;
};

// The data of a vertex. The slope is the derivative of the spread by distance.
struct State {
  double angle, spread, slope, rotation, arrival;
  double error = 0;  // of the rotation
  double mixed = 0;  // share of other fronts in the distance, times the angle between them
  Row label = kNone;
  bool is_fixed = false;
};

double squared(double x) { return x * x; }

// The rest of an angle after whole turns: in (-1/2, 1/2] of them, or where angles are known to
// fall in (-3/4, 1/4].
double within_turn(double angle, const Circle& circle) {
  if (!(circle.period < kInfinity)) return angle;
  const double most = circle.clockwise ? 0.25 : 0.5;
  return angle - circle.period * std::ceil(angle / circle.period - most);
}

// The angle at the corner of a triangle between sides of such lengths, opposite `edge`.
double corner_angle(double to_a, double to_b, double edge) {
  const double square = 4 * squared(to_a * to_b);
  const double cosine = to_a * to_a + to_b * to_b - edge * edge;
  return angle(cosine, std::sqrt(std::max(square - cosine * cosine, 0.0)));
}

// The paths of one set of fronts, and the data carried along them.
class Way {
 public:
  Way(const Corners& corners, std::span<const Bearing> bearings, std::span<const double> curvature,
      std::span<const bool> reflex, const SweptFronts& fronts, const Circle& circle)
      : corners_(corners),
        bearings_(bearings),
        curvature_(curvature),
        reflex_(reflex),
        circle_(circle),
        front_(curvature.size()),
        ways_(curvature.size(), Characteristic{}),
        states_(curvature.size()),
        ends_(curvature.size(), Ends{}),
        place_of_(count(curvature)),
        n_times_(count(curvature), 0),
        is_pending_(count(curvature), false) {
    constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
    for (Index v = 0; v < n_vertices(); ++v) {
      front_[v] = {fronts.distances[v], inverse(fronts.kappas[v])};
      states_[v] = {kNoNumber, kNoNumber, kNoNumber, kNoNumber, kNoNumber};
    }
  }

  void begin(const Seeds& seeds) {
    for (Index p = 0; p < count(seeds.vertices); ++p) {
      const Index v = seeds.vertices[p];
      const double distance = seeds.distances[p];
      if (states_[v].is_fixed || front_[v].distance < distance - kSame * std::abs(distance))
        continue;  // of several at a vertex the first counts; and none to which there is a way
      const double bend = curvature_[v] * squared(distance);
      states_[v] = {seeds.angles[p],
                    seeds.spreads[p] * (1 - bend / 6),
                    1 - bend / 2,
                    seeds.arrivals[p] - seeds.angles[p],
                    seeds.arrivals[p],
                    0.0,
                    0.0,
                    seeds.labels[p],
                    true};
    }
    for (Index v = 0; v < n_vertices(); ++v)
      if (!states_[v].is_fixed && front_[v].distance < kInfinity) ways_[v] = way_to(v);
    for (Index p = 0; p < count(seeds.vertices) && circle_.directions; ++p)
      if (is_point(seeds, p)) begin_about(static_cast<Row>(seeds.vertices[p]), seeds.labels[p]);
  }

  // In the order of the distance, and at once again for vertices whose predecessors have changed:
  // so the others take from them when they are final.
  void carry_on() {
    const Index n = n_vertices();
    Array<double> later(n);
    for (Index v = 0; v < n; ++v) later[v] = -front_[v].distance;
    const Array<Row> order = falling({later, 1, true}, 0, 1);
    for (Index k = 0; k < n; ++k) {
      const Row v = order[k];
      place_of_[v] = static_cast<Row>(k);
      if (!states_[v].is_fixed) ends_[v] = {ways_[v].a, ways_[v].b};
      await(v);
    }
    for (Index k = 0; k < n;) {
      const void* const found = std::memchr(&is_pending_[k], true, static_cast<std::size_t>(n - k));
      if (!found) break;
      k = static_cast<const bool*>(found) - is_pending_.data();
      prefetch_soon(order[std::min(k + kPrefetchDistance, n - 1)]);
      const Row v = order[k];
      is_pending_[k++] = false;
      const State before = states_[v];
      carry_to(v);
      if (has_changed(before, states_[v])) k = std::min(k, await_followers(v));
    }
    for (const Row v : order) carry_to_left(v);
  }

  Carried result() const {
    const Index n = n_vertices();
    Carried result{Array<double>(n), Array<double>(n), Array<double>(n), Array<double>(n),
                   Array<double>(n), Array<Row>(n),    Array<Row>(n),    Array<Row>(n)};
    for (Index v = 0; v < n; ++v) {
      result.angles[v] = states_[v].angle;
      result.spreads[v] = states_[v].spread;
      result.arrivals[v] = states_[v].spread > kLit || !circle_.directions
                               ? states_[v].arrival
                               : states_[v].angle + states_[v].rotation;
      result.rotations[v] = states_[v].rotation;
      result.labels[v] = states_[v].label;
      result.shares[v] = ways_[v].share;
      result.a[v] = states_[v].is_fixed ? kNone : ways_[v].a;
      result.b[v] = states_[v].is_fixed ? kNone : ways_[v].b;
    }
    return result;
  }

 private:
  Index n_vertices() const { return curvature_.size(); }
  double distance(Index v) const { return front_[v].distance; }

  bool is_point(const Seeds& seeds, Index p) const {
    return states_[seeds.vertices[p]].is_fixed &&
           states_[seeds.vertices[p]].label == seeds.labels[p] &&
           front_[seeds.vertices[p]].radius == 0;
  }

  // -- ways
  // ----------------------------------------------------------------------------------------

  // The best way of a front to a vertex, and the corner and the way itself.
  struct Best {
    double distance = kInfinity;
    Row corner = kNone;
    bool crosses = false, from_b = false;
  };

  Characteristic way_to(Index v) const {
    const Row start = corners_.starts[v], end = corners_.ends[v], last = corners_.starts[v + 1];
    Best best;
    look_for(v, start, end, best);
    if (last > end && !(best.distance <= front_[v].distance * (1 + kMissed)))
      look_for(v, end, last, best);
    if (best.corner == kNone) return {};
    return best.crosses ? across_edge(best.corner) : along_edge(best.corner, best.from_b);
  }

  void look_for(Index v, Row begin, Row end, Best& best) const {
    const double own = distance(v);
    for (Row place = begin; place < end; ++place) {
      const Corner& corner = corners_.around[place];
      const double by_a = distance(corner.a) + corner.to_a, by_b = distance(corner.b) + corner.to_b;
      if (distance(corner.a) < own && by_a < best.distance) best = {by_a, place, false, false};
      if (distance(corner.b) < own && by_b < best.distance) best = {by_b, place, false, true};
    }
    for (Row first = begin; first < end; first += kAtOnce) {
      const int n = std::min<int>(kAtOnce, end - first);
      const auto arrivals = across(edges_of(first, n));
      for (int i = 0; i < n; ++i) {
        const double limit = best.crosses ? best.distance : best.distance / kTie;
        const double found = arrivals.distance[i];
        const Corner& corner = corners_.around[first + i];
        if (found < limit && std::min(distance(corner.a), distance(corner.b)) < own)
          best = {found, first + i, true, false};
      }
    }
  }

  // The edges opposite a vertex in some of its corners, and as many more without a length.
  Edges<Lanes> edges_of(Row first, int n) const {
    const auto of = [&](auto number, double none) {
      return Lanes::of([&](int i) { return i < n ? number(corners_.around[first + i]) : none; });
    };
    return {of([&](const Corner& it) { return distance(it.a); }, 0.0),
            of([&](const Corner& it) { return distance(it.b); }, 0.0),
            of([&](const Corner& it) { return front_[it.a].radius; }, 1.0),
            of([&](const Corner& it) { return front_[it.b].radius; }, 1.0),
            of([&](const Corner& it) { return edge_of(it); }, -1.0),
            of([&](const Corner& it) { return it.to_a; }, 1.0),
            of([&](const Corner& it) { return it.to_b; }, 1.0)};
  }

  // Where the surface ends, only fronts that begin on an edge run along it.
  double edge_of(const Corner& corner) const {
    if (corner.edge > 0) return corner.edge;
    const bool begins = states_[corner.a].is_fixed && states_[corner.b].is_fixed &&
                        distance(corner.a) + distance(corner.b) <= -corner.edge * (1 + kSame);
    return begins ? -corner.edge : corner.edge;
  }

  // The rotation along the edge from one of the other vertices of its corner to a vertex: NaN where
  // the star of the former lacks the edge.
  double rotation_from(Index v, bool from_b) const {
    const Row place = ways_[v].corner;
    const Corner& corner = corners_.around[place];
    const std::uint32_t from = from_b ? corner.b : corner.a, third = from_b ? corner.a : corner.b;
    double away = std::numeric_limits<double>::quiet_NaN();
    for (Row there = corners_.starts[from]; there < corners_.starts[from + 1]; ++there) {
      const Corner& its = corners_.around[there];
      const bool is_first = its.a == v;
      if (!is_first && its.b != v) continue;
      const auto [direction, turn] = bearings_[there];
      away = is_first ? direction : direction + turn;
      if ((is_first ? its.b : its.a) == third) break;
    }
    const auto [direction, turn] = bearings_[place];
    return direction + (from_b ? turn : 0.0) + kPi - away;
  }

  Characteristic along_edge(Row place, bool from_b) const {
    const auto [direction, turn] = bearings_[place];
    const Corner& corner = corners_.around[place];
    Characteristic way;
    way.a = way.b = static_cast<Row>(from_b ? corner.b : corner.a);
    way.step = from_b ? corner.to_b : corner.to_a;
    way.arrival = direction + (from_b ? turn : 0.0) + kPi;
    way.corner = place;
    way.along_b = from_b;
    return way;
  }

  // In the plane, with a at the origin, b at (edge, 0) and the vertex at (x, y): as `across`.
  Characteristic across_edge(Row place) const {
    const Corner& corner = corners_.around[place];
    const double edge = edge_of(corner),
                 x = (edge * edge + (corner.to_a - corner.to_b) * (corner.to_a + corner.to_b)) /
                     (2 * edge);
    const double y = std::sqrt(std::max(squared(corner.to_a) - x * x, 0.0));
    const Front &at_a = front_[corner.a], &at_b = front_[corner.b];
    using Lane = Pack<2>;
    const auto alike = [](double number) { return Lane::spread(number); };
    const Edges<Lane> one{alike(at_a.distance), alike(at_b.distance), alike(at_a.radius),
                          alike(at_b.radius),   alike(edge),          alike(corner.to_a),
                          alike(corner.to_b)};
    const double mean = (at_a.distance + at_b.distance) / 2;
    const double radius = radius_on(one, alike(mean))[0], sign = radius > 0 ? 1.0 : -1.0;
    const double ahead = at_a.distance - at_b.distance;
    const double centre_x = edge / 2 + radius * ahead / edge, radius_a = radius + ahead / 2;
    const double below = std::sqrt(std::max(squared(radius_a) - squared(centre_x), 0.0));
    const double rise = sign * y + below, aside = x - centre_x;
    const double crossing = std::clamp(x - sign * aside * y / rise, 0.0, edge);
    Characteristic way;
    way.a = static_cast<Row>(corner.a);
    way.b = static_cast<Row>(corner.b);
    way.edge = edge;
    way.radius_a = std::abs(radius_a);
    way.radius_b = std::abs(radius - ahead / 2);
    way.radius = std::sqrt(aside * aside + rise * rise);
    way.step = sign * way.radius - radius;
    // Angles at the centre between the rays to a, to the vertex and to b; then those at the vertex.
    const double part =
        angle(below * rise - centre_x * aside, std::max(centre_x * rise + below * aside, 0.0));
    way.whole = angle(below * below - centre_x * (edge - centre_x), edge * below);
    way.share = way.whole > 0 ? std::min(part / way.whole, 1.0) : crossing / edge;
    const double full = angle(x * (x - edge) + y * y, y * edge);
    const double from_a = angle(x * (x - crossing) + y * y, y * crossing);
    const auto [direction, turn] = bearings_[place];
    way.arrival = direction + kPi + (full > 0 ? from_a / full : crossing / edge) * turn;
    way.corner = place;
    return way;
  }

  // -- what is carried
  // -----------------------------------------------------------------------------

  // Set the directions of the neighbours of a point that its front reached straight.
  void begin_about(Row source, Row label) {
    const auto tell = [&](std::uint32_t near, double direction, double length, double scale) {
      State& state = states_[near];
      const double way = distance(near) - distance(source);
      if (static_cast<Row>(near) == source || std::abs(way - length) > kSame * distance(near))
        return;
      if (state.is_fixed && state.label != label) return;
      const double bend = curvature_[source] * squared(length);
      const double arrival = ways_[near].a == kNone ? state.arrival : ways_[near].arrival;
      state = {direction,    length / scale * (1 - bend / 6),
               1 - bend / 2, arrival - direction,
               arrival,      0.0,
               0.0,          label,
               true};
    };
    for (Row place = corners_.starts[source]; place < corners_.starts[source + 1]; ++place) {
      const Corner& corner = corners_.around[place];
      const auto [direction, turn] = bearings_[place];
      const double angle = corner_angle(corner.to_a, corner.to_b, std::abs(corner.edge));
      const double scale = angle > 0 ? std::abs(turn) / angle : 1.0;
      tell(corner.a, direction, corner.to_a, scale);
      tell(corner.b, direction + turn, corner.to_b, scale);
    }
  }

  // Vertices come in an order in which their neighbours in memory are far away.
  void prefetch_soon(Row v) const {
    const Characteristic& way = ways_[v];
    prefetch(&way);
    prefetch(&way.radius);
    prefetch(&states_[v]);
    prefetch(&corners_.around[corners_.starts[v]]);
  }

  // Return where in the order a vertex is that waits now, or the end where it does not.
  Index await(Row v) {
    const Index place = place_of_[v];
    if (is_pending_[place]) return place;
    if (ends_[v].a == kNone || n_times_[v] == kMostTimes) return n_vertices();
    ++n_times_[v];
    is_pending_[place] = true;
    return place;
  }

  // Return where the first one of them is. In a fan each neighbour is in two corners, one after the
  // other.
  Index await_followers(Row v) {
    Index first = n_vertices();
    const auto look_at = [&](std::uint32_t near) {
      const Ends& from = ends_[near];
      if (from.a == v || from.b == v) first = std::min(first, await(static_cast<Row>(near)));
    };
    const Row end = corners_.starts[v + 1];
    for (Row place = corners_.starts[v]; place < end; ++place) {
      const Corner& corner = corners_.around[place];
      look_at(corner.a);
      if (place + 1 == end || corners_.around[place + 1].a != corner.b) look_at(corner.b);
    }
    return first;
  }

  static bool has_changed(const State& before, const State& now) {
    return before.label != now.label || !(std::abs(before.angle - now.angle) <= kSettled) ||
           !(std::abs(before.arrival - now.arrival) <= kSettled) ||
           std::abs(turn_of(before.rotation - now.rotation)) > kSettled;
  }

  void carry_to(Row v) {
    const Characteristic& way = ways_[v];
    const bool from_a = states_[way.a].label != kNone, from_b = states_[way.b].label != kNone;
    if (!from_a && !from_b) return;
    states_[v].arrival = way.arrival;
    if (way.a == way.b) {
      carry_along(v);
    } else if (!from_a || !from_b || is_meeting(way)) {
      carry_from_nearer(v, from_a, from_b);
    } else {
      carry_across(v);
    }
  }

  // A rotation that was carried from edge to edge, and how far it may be off.
  struct Rotation {
    double angle, error;
  };

  // Take the rotation that is carried, if that is more accurate than the directions of departure
  // and arrival. The latter come from distances, which are off behind the meeting of two fronts by
  // what is `mixed` at the ends of the edge; what is carried goes wrong with the curvature between
  // them. The geodesics in the shadow of a corner have turned about it, which the directions of
  // those beside it contain in part.
  template <class Carry>
  void settle(Row v, double mixed, const Carry& carry) {
    State& state = states_[v];
    const bool is_bent = state.spread > kLit;
    state.rotation = state.arrival - state.angle;
    state.error = mixed;
    if (!circle_.directions || !(is_bent || mixed > kSettled)) return;
    const Rotation carried = carry();
    if (std::isnan(carried.angle) || !(is_bent || carried.error < mixed)) return;
    if (is_bent)
      state.mixed = std::max(state.mixed, std::abs(turn_of(state.rotation - carried.angle)));
    state.rotation = carried.angle;
    state.error = carried.error;
  }

  void carry_along(Row v) {
    const Characteristic& way = ways_[v];
    const State& from = states_[way.a];
    State& state = states_[v];
    const double radius = front_[way.a].radius;
    state.angle = from.angle;
    state.label = from.label;
    state.mixed = from.mixed;
    state.slope = from.slope - curvature_[v] * from.spread * way.step;
    if (radius == 0 && circle_.directions) {
      state.spread = way.step;
      state.slope = 1;
    } else if (radius == 0 || reflex_[way.a]) {
      state.spread = kShadow;
    } else {
      const double widened = 1 + way.step / radius - curvature_[v] * squared(way.step) / 2;
      state.spread = from.spread * std::max(widened, kFocus);
    }
    settle(v, from.mixed,
           [&] { return Rotation{from.rotation + rotation_from(v, way.along_b), from.error}; });
  }

  // Angles are spread over the angle at the centre of the front, by so many that go to one of that;
  // linearly along the edge. In the shadow of a corner these are none.
  void carry_across(Row v) {
    const Characteristic& way = ways_[v];
    const State &from_a = states_[way.a], &from_b = states_[way.b];
    if (circle_.directions && is_in_shadow(from_a) != is_in_shadow(from_b))
      return carry_beside_shadow(v);
    State& state = states_[v];
    const double at_a = way.radius_a / from_a.spread, at_b = way.radius_b / from_b.spread;
    const double here = at_a + (at_b - at_a) * way.share, all = at_a + at_b;
    const double part = all > 0 ? way.share * (at_a + here) / all : way.share;
    state.angle = from_a.angle + part * within_turn(from_b.angle - from_a.angle, circle_);
    state.label = from_a.label;
    const double bend = (curvature_[way.a] + curvature_[way.b] + curvature_[v]) / 3;
    const double spread = way.radius / here * (1 - bend * squared(way.step) / 2);
    state.spread = std::min(std::max(spread, kFocus * way.step), kShadow);
    state.slope =
        from_a.slope + part * (from_b.slope - from_a.slope) - bend * state.spread * way.step;
    state.mixed = from_a.mixed + way.share * (from_b.mixed - from_a.mixed);
    settle(v, std::max(from_a.mixed, from_b.mixed), [&] {
      const double by_a = from_a.rotation + rotation_from(v, false);
      const double apart = turn_of(from_b.rotation + rotation_from(v, true) - by_a);
      const double unknown = std::max(std::abs(apart) - from_a.error - from_b.error, 0.0);
      const double error = from_a.error + part * (from_b.error - from_a.error);
      return Rotation{by_a + part * apart, error + kDoubt * part * (1 - part) * unknown};
    });
  }

  static bool is_in_shadow(const State& state) { return state.spread >= kShadow; }

  // Where the shadow of a corner begins between the ends of an edge, what the lit end carries on
  // alone is right up to the angle of the shadow, which is constant. The mean of both would make
  // the shadow wider and lighter from edge to edge.
  void carry_beside_shadow(Row v) {
    const Characteristic& way = ways_[v];
    const bool a_is_lit = is_in_shadow(states_[way.b]);
    const Row lit = a_is_lit ? way.a : way.b, dark = a_is_lit ? way.b : way.a;
    const std::optional<Beyond> alone = beyond(v, lit);
    State& state = states_[v];
    state.label = states_[dark].label;
    const double turn = within_turn(states_[dark].angle - states_[lit].angle, circle_);
    const double own = alone ? std::copysign(1.0, turn) * (alone->angle - states_[lit].angle) : 0.0;
    if (alone && own < std::abs(turn)) {
      state.angle = alone->angle;
      state.arrival = alone->arrival;
      state.spread = alone->spread;
    } else {
      state.angle = states_[dark].angle;
      state.spread = kShadow;
    }
    const State &from_a = states_[way.a], &from_b = states_[way.b];
    state.slope = states_[lit].slope;
    state.mixed = from_a.mixed + way.share * (from_b.mixed - from_a.mixed);
    settle(v, std::max(from_a.mixed, from_b.mixed), [&] {
      const double by_a = from_a.rotation + rotation_from(v, false);
      const double apart = turn_of(from_b.rotation + rotation_from(v, true) - by_a);
      return Rotation{by_a + way.share * apart,
                      from_a.error + way.share * (from_b.error - from_a.error)};
    });
  }

  // Whether the ends of an edge have been reached by fronts that have nothing to do with each
  // other.
  bool is_meeting(const Characteristic& way) const {
    const State &a = states_[way.a], &b = states_[way.b];
    if (a.label != b.label) return true;
    const double turn = std::abs(within_turn(b.angle - a.angle, circle_));
    if (turn <= kSettled) return false;
    const double per_angle = (way.radius_a / a.spread + way.radius_b / b.spread) / 2;
    return std::abs(turn - way.whole * per_angle) * std::min(a.spread, b.spread) >
           kMeeting * way.edge;
  }

  // Take the data of the front at one of the ends of an edge, carried on alone.
  void carry_from_nearer(Row v, bool from_a, bool from_b) {
    const Characteristic& way = ways_[v];
    std::optional<Beyond> best = from_a ? beyond(v, way.a) : std::nullopt;
    std::optional<Beyond> other = from_b ? beyond(v, way.b) : std::nullopt;
    if (other && (!best || other->distance < best->distance)) std::swap(best, other);
    State& state = states_[v];
    const bool is_a = best ? best->from == way.a : from_a && (way.share < 0.5 || !from_b);
    const State& near = states_[is_a ? way.a : way.b];
    state.label = near.label;
    state.angle = best ? best->angle : near.angle;
    state.spread = best ? best->spread : near.spread + std::abs(way.step);
    if (best) state.arrival = best->arrival;
    const double bend = (curvature_[is_a ? way.a : way.b] + curvature_[v]) / 2;
    state.slope = near.slope - bend * near.spread * way.step;
    // Between the geodesics to both, whose angle changes by the slope for one at the source.
    const double holonomy = (1 - near.slope) * (state.angle - near.angle);
    state.mixed = !from_a || !from_b ? near.mixed  // the other end is not final yet
                  : best && other    ? std::abs(turn_of(best->arrival - other->arrival))
                                     : kPi;
    settle(v, state.mixed, [&] {
      return Rotation{near.rotation + rotation_from(v, !is_a) - holonomy, near.error};
    });
  }

  // The data that the front at a single vertex carries to a neighbour.
  struct Beyond {
    double distance, angle, arrival, spread;
    Row from;
  };

  // A triangle of an edge as both ends of it see it.
  struct Both {
    Row at_from, at_to;
    bool is_first;  // whether the other end comes first about `from`
  };

  std::optional<Both> triangle_of(Row from, Row to) const {
    for (Row one = corners_.starts[from]; one < corners_.starts[from + 1]; ++one) {
      const Corner& corner = corners_.around[one];
      const bool is_first = static_cast<Row>(corner.a) == to;
      if (!is_first && static_cast<Row>(corner.b) != to) continue;
      const std::uint32_t third = is_first ? corner.b : corner.a;
      for (Row two = corners_.starts[to]; two < corners_.starts[to + 1]; ++two) {
        const Corner& other = corners_.around[two];
        if (static_cast<Row>(is_first ? other.b : other.a) == from &&
            (is_first ? other.a : other.b) == third)
          return Both{one, two, is_first};
      }
    }
    return std::nullopt;
  }

  // In the plane with `from` at the origin and `to` on the x axis.
  std::optional<Beyond> beyond(Row to, Row from) const {
    const std::optional<Both> both = triangle_of(from, to);
    const double radius_before = front_[from].radius;
    if (!both || radius_before == 0 || std::isnan(states_[from].arrival)) return std::nullopt;
    const bool is_first = both->is_first;
    const Corner& corner = corners_.around[both->at_from];
    const double length = is_first ? corner.to_a : corner.to_b;
    const State& state = states_[from];
    const auto [direction, scale] = edge_bearing(both->at_from, is_first);
    const double way = turn_of(state.arrival - direction) / scale;
    const double dx = std::cos(way), dy = std::sin(way);
    const double most = length / kStraight;
    const double radius = std::abs(radius_before) < most ? radius_before : most;
    const double sign = radius > 0 ? 1.0 : -1.0;
    const double px = length + dx * radius, py = dy * radius;  // from the centre of the front
    const double ahead = (px * dx + py * dy) * sign, after = std::sqrt(px * px + py * py);
    if (!(ahead > 0)) return std::nullopt;
    const double step = sign * after - radius;
    const double turn = std::atan2((dx * py - dy * px) * sign, ahead);
    const double q = state.spread / std::abs(radius);
    const double bend = (curvature_[from] + curvature_[to]) / 2;
    const double spread = std::max(q * after * (1 - bend * step * step / 2), kFocus * length);
    // Back along the ray, from the direction in which `to` sees `from`.
    const double off = turn_of(std::atan2(-py * sign, -px * sign) - kPi);
    const auto [back, scale_there] = edge_bearing(both->at_to, !is_first);
    return Beyond{front_[from].distance + step, state.angle + std::copysign(turn / q, turn * scale),
                  back + off * scale_there + kPi, spread, from};
  }

  struct EdgeBearing {
    double direction, scale;  // in the frame, and by how much angles are larger there
  };

  // Of the first edge of a corner, or the second.
  EdgeBearing edge_bearing(Row place, bool first) const {
    const auto [direction, turn] = bearings_[place];
    const Corner& corner = corners_.around[place];
    const double angle = corner_angle(corner.to_a, corner.to_b, std::abs(corner.edge));
    return {first ? direction : direction + turn, angle > 0 && turn != 0 ? turn / angle : 1.0};
  }

  static double turn_of(double angle) {
    return angle - 2 * kPi * std::floor(angle / (2 * kPi) + 0.5);
  }

  // Give a vertex without data those of its nearest neighbour.
  void carry_to_left(Row v) {
    State& state = states_[v];
    if (state.label != kNone || !(distance(v) < kInfinity)) return;
    double least = kInfinity;
    for (Row place = corners_.starts[v]; place < corners_.starts[v + 1]; ++place) {
      const Corner& corner = corners_.around[place];
      const auto look_at = [&](std::uint32_t near, double length, bool from_b) {
        if (states_[near].label == kNone || !(distance(near) + length < least)) return;
        least = distance(near) + length;
        ways_[v] = along_edge(place, from_b);
      };
      look_at(corner.a, corner.to_a, false);
      look_at(corner.b, corner.to_b, true);
    }
    if (!(least < kInfinity)) return;
    state.arrival = ways_[v].arrival;
    carry_along(v);
  }

  const Corners& corners_;
  std::span<const Bearing> bearings_;
  std::span<const double> curvature_;
  std::span<const bool> reflex_;
  Circle circle_;
  Array<Front> front_;
  Array<Characteristic> ways_;
  Array<State> states_;
  Array<Ends> ends_;     // kNone at fixed vertices; apart, as many look at them
  Array<Row> place_of_;  // of vertices in the order
  Array<std::uint8_t> n_times_;
  Array<bool> is_pending_;  // in the order
};

}  // namespace

Tracer::Tracer(Corners corners, Array<Bearing> bearings, std::span<const double> curvature,
               std::span<const bool> reflex)
    : corners_(std::move(corners)),
      bearings_(std::move(bearings)),
      curvature_(count(curvature)),
      reflex_(count(reflex)) {
  std::ranges::copy(curvature, curvature_.begin());
  std::ranges::copy(reflex, reflex_.begin());
}

Carried Tracer::carry(const SweptFronts& fronts, const Seeds& seeds, const Circle& circle) const {
  Way way(corners_, bearings_, curvature_, reflex_, fronts, circle);
  way.begin(seeds);
  way.carry_on();
  return way.result();
}

}  // namespace geodesic
