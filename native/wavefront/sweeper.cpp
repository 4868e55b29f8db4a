#include "wavefront/sweeper.hpp"

#include <bit>

#include "core/processor.hpp"
#include "core/threads.hpp"
#include "wavefront/crossing.hpp"

namespace geodesic {
namespace {

using Lanes = Pack<kSpokes>;

// Vertices between the one that is visited and the one whose neighbours are fetched from memory.
// Its fans have been as many before, and where they are as many before that.
constexpr Index kAhead = 12;

// Up to this many times the least distance an edge goes before what comes across one: a ray along
// an edge does both, and rounding must not say which, as the radius differs.
constexpr double kTie = 1 + 1e-12;

// Up to this many times its length the distances at the ends of an edge are together where the
// front begins on it; rounding makes them more than the length.
constexpr double kOnEdge = 1 + 1e-9;

// More than any distance that is finite.
constexpr double kLarge = std::numeric_limits<double>::max();

// What a vertex knows: the front there, the curvature K of the surface, its place in the order, and
// whether it is to be visited.
struct Vertex {
  Front front;
  double curvature;
  Row rank;
  bool pending;
};

// The vertices at the ends of the spokes of a fan.
struct Ring {
  const Fan* fan;
  Lanes distance, radius;

  Ring(const Fan& of, const Vertex* vertices)
      : fan(&of),
        distance(Lanes::of([&](int i) { return vertices[of.neighbour[i]].front.distance; })),
        radius(Lanes::of([&](int i) { return vertices[of.neighbour[i]].front.radius; })) {}

  // The edges opposite the centre. Nothing comes across those in which the surface ends, as there
  // is nothing behind: their lengths are less than zero.
  GT_INLINE Edges<Lanes> rim() const {
    const Lanes to = Lanes::load(fan->to);
    return {distance, turned(distance), radius, turned(radius), Lanes::load(fan->edge),
            to,       turned(to)};
  }
};

// A fan, or none, about a vertex whose front has improved: what was known at the ends of the
// spokes, and who of them has been told. Who else gains is to be found out.
struct Telling {
  const Fan* fan = nullptr;
  Front front{};
  double distance[kSpokes];
  unsigned told = 0;
};

// Sweeps of one set of sources after the other.
class Sweep {
 public:
  Sweep(const Fans& fans, std::span<const double> curvature, std::span<const bool> reflex)
      : fans_(fans.fans.data()),
        starts_(fans.starts.data()),
        own_ends_(fans.ends),
        curvature_(curvature),
        reflex_(reflex),
        vertices_(fans.ends.size()) {}

  std::span<const Vertex> vertices() const { return vertices_; }

  // Begin with set k, which the order belongs to. The nearest counts where there are several at a
  // vertex. Where heat comes to every vertex the first sweep is sure to visit all of them, so that
  // nobody need be told.
  void begin(std::span<const Row> order, const HeatTable& heat, const Sources& sources, Index k) {
    order_ = order;
    ends_ = own_ends_.data();
    tolerance_ = sources.tolerances[k];
    all_await_ = !order.empty() && heat.reaches(order.back(), k);
    for (Index rank = 0; rank < count(order); ++rank) {
      const Row v = order[rank];
      vertices_[v] = {{kInfinity, 1.0}, curvature_[v], static_cast<Row>(rank), all_await_};
    }
    n_pending_ = all_await_ ? n_ranks() : 0;
    for (Index p = sources.begins[k]; p < sources.begins[k + 1]; ++p) {
      Front& front = vertices_[sources.vertices[p]].front;
      if (sources.distances[p] <= front.distance)
        front = {sources.distances[p], inverse(sources.curvatures[p])};
    }
    for (Index p = sources.begins[k]; p < sources.begins[k + 1]; ++p)
      begin_beside(sources.vertices[p]);
    for (Index p = sources.begins[k]; p < sources.begins[k + 1]; ++p) {
      const Index v = sources.vertices[p];
      for (Row fan = starts_[v]; fan < starts_[v + 1]; ++fan)
        for (const std::uint32_t neighbour : fans_[fan].neighbour) await(vertices_[neighbour]);
    }
  }

  // Whether any vertex is to be visited.
  bool is_under_way() const { return n_pending_ > 0; }

  // Whether every vertex has a distance that set k sends heat to.
  bool has_reached_all(const HeatTable& heat, Index k) const {
    for (Index v = 0; v < vertices_.size(); ++v)
      if (!std::isfinite(vertices_[v].front.distance) && heat.reaches(v, k)) return false;
    return true;
  }

