#include "wavefront/sweeper.hpp"

#include <bit>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "core/processor.hpp"
#include "core/threads.hpp"
#include "wavefront/crossing.hpp"

namespace geodesic {
namespace {

using Lanes = Pack<kSpokes>;

// Prefetch distance, in vertices of the order: the neighbours of a vertex are fetched so many
// visits ahead, its fans twice as many, and the positions of its fans three times as many.
constexpr Index kPrefetchDistance = 12;

// An update along an edge is preferred to an update across an edge up to this ratio of distances: a
// ray along an edge is both, and rounding must not decide, because the radii differ.
constexpr double kTieRatio = 1 + 1e-12;

// A front begins on an edge if the distances at its ends sum to at most this many times its length;
// rounding makes the sum larger than the length.
constexpr double kOnEdgeRatio = 1 + 1e-9;

// An upper bound of finite distances.
constexpr double kMaxDistance = std::numeric_limits<double>::max();

// How far beyond its limit the neighbours of vertices have to be known before a sweep ends, in the
// longest edges of the vertices within it. Fronts come from smaller distances to larger ones, but
// across an obtuse triangle a distance beyond the limit may still lower one within it. None of
// 147,000 distances differed from those without a limit with 0, none of 1.5 million with 2: meshes,
// some stretched or with obtuse triangles, and clouds.
constexpr double kEdgesBeyondLimit = 2;

// Number of vertices of the order that a sweep of near ones begins with, and the share of it by
// which it grows each time that they are too few. Results do not depend on them.
constexpr Index kFirstSlice = 64;
constexpr Index kSlicesOfOrder = 2;

// The state of a vertex: the front there, the curvature K of the surface, its position in the
// order, and whether a visit is pending.
struct Vertex {
  Front front;
  double curvature;
  Row position;
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

// A fan, or none, of a vertex whose front has improved: the distances at the ends of its spokes,
// and the spokes whose ends are pending already. The other ends are checked later.
struct Improvement {
  const Fan* fan = nullptr;
  Front front{};
  double distance[kSpokes];
  unsigned marked = 0;
};

// Sweeps over all vertices; over those near the sources, in the same order; or as fronts come to
// them.
enum class Extent { kWhole, kNear, kLimited };

// Sweeps of one set of sources after the other, or one in which fronts are limited; of sources with
// or without offsets.
template <Extent kExtent, bool kOffsets>
class Sweep {
  static constexpr bool kNear = kExtent == Extent::kNear, kLimited = kExtent == Extent::kLimited;

 public:
  Sweep(const Fans& fans, std::span<const double> curvature, std::span<const bool> reflex)
      : fans_(fans.fans.data()),
        starts_(fans.starts.data()),
        own_ends_(fans.ends),
        curvature_(curvature),
        reflex_(reflex),
        vertices_(fans.ends.size()) {}

  std::span<const Vertex> vertices() const { return vertices_; }

  // Begin with set k, which the order belongs to. The nearest source counts if there are several at
  // a vertex. If heat reaches every vertex, the first sweep visits all of them, so that all are
  // pending from the start.
  void begin(std::span<const Row> order, const HeatTable& heat, const Sources& sources, Index k) {
    order_ = order;
    ends_ = own_ends_.data();
    tolerance_ = sources.tolerances[k];
    all_pending_ = !order.empty() && heat.reaches(order.back(), k);
    for (Index position = 0; position < count(order); ++position) {
      const Row v = order[position];
      vertices_[v] = {{kInfinity, 1.0}, curvature_[v], static_cast<Row>(position), all_pending_};
    }
    n_pending_ = all_pending_ ? n_vertices() : 0;
    begin_at(sources, k);
  }

  // The same with the beginning of an order, which grows until vertices up to the limit are known.
  void begin_near(FallingKeys& keys, Index column, const Sources& sources, Index k, double limit) {
    forget(keys.are_heat[column]);
    slices_.begin(keys.column(column), keys.mosts[column], keys.number);
    order_ = {};
    limit_ = limit;
    is_near_done_ = false;
    ends_ = own_ends_.data();
    tolerance_ = sources.tolerances[k];
    n_pending_ = all_pending_ ? n_vertices() : 0;
    begin_at(sources, k);
  }

  // The vertices within the limit and around them, in any order.
  template <class Use>
  void for_each_near(const Use& use) const {
    const double farthest = limit_ + beyond_limit();
    for (const Row v : order_)
      if (vertices_[v].front.distance <= farthest) use(v, vertices_[v].front.distance);
    for (const Row v : touched_)
      if (vertices_[v].position == n_vertices() && vertices_[v].front.distance <= farthest)
        use(v, vertices_[v].front.distance);
  }

  // The same without an order: vertices are visited as fronts come to them, the earliest first, and
  // a front does not enter a vertex later than `latest`.
  void begin_limited(const Sources& sources, Index k, std::span<const double> latest) {
    latest_ = latest;
    ends_ = own_ends_.data();
    tolerance_ = sources.tolerances[k];
    for (Index v = 0; v < vertices_.size(); ++v)
      vertices_[v] = {{kInfinity, 1.0}, curvature_[v], 0, false};
    begin_at(sources, k);
  }

  // Visit pending vertices, at most so many.
  void run_limited(Index most_visits) {
    Improvement improvement;
    while (!queue_.empty() && most_visits > 0) {
      const Row v = queue_.top().second;
      queue_.pop();
      if (!vertices_[v].pending) continue;
      vertices_[v].pending = false;
      --most_visits;
      visit(v, improvement);
      if (!improvement.fan) continue;
      mark_across_edges(improvement);
      improvement.fan = nullptr;
    }
  }

  // True if any visit is pending.
  bool is_under_way() const { return n_pending_ > 0; }

  // True if every vertex that the heat of set k reaches has a distance.
  bool has_reached_all(const HeatTable& heat, Index k) const {
    for (Index v = 0; v < vertices_.size(); ++v)
      if (!std::isfinite(vertices_[v].front.distance) && heat.reaches(v, k)) return false;
    return true;
  }

  // Sweep until not a visit is pending, or those of set k up to the limit are known.
  void finish(const HeatTable& heat, Index k, const Effort& effort) {
    for (Index sweeps = 0; is_under_way() || use_all_triangles(heat, k); ++sweeps) {
      if (sweeps >= effort.most_sweeps && has_reached_all(heat, k)) break;
      run(sweeps < effort.steady ? 0 : effort.returns);
      if (kNear && is_near_done_) break;
    }
  }

  // Visit the pending vertices once in their order. Vertices that gain from an improved vertex
  // become pending. If one of them is earlier in the order, the sweep returns to it at once, before
  // the distances that it will improve are used; `returns` limits how often.
  //
  // Gains across edges are computed after the next vertex has been visited: by then the front is
  // known, and the processor does not wait for it. Sweeps take 0.88 of the time with registers of
  // eight numbers, and 0.97 with four.
  void run(Index returns) {
    Index position = 0;
    const auto return_to = [&](Index earliest) {
      if (earliest >= position || returns == 0) return;
      position = earliest;
      --returns;
    };
    Improvement improvements[2];
    Improvement *own = improvements, *last = improvements + 1;
    const auto finish_last = [&] {
      if (!last->fan) return;
      return_to(mark_across_edges(*last));
      last->fan = nullptr;
    };
    do {
      while (n_pending_ > 0 && has_position(position, returns)) {
        prefetch_later(position + 1);
        const Row v = order_[position++];
        if (!vertices_[v].pending) continue;
        vertices_[v].pending = false;
        --n_pending_;
        return_to(visit(v, *own));
        finish_last();
        std::swap(own, last);
      }
      finish_last();
    } while (n_pending_ > 0 && position < count(order_));
  }

  // Stars are not symmetric. A vertex that no reached vertex updates is now updated from all
  // triangles that contain it. Return whether there are any such vertices.
  bool use_all_triangles(const HeatTable& heat, Index k) {
    for (Index v = 0; v < vertices_.size(); ++v) {
      if (std::isfinite(vertices_[v].front.distance) || !heat.reaches(v, k)) continue;
      if (ends_[v] == starts_[v + 1]) continue;
      if (all_ends_.empty()) all_ends_ = Array<Row>(vertices_.size());
      if (ends_ != all_ends_.data()) {
        std::ranges::copy(own_ends_, all_ends_.begin());
        ends_ = all_ends_.data();
      }
      all_ends_[v] = starts_[v + 1];
      mark(static_cast<Row>(v));
    }
    return n_pending_ > 0;
  }

 private:
  Index n_vertices() const { return vertices_.size(); }

  // True if the order has such a position, or has it now.
  GT_INLINE bool has_position(Index position, Index returns) {
    if (position < count(order_)) return true;
    if constexpr (kNear) return grow(returns);
    return false;
  }