  // Visit the pending vertices in their order once. Whoever gains from a vertex that improved is
  // pending. Where one of them comes earlier in the order, the sweep returns to it at once, before
  // what it will improve spreads; but only so many times.
  //
  // Who gains across an edge is found out when the next vertex has been visited: by then the front
  // is known, and nothing has to wait for it. Sweeps take 0.88 of the time with registers of eight
  // numbers, and 0.97 with four.
  void run(Index returns) {
    Index rank = 0;
    const auto go_on = [&](Index earliest) {
      if (earliest >= rank || returns == 0) return;
      rank = earliest;
      --returns;
    };
    Telling tellings[2];
    Telling *own = tellings, *last = tellings + 1;
    const auto finish_last = [&] {
      if (!last->fan) return;
      go_on(tell_rest(*last));
      last->fan = nullptr;
    };
    do {
      while (rank < n_ranks() && n_pending_ > 0) {
        look_ahead(rank + 1);
        const Row v = order_[rank++];
        if (!vertices_[v].pending) continue;
        vertices_[v].pending = false;
        --n_pending_;
        go_on(visit(v, *own));
        finish_last();
        std::swap(own, last);
      }
      finish_last();
    } while (rank < n_ranks() && n_pending_ > 0);
  }

  // Stars need not be mutual: who is heard by the reached but hears none of them itself now listens
  // to every triangle that it is part of. Return whether there are any.
  bool open_ears(const HeatTable& heat, Index k) {
    for (Index v = 0; v < vertices_.size(); ++v) {
      if (std::isfinite(vertices_[v].front.distance) || !heat.reaches(v, k)) continue;
      if (ends_[v] == starts_[v + 1]) continue;
      if (heard_.empty()) heard_ = Array<Row>(vertices_.size());
      if (ends_ != heard_.data()) {
        std::ranges::copy(own_ends_, heard_.begin());
        ends_ = heard_.data();
      }
      heard_[v] = starts_[v + 1];
      await(vertices_[v]);
    }
    return n_pending_ > 0;
  }

 private:
  Index n_ranks() const { return count(order_); }

  void await(Vertex& vertex) {
    n_pending_ += !vertex.pending;
    vertex.pending = true;
  }

  // Let fronts that begin on an edge in which the surface ends come to the vertex opposite it, for
  // all such edges of a source vertex. To a front that comes later the edge is no way in.
  void begin_beside(Row source) {
    for (Row fan = starts_[source]; fan < starts_[source + 1]; ++fan)
      for (const std::uint32_t opposite : fans_[fan].neighbour)
        for (Row its = starts_[opposite]; its < starts_[opposite + 1]; ++its)
          for (int i = 0; i < kSpokes; ++i)
            if (fans_[its].edge[i] < 0) begin_across(fans_[its], i, static_cast<Row>(opposite));
  }

  void begin_across(const Fan& fan, int i, Row v) {
    using Lane = Pack<2>;
    const int j = (i + 1) % kSpokes;
    Vertex& opposite = vertices_[v];
    const Vertex &a = vertices_[fan.neighbour[i]], &b = vertices_[fan.neighbour[j]];
    const double edge = -fan.edge[i];
    if (!(a.front.distance + b.front.distance <= edge * kOnEdge)) return;
    const auto arrivals =
        across<Lane>({Lane::spread(a.front.distance), Lane::spread(b.front.distance),
                      Lane::spread(a.front.radius), Lane::spread(b.front.radius),
                      Lane::spread(edge), Lane::spread(fan.to[i]), Lane::spread(fan.to[j])});
    if (!(arrivals.distance[0] < opposite.front.distance)) return;
    const double bend = (opposite.curvature + a.curvature + b.curvature) / 3;
    opposite.front = {arrivals.distance[0], bent(arrivals.radius[0], arrivals.step[0], bend)};
    for (Row its = starts_[v]; its < starts_[v + 1]; ++its)
      for (const std::uint32_t neighbour : fans_[its].neighbour) await(vertices_[neighbour]);
  }

  // Visit a vertex; return the least rank of those who are known to gain from it.
  GT_INLINE Index visit(Row v, Telling& telling) {
    const Row start = starts_[v], end = starts_[v + 1];
    const double enough = vertices_[v].front.distance - tolerance_;
    Front found{enough, 0.0};
    if (end - start == 1) {  // most have one fan, of which everything stays in registers
      const Ring ring(fans_[start], vertices_.data());
      look_for(ring, v, found);
      if (!(found.distance < enough)) return without_gain(v);
      vertices_[v].front = found;
      return tell(ring, found, telling);
    }
    for (Row fan = start; fan < ends_[v]; ++fan) look_for({fans_[fan], vertices_.data()}, v, found);
    if (!(found.distance < enough)) return without_gain(v);
    vertices_[v].front = found;
    Index earliest = n_ranks();
    for (Row fan = start; fan < end; ++fan) {
      if (telling.fan) earliest = std::min(earliest, tell_rest(telling));
      earliest = std::min(earliest, tell({fans_[fan], vertices_.data()}, found, telling));
    }
    return earliest;
  }

  // A vertex that was visited too soon has to be told when there is something for it.
  Index without_gain(Row v) {
    all_await_ &= std::isfinite(vertices_[v].front.distance);
    return n_ranks();
  }

  // Put down what a fan has for vertex v, if it is better than what was found before.
  GT_INLINE void look_for(const Ring& ring, Row v, Front& found) const {
    const Arrivals<Lanes> arrivals = across(ring.rim());
    const Lanes to = Lanes::load(ring.fan->to), by_edge = ring.distance + to;
    const double best = choose(arrivals.distance, by_edge, arrivals.distance, by_edge).least();
    if (!(best < found.distance)) return;
    // What comes along edges, and behind it what comes across them: no branch, which would wait for
    // the distance, and the next vertex with it.
    double radii[2 * kSpokes], steps[2 * kSpokes];
    (ring.radius + to).store(radii);
    to.store(steps);
    arrivals.radius.store(radii + kSpokes);
    arrivals.step.store(steps + kSpokes);
    const Lanes limit = Lanes::spread(best), near_limit = Lanes::spread(best * kTie);
    const unsigned later = below(near_limit, by_edge) | below(limit, arrivals.distance) << kSpokes;
    const int way = std::countr_zero(~later) & (2 * kSpokes - 1), lane = way % kSpokes;
    const bool crosses = way >= kSpokes;
    const auto near = ring.fan->neighbour[lane];
    const double step = steps[way], least = 1e-12 * step;
    double radius = radii[way];
    double bend = vertices_[v].curvature + vertices_[near].curvature;
    bend += kShare[crosses] * vertices_[ring.fan->neighbour[(lane + 1) % kSpokes]].curvature;
    bend *= kMean[crosses];
    if (!crosses && !(vertices_[near].front.radius > 0 && !reflex_[near])) [[unlikely]] {
      const double before = reflex_[near] ? 0.0 : vertices_[near].front.radius;
      radius = wider(before, step);  // about a corner of the boundary: a circle about it
      if (before == 0) bend = 0.0;
    }
    radius = std::copysign(std::max(std::abs(radius), least), radius);
    found = {best, bent(radius, step, bend)};
  }

  // Let those of a fan be pending who gain from the front at its centre along an edge; return the
  // least of their ranks.
  GT_INLINE Index tell(const Ring& ring, const Front& front, Telling& telling) {
    const Lanes limit = ring.distance - Lanes::spread(tolerance_);
    const Lanes to = Lanes::load(ring.fan->to);
    const Lanes distance = Lanes::spread(front.distance);
    // Who has not been reached gains whatever comes: the processor need not wait for that.
    const unsigned unreached =
        below(Lanes::spread(kLarge), ring.distance) & below(to, Lanes::spread(kInfinity));
    Index earliest = all_await_ ? n_ranks() : await_all(*ring.fan, unreached);
    const unsigned along_edge = below(distance + to, limit);
    if (const unsigned more = along_edge & ~unreached) [[unlikely]]
      earliest = std::min(earliest, await_all(*ring.fan, more));
    telling.fan = ring.fan;
    telling.front = front;
    telling.told = along_edge;
    ring.distance.store(telling.distance);
    return earliest;
  }

  // The same across edges: for each spoke across that from the centre to the next, and for the next
  // across that to this one.
  GT_INLINE Index tell_rest(const Telling& it) {
    const Lanes known = Lanes::load(it.distance), limit = known - Lanes::spread(tolerance_);
    const Lanes to = Lanes::load(it.fan->to), next_to = turned(to),
                edge = Lanes::load(it.fan->edge);
    const Lanes distance = Lanes::spread(it.front.distance),
                radius = Lanes::spread(it.front.radius);
    const unsigned one =
        may_gain<Lanes>(limit, {distance, turned(known), radius, radius, next_to, to, edge});
    const unsigned other =
        may_gain<Lanes>(turned(limit), {distance, known, radius, radius, to, next_to, edge});
    Index earliest = n_ranks();
    for (unsigned who = one & ~it.told; who; who &= who - 1) {
      const int spoke = std::countr_zero(who);
      earliest = std::min(earliest, ask(*it.fan, spoke, (spoke + 1) % kSpokes, spoke, it.front));
    }
    for (unsigned who = other & ~before(it.told); who; who &= who - 1) {
      const int spoke = std::countr_zero(who);
      earliest = std::min(earliest, ask(*it.fan, (spoke + 1) % kSpokes, spoke, spoke, it.front));
    }
    return earliest;
  }