  // Let the order grow; return false if it is whole, or long enough.
  bool grow(Index returns) {
    if (is_near_done_ || slices_.is_whole()) return false;
    if (returns > 0 && knows_near()) {
      is_near_done_ = true;
      return false;
    }
    const Index begin = count(order_);
    slices_.add(std::max(kFirstSlice, begin / kSlicesOfOrder));
    order_ = slices_.order();
    for (Index position = begin; position < count(order_); ++position)
      vertices_[order_[position]].position = static_cast<Row>(position);
    return true;
  }

  // True if all neighbours of the vertices within the limit, and a little farther, are known.
  bool knows_near() const {
    if (order_.empty()) return false;
    const double farthest = limit_ + beyond_limit();
    const auto has_known_neighbours = [&](Row v) {
      const Vertex& vertex = vertices_[v];
      if (!(vertex.front.distance <= farthest)) return true;
      if (vertex.position == n_vertices()) return false;
      for (Row fan = starts_[v]; fan < starts_[v + 1]; ++fan)
        for (const std::uint32_t neighbour : fans_[fan].neighbour)
          if (vertices_[neighbour].position == n_vertices() ||
              !std::isfinite(vertices_[neighbour].front.distance))
            return false;
      return true;
    };
    return std::ranges::all_of(order_, has_known_neighbours) &&
           std::ranges::all_of(touched_, has_known_neighbours);
  }

  double beyond_limit() const {
    double edge = 0.0;
    for (const Row v : order_) {
      if (!(vertices_[v].front.distance <= limit_)) continue;
      for (Row fan = starts_[v]; fan < starts_[v + 1]; ++fan)
        for (const double to : fans_[fan].to)
          if (to < kInfinity) edge = std::max(edge, to);
    }
    return kEdgesBeyondLimit * edge;
  }

  // Forget the last set of sources.
  void forget(bool all_pending) {
    const auto clear = [&](Index v) {
      vertices_[v] = {{kInfinity, 1.0}, curvature_[v], static_cast<Row>(n_vertices()), all_pending};
    };
    if (is_new_ || all_pending != were_pending_) {
      is_new_ = false;
      for (Index v = 0; v < n_vertices(); ++v) clear(v);
    } else {
      for (const Row v : order_) clear(v);
      for (const Row v : touched_) clear(v);
    }
    touched_.clear();
    all_pending_ = were_pending_ = all_pending;
  }

  // Remember a vertex that may not come into the order.
  GT_INLINE void touch(Row v) {
    if constexpr (kNear)
      if (vertices_[v].position == n_vertices()) touched_.push_back(v);
  }

  // Begin at the sources of set k. The nearest one counts if there are several at a vertex.
  void begin_at(const Sources& sources, Index k) {
    for (Index p = sources.begins[k]; p < sources.begins[k + 1]; ++p) {
      Front& front = vertices_[sources.vertices[p]].front;
      touch(static_cast<Row>(sources.vertices[p]));
      if (sources.distances[p] <= front.distance)
        front = {sources.distances[p], inverse(sources.curvatures[p])};
    }
    for (Index p = sources.begins[k]; p < sources.begins[k + 1]; ++p)
      begin_beside(sources.vertices[p]);
    for (Index p = sources.begins[k]; p < sources.begins[k + 1]; ++p) {
      const Index v = sources.vertices[p];
      for (Row fan = starts_[v]; fan < starts_[v + 1]; ++fan)
        for (const std::uint32_t neighbour : fans_[fan].neighbour) mark(neighbour);
    }
  }

  void mark(Row v) {
    Vertex& vertex = vertices_[v];
    n_pending_ += !vertex.pending;
    if (kLimited && !vertex.pending) queue_.emplace(now_, v);
    if (kNear && !vertex.pending) touch(v);
    vertex.pending = true;
  }

  // Update the vertex opposite a boundary edge from a front that begins on the edge, for all such
  // edges of a source vertex. A front that arrives later does not enter through the edge.
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
    if (!(a.front.distance + b.front.distance <= edge * kOnEdgeRatio)) return;
    const auto arrivals = across<kOffsets>(
        Edges<Lane>{Lane::spread(a.front.distance), Lane::spread(b.front.distance),
                    Lane::spread(a.front.radius), Lane::spread(b.front.radius), Lane::spread(edge),
                    Lane::spread(fan.to[i]), Lane::spread(fan.to[j])});
    if (!(arrivals.distance[0] < opposite.front.distance)) return;
    const double bend = (opposite.curvature + a.curvature + b.curvature) / 3;
    touch(v);
    opposite.front = {arrivals.distance[0], bent(arrivals.radius[0], arrivals.step[0], bend)};
    for (Row its = starts_[v]; its < starts_[v + 1]; ++its)
      for (const std::uint32_t neighbour : fans_[its].neighbour) mark(neighbour);
  }