  // Let the vertex at the end of a spoke be pending if it gains across the edge from the centre to
  // the end of another; return its rank then.
  Index ask(const Fan& fan, int spoke, int other, int edge, const Front& front) {
    using Lane = Pack<2>;  // twice the same: there is no register of one number
    const Vertex &near = vertices_[fan.neighbour[spoke]], &far = vertices_[fan.neighbour[other]];
    const auto arrivals = across<Lane>(
        {Lane::spread(front.distance), Lane::spread(far.front.distance), Lane::spread(front.radius),
         Lane::spread(far.front.radius), Lane::spread(fan.to[other]), Lane::spread(fan.to[spoke]),
         Lane::spread(fan.edge[edge])});
    if (!(arrivals.distance[0] < near.front.distance - tolerance_)) return n_ranks();
    return await_all(fan, 1u << spoke);
  }

  // Let vertices at the ends of spokes be pending; return the least rank of those who were not.
  GT_INLINE Index await_all(const Fan& fan, unsigned who) {
    Index earliest = n_ranks();
    for (; who; who &= who - 1) {
      Vertex& near = vertices_[fan.neighbour[std::countr_zero(who)]];
      const Index rank = near.pending ? n_ranks() : near.rank;
      n_pending_ += !near.pending;
      near.pending = true;
      earliest = std::min(earliest, rank);
    }
    return earliest;
  }

  // Fetch what vertices will need: the order of the heat is none that memory could foresee. Of one
  // the place of its fans, of one before it these, and of one before that its neighbours.
  //
  // Inline, or else GCC finds a function without effects, and leaves its calls out.
  GT_INLINE void look_ahead(Index rank) const {
    if (rank + 3 * kAhead >= n_ranks()) return;
    const Row last = order_[rank + 3 * kAhead], later = order_[rank + 2 * kAhead],
              soon = order_[rank + kAhead];
    prefetch(&starts_[last]);
    prefetch(&vertices_[later]);
    const char* const fan = reinterpret_cast<const char*>(&fans_[starts_[later]]);
    for (std::size_t byte = 0; byte < sizeof(Fan); byte += 64) prefetch(fan + byte);
    for (const std::uint32_t neighbour : fans_[starts_[soon]].neighbour)
      prefetch(&vertices_[neighbour]);
  }

  // Of curvature along an edge and across one: the share of the second neighbour, and the mean.
  static constexpr double kShare[2] = {0.0, 1.0}, kMean[2] = {1.0 / 2, 1.0 / 3};
  static constexpr unsigned kAll = (1u << kSpokes) - 1;
  // The bits of spokes, each given to the one before.
  static unsigned before(unsigned bits) { return (bits >> 1 | bits << (kSpokes - 1)) & kAll; }

  const Fan* fans_;
  const Row* starts_;
  std::span<const Row> own_ends_;
  const Row* ends_ = nullptr;  // of the fans that vertices listen to
  Array<Row> heard_;           // the same, where they are others
  std::span<const double> curvature_;
  std::span<const bool> reflex_;
  std::span<const Row> order_;
  Array<Vertex> vertices_;
  double tolerance_ = 0.0;
  Index n_pending_ = 0;
  bool all_await_ = false;  // whether every vertex that has not been reached is to be visited
};

template <class T>
Array<T> copied(std::span<const T> values) {
  Array<T> result(count(values));
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

}  // namespace

Sweeper::Sweeper(const Corners& corners, std::span<const double> curvature,
                 std::span<const bool> reflex)
    : fans_(fans_of(corners)), curvature_(copied(curvature)), reflex_(copied(reflex)) {}

void Sweeper::sweep(const HeatTable& heat, const Sources& sources, const Effort& effort,
                    std::span<double> distances, std::span<double> kappas, int n_threads) const {
  const Index n = n_vertices(), n_sets = heat.n_columns;
  in_pieces(n_sets, (n_sets + n_threads - 1) / n_threads, n_threads, [&](Index begin, Index end) {
    Sweep sweep(fans_, curvature_, reflex_);
    const Array<Row> orders = falling(heat, begin, end);
    for (Index k = begin; k < end; ++k) {
      const Row* const order = orders.data() + (k - begin) * n;
      sweep.begin({order, static_cast<std::size_t>(n)}, heat, sources, k);
      for (Index sweeps = 0; sweep.is_under_way() || sweep.open_ears(heat, k); ++sweeps) {
        if (sweeps >= effort.most_sweeps && sweep.has_reached_all(heat, k)) break;
        sweep.run(sweeps < effort.steady ? 0 : effort.returns);
      }
      const std::span<const Vertex> vertices = sweep.vertices();
      for (Index v = 0; v < n; ++v) distances[k * n + v] = vertices[v].front.distance;
      if (kappas.empty()) continue;
      for (Index v = 0; v < n; ++v) kappas[k * n + v] = 1 / vertices[v].front.radius;
    }
  });
}

}  // namespace geodesic