  // Visit a vertex; return the earliest position of the vertices that are known to gain from it.
  GT_INLINE Index visit(Row v, Improvement& improvement) {
    const Row start = starts_[v], end = starts_[v + 1];
    double enough = vertices_[v].front.distance - tolerance_;
    if constexpr (kLimited) enough = std::min(enough, latest_[v]);
    Front found{enough, 0.0};
    if (end - start == 1) {  // most have one fan, of which everything stays in registers
      const Ring ring(fans_[start], vertices_.data());
      update_from(ring, v, found);
      if (!(found.distance < enough)) return without_gain(v);
      vertices_[v].front = found;
      if constexpr (kLimited) now_ = found.distance;
      return mark_along_edges(ring, found, improvement);
    }
    for (Row fan = start; fan < ends_[v]; ++fan)
      update_from({fans_[fan], vertices_.data()}, v, found);
    if (!(found.distance < enough)) return without_gain(v);
    vertices_[v].front = found;
    if constexpr (kLimited) now_ = found.distance;
    Index earliest = n_vertices();
    for (Row fan = start; fan < end; ++fan) {
      if (improvement.fan) earliest = std::min(earliest, mark_across_edges(improvement));
      earliest =
          std::min(earliest, mark_along_edges({fans_[fan], vertices_.data()}, found, improvement));
    }
    return earliest;
  }

  // A vertex that was visited too early must be marked when there is an update for it.
  Index without_gain(Row v) {
    all_pending_ &= std::isfinite(vertices_[v].front.distance);
    return n_vertices();
  }

  // Store the update of vertex v from a fan in `found`, if it is smaller.
  GT_INLINE void update_from(const Ring& ring, Row v, Front& found) const {
    const Arrivals<Lanes> arrivals = across<kOffsets>(ring.rim());
    const Lanes to = Lanes::load(ring.fan->to), by_edge = ring.distance + to;
    const double best = choose(arrivals.distance, by_edge, arrivals.distance, by_edge).least();
    if (!(best < found.distance)) return;
    // Updates along edges, followed by updates across edges. There is no branch, because a branch
    // would wait for the distance, and delay the next vertex.
    double radii[2 * kSpokes], steps[2 * kSpokes];
    (ring.radius + to).store(radii);
    to.store(steps);
    arrivals.radius.store(radii + kSpokes);
    arrivals.step.store(steps + kSpokes);
    const Lanes limit = Lanes::spread(best), near_limit = Lanes::spread(best * kTieRatio);
    const unsigned later = below(near_limit, by_edge) | below(limit, arrivals.distance) << kSpokes;
    const int kind = std::countr_zero(~later) & (2 * kSpokes - 1), lane = kind % kSpokes;
    const bool crosses = kind >= kSpokes;
    const auto near = ring.fan->neighbour[lane];
    const double step = steps[kind], least = 1e-12 * step;
    double radius = radii[kind];
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

  // Mark the vertices of a fan that gain along an edge from the front at its centre; return the
  // earliest of their positions.
  GT_INLINE Index mark_along_edges(const Ring& ring, const Front& front, Improvement& improvement) {
    const Lanes limit = ring.distance - Lanes::spread(tolerance_);
    const Lanes to = Lanes::load(ring.fan->to);
    const Lanes distance = Lanes::spread(front.distance);
    // A vertex that has not been reached gains from any front: the processor need not wait.
    const unsigned unreached =
        below(Lanes::spread(kMaxDistance), ring.distance) & below(to, Lanes::spread(kInfinity));
    Index earliest = all_pending_ ? n_vertices() : mark_all(*ring.fan, unreached);
    const unsigned along_edge = below(distance + to, limit);
    if (const unsigned more = along_edge & ~unreached) [[unlikely]]
      earliest = std::min(earliest, mark_all(*ring.fan, more));
    improvement.fan = ring.fan;
    improvement.front = front;
    improvement.marked = along_edge;
    ring.distance.store(improvement.distance);
    return earliest;
  }

  // The same across edges: for each spoke across that from the centre to the next, and for the next
  // across that to this one.
  GT_INLINE Index mark_across_edges(const Improvement& it) {
    const Lanes known = Lanes::load(it.distance), limit = known - Lanes::spread(tolerance_);
    const Lanes to = Lanes::load(it.fan->to), next_to = turned(to),
                edge = Lanes::load(it.fan->edge);
    const Lanes distance = Lanes::spread(it.front.distance),
                radius = Lanes::spread(it.front.radius);
    const unsigned one =
        may_gain<Lanes>(limit, {distance, turned(known), radius, radius, next_to, to, edge});
    const unsigned other =
        may_gain<Lanes>(turned(limit), {distance, known, radius, radius, to, next_to, edge});
    Index earliest = n_vertices();
    for (unsigned spokes = one & ~it.marked; spokes; spokes &= spokes - 1) {
      const int spoke = std::countr_zero(spokes);
      earliest = std::min(earliest,
                          mark_across_edge(*it.fan, spoke, (spoke + 1) % kSpokes, spoke, it.front));
    }
    for (unsigned spokes = other & ~before(it.marked); spokes; spokes &= spokes - 1) {
      const int spoke = std::countr_zero(spokes);
      earliest = std::min(earliest,
                          mark_across_edge(*it.fan, (spoke + 1) % kSpokes, spoke, spoke, it.front));
    }
    return earliest;
  }

  // Mark the vertex at the end of a spoke as pending if it gains across the edge from the centre to
  // the end of another; return its position then.
  Index mark_across_edge(const Fan& fan, int spoke, int other, int edge, const Front& front) {
    using Lane = Pack<2>;  // twice the same: there is no register of one number
    const Vertex &near = vertices_[fan.neighbour[spoke]], &far = vertices_[fan.neighbour[other]];
    const auto arrivals = across<kOffsets>(Edges<Lane>{
        Lane::spread(front.distance), Lane::spread(far.front.distance), Lane::spread(front.radius),
        Lane::spread(far.front.radius), Lane::spread(fan.to[other]), Lane::spread(fan.to[spoke]),
        Lane::spread(fan.edge[edge])});
    if (!(arrivals.distance[0] < near.front.distance - tolerance_)) return n_vertices();
    return mark_all(fan, 1u << spoke);
  }

  // Mark the vertices at the ends of spokes as pending; return the earliest position of those that
  // were not.
  GT_INLINE Index mark_all(const Fan& fan, unsigned spokes) {
    Index earliest = n_vertices();
    for (; spokes; spokes &= spokes - 1) {
      const Row v = fan.neighbour[std::countr_zero(spokes)];
      Vertex& near = vertices_[v];
      if (kLimited && !near.pending) queue_.emplace(now_, v);
      if (kNear && !near.pending) touch(v);
      const Index position = near.pending ? n_vertices() : near.position;
      n_pending_ += !near.pending;
      near.pending = true;
      earliest = std::min(earliest, position);
    }
    return earliest;
  }

  // Prefetch the data of later vertices, because the order of the heat is irregular in memory: the
  // position of the fans of one vertex, the fans of an earlier one, the neighbours of a still
  // earlier one.
  //
  // Inline, or else GCC finds a function without effects, and leaves its calls out.
  GT_INLINE void prefetch_later(Index position) const {
    if (position + 3 * kPrefetchDistance >= count(order_)) return;
    const Row last = order_[position + 3 * kPrefetchDistance],
              later = order_[position + 2 * kPrefetchDistance],
              soon = order_[position + kPrefetchDistance];
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
  const Row* ends_ = nullptr;  // of the fans that update each vertex
  Array<Row> all_ends_;        // the same, if all fans update
  std::span<const double> curvature_;
  std::span<const bool> reflex_;
  std::span<const Row> order_;
  Array<Vertex> vertices_;
  double tolerance_ = 0.0;
  Index n_pending_ = 0;
  bool all_pending_ = false;  // whether all vertices that have not been reached are pending

  // Of near vertices: where the order comes from, the limit, whether vertices up to it are known,
  // those that changed before they came into the order, and whether all were pending then.
  FallingSlices slices_;
  double limit_ = 0.0;
  bool is_near_done_ = false, is_new_ = true, were_pending_ = false;
  std::vector<Row> touched_;

  // Where fronts are limited: the latest arrivals, the pending vertices by the arrival of the front
  // at the vertex that marked them, and that arrival.
  std::span<const double> latest_;
  std::priority_queue<std::pair<double, Row>, std::vector<std::pair<double, Row>>, std::greater<>>
      queue_;
  double now_ = 0.0;
};

template <class T>
Array<T> copied(std::span<const T> values) {
  Array<T> result(count(values));
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

// Sweeps of some sets, whose distances and curvatures are written.
template <bool kOffsets>
void sweep_sets(Sweep<Extent::kWhole, kOffsets> sweep, const HeatTable& heat,
                const Sources& sources, const Effort& effort, std::span<double> distances,
                std::span<double> kappas, Index begin, Index end) {
  const Index n = count(sweep.vertices());
  const Array<Row> orders = falling(heat, begin, end);
  for (Index k = begin; k < end; ++k) {
    const Row* const order = orders.data() + (k - begin) * n;
    sweep.begin({order, static_cast<std::size_t>(n)}, heat, sources, k);
    sweep.finish(heat, k, effort);
    const std::span<const Vertex> vertices = sweep.vertices();
    for (Index v = 0; v < n; ++v) distances[k * n + v] = vertices[v].front.distance;
    if (kappas.empty()) continue;
    for (Index v = 0; v < n; ++v) kappas[k * n + v] = 1 / vertices[v].front.radius;
  }
}

template <bool kOffsets>
void sweep_one(Sweep<Extent::kLimited, kOffsets> sweep, const Sources& sources,
               std::span<const double> latest, Index most_visits, std::span<double> distances) {
  sweep.begin_limited(sources, 0, latest);
  sweep.run_limited(most_visits);
  const std::span<const Vertex> vertices = sweep.vertices();
  for (Index v = 0; v < count(vertices); ++v) distances[v] = vertices[v].front.distance;
}

}  // namespace

Sweeper::Sweeper(const Corners& corners, std::span<const double> curvature,
                 std::span<const bool> reflex)
    : fans_(fans_of(corners)), curvature_(copied(curvature)), reflex_(copied(reflex)) {}

void Sweeper::sweep(const HeatTable& heat, const Sources& sources, const Effort& effort,
                    std::span<double> distances, std::span<double> kappas, int n_threads) const {
  const Index n_sets = heat.n_columns;
  in_pieces(n_sets, (n_sets + n_threads - 1) / n_threads, n_threads, [&](Index begin, Index end) {
    const auto fill = [&](auto sweep) {
      sweep_sets(std::move(sweep), heat, sources, effort, distances, kappas, begin, end);
    };
    if (sources.have_offsets)
      fill(Sweep<Extent::kWhole, true>(fans_, curvature_, reflex_));
    else
      fill(Sweep<Extent::kWhole, false>(fans_, curvature_, reflex_));
  });
}

NearRows Sweeper::sweep_near(const HeatTable& heat, const Sources& sources, const Effort& effort,
                             std::span<const double> limits, int n_threads) const {
  const Index n_sets = heat.n_columns, size = (n_sets + n_threads - 1) / n_threads;
  std::vector<NearPiece> pieces(static_cast<std::size_t>((n_sets + size - 1) / size));
  in_pieces(n_sets, size, n_threads, [&](Index begin, Index end) {
    NearPiece& piece = pieces[static_cast<std::size_t>(begin / size)];
    FallingKeys keys(heat, begin, end);
    const auto find = [&](auto sweep) {
      for (Index k = begin; k < end; ++k) {
        sweep.begin_near(keys, k - begin, sources, k, limits[static_cast<std::size_t>(k)]);
        sweep.finish(heat, k, effort);
        sweep.for_each_near([&](Row v, double distance) { piece.add(v, distance); });
        piece.end_row();
      }
    };
    if (sources.have_offsets)
      find(Sweep<Extent::kNear, true>(fans_, curvature_, reflex_));
    else
      find(Sweep<Extent::kNear, false>(fans_, curvature_, reflex_));
  });
  return together(pieces);
}

void Sweeper::sweep_limited(const Sources& sources, std::span<const double> latest,
                            Index most_visits, std::span<double> distances) const {
  if (sources.have_offsets)
    sweep_one(Sweep<Extent::kLimited, true>(fans_, curvature_, reflex_), sources, latest,
              most_visits, distances);
  else
    sweep_one(Sweep<Extent::kLimited, false>(fans_, curvature_, reflex_), sources, latest,
              most_visits, distances);
}

}  // namespace geodesic
