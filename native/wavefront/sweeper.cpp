#include "wavefront/sweeper.hpp"

#include "core/processor.hpp"
#include "wavefront/crossing.hpp"
#include "wavefront/falling.hpp"

namespace geodesic {
namespace {

// Vertices between the one that is visited and the one whose neighbours are fetched from memory.
// Its corners have been as many before, and where they are as many before that.
constexpr Index kAhead = 12;

// What a vertex knows: the front there, the curvature K of the surface, its place in the order, and
// whether it is to be visited.
struct Vertex {
  Front front;
  double curvature;
  Row rank;
  bool pending;
};

// Sweeps of one set of sources.
class Sweep {
 public:
  Sweep(const Corners& corners, std::span<const double> curvature, std::span<const bool> reflex,
        Array<Row> order, double tolerance)
      : corners_(corners),
        starts_(corners.starts.data()),
        ends_(corners.ends),
        reflex_(reflex),
        order_(std::move(order)),
        vertices_(order_.size()),
        tolerance_(tolerance) {
    for (Index rank = 0; rank < order_.size(); ++rank) {
      const Row v = order_[rank];
      vertices_[v] = {{kInfinity, 0.0}, curvature[v], static_cast<Row>(rank), false};
    }
  }

  std::span<const Vertex> vertices() const { return vertices_; }

  // Put sources at their distances, the nearest where there are several at a vertex.
  void begin(const Sources& sources) {
    for (std::size_t p = 0; p < sources.vertices.size(); ++p) {
      Front& front = vertices_[sources.vertices[p]].front;
      if (sources.distances[p] <= front.distance)
        front = {sources.distances[p], sources.curvatures[p]};
    }
    for (const Index v : sources.vertices) {
      for (Row c = starts_[v]; c < starts_[v + 1]; ++c) {
        await(vertices_[corners_.around[c].a]);
        await(vertices_[corners_.around[c].b]);
      }
    }
  }

  // Whether any vertex is to be visited.
  bool is_under_way() const { return n_pending_ > 0; }

  // Visit the pending vertices in their order once. Whoever gains from a vertex that improved is
  // pending. Where one of them comes earlier in the order, the sweep returns to it at once, before
  // what it will improve spreads; but only so many times.
  void run(Index returns) {
    for (Index rank = 0; rank < order_.size() && n_pending_ > 0;) {
      look_ahead(rank + 1);
      const Row v = order_[rank++];
      if (!vertices_[v].pending) continue;
      vertices_[v].pending = false;
      --n_pending_;
      const Front found = nearest(v);
      if (!(found.distance < vertices_[v].front.distance - tolerance_)) continue;
      vertices_[v].front = found;
      const Index earliest = tell(v);
      if (earliest < rank && returns > 0) {
        rank = earliest;
        --returns;
      }
    }
  }

  // Stars need not be mutual: who is heard by the reached but hears none of them itself now listens
  // to every triangle that it is part of. Return whether there are any.
  bool open_ears(std::span<const double> log_heat) {
    const Array<Row>& own = corners_.ends;
    for (Index v = 0; v < vertices_.size(); ++v) {
      if (std::isfinite(vertices_[v].front.distance) || !std::isfinite(log_heat[v])) continue;
      if (ends_[v] == starts_[v + 1]) continue;
      if (heard_.empty()) heard_ = copy(own);
      heard_[v] = starts_[v + 1];
      await(vertices_[v]);
    }
    if (!heard_.empty()) ends_ = heard_;
    return n_pending_ > 0;
  }

 private:
  static Array<Row> copy(const Array<Row>& from) {
    Array<Row> result(from.size());
    std::copy(from.begin(), from.end(), result.begin());
    return result;
  }

  void await(Vertex& vertex) {
    n_pending_ += !vertex.pending;
    vertex.pending = true;
  }

  // Distance and kappa that the corners of vertex v have for it, infinite if none improves it.
  //
  // First along the edges, which costs little and leaves few triangles that may do better.
  Front nearest(Row v) const {
    const Corner* const corner = corners_.around.data();
    const double enough = vertices_[v].front.distance - tolerance_, bend = vertices_[v].curvature;
    double best = enough, step = 0.0;
    Row via = kNone;
    for (Row c = starts_[v]; c < ends_[v]; ++c) {
      const double by_a = vertices_[corner[c].a].front.distance + corner[c].to_a;
      const double by_b = vertices_[corner[c].b].front.distance + corner[c].to_b;
      if (by_a < best) {
        best = by_a;
        via = static_cast<Row>(corner[c].a);
        step = corner[c].to_a;
      }
      if (by_b < best) {
        best = by_b;
        via = static_cast<Row>(corner[c].b);
        step = corner[c].to_b;
      }
    }
    const double by_edge = best;
    double kappa = 0.0;
    for (Row c = starts_[v]; c < ends_[v]; ++c) {
      const Vertex &a = vertices_[corner[c].a], &b = vertices_[corner[c].b];
      const Arrival found =
          through(best, a.front, b.front, corner[c].edge, corner[c].to_a, corner[c].to_b);
      if (!(found.distance < best)) continue;
      best = found.distance;
      kappa = found.kappa - (a.curvature + b.curvature + bend) / 3 * found.step;
    }
    if (best < by_edge) return {best, kappa};
    if (via == kNone) return {kInfinity, 0.0};
    if (reflex_[via])  // about a corner of the boundary: the front is a circle about it
      return {best, 1 / step};
    return {best, along(vertices_[via].front.kappa, step, (vertices_[via].curvature + bend) / 2)};
  }

  // Whether the vertex `near` gains from v, in their triangle with the vertex `other`. `to_v` and
  // `to_other` are their distances from `near`, `edge` lies between the two.
  bool gains(const Vertex& near, const Vertex& v, const Vertex& other, double to_v, double to_other,
             double edge) const {
    const double limit = near.front.distance - tolerance_;
    if (limit > v.front.distance + to_v) return true;
    return through(limit, v.front, other.front, edge, to_v, to_other).distance < limit;
  }

  // Let those be pending who gain from vertex v; return the least of their ranks.
  Index tell(Row v) {
    const Vertex reached = vertices_[v];
    Index earliest = order_.size();
    const auto ask = [&](Vertex& near, const Vertex& other, double to_v, double to_other,
                         double edge) {
      // Who is pending already needs no look: if he comes earlier, this vertex made him so.
      if (near.pending || !gains(near, reached, other, to_v, to_other, edge)) return;
      await(near);
      earliest = std::min<Index>(earliest, near.rank);
    };
    for (Row c = starts_[v]; c < starts_[v + 1]; ++c) {
      const auto& [a, b, to_a, to_b, edge] = corners_.around[c];
      ask(vertices_[a], vertices_[b], to_a, edge, to_b);
      ask(vertices_[b], vertices_[a], to_b, edge, to_a);
    }
    return earliest;
  }

  // Fetch what vertices will need: the order of the heat is none that memory could foresee. Of one
  // the place of its corners, of one before it these, and of one before that its neighbours.
  void look_ahead(Index rank) const {
    if (rank + 3 * kAhead >= order_.size()) return;
    const Row last = order_[rank + 3 * kAhead], later = order_[rank + 2 * kAhead],
              soon = order_[rank + kAhead];
    const Corner* const corner = corners_.around.data();
    prefetch(&starts_[last]);
    prefetch(&ends_[last]);
    prefetch(&vertices_[later]);
    for (Row c = starts_[later]; c < ends_[later]; c += 2) prefetch(&corner[c]);
    for (Row c = starts_[soon]; c < ends_[soon]; ++c) prefetch(&vertices_[corner[c].a]);
  }

  const Corners& corners_;
  const Row* starts_;
  std::span<const Row> ends_;  // of the corners that vertices listen to
  Array<Row> heard_;           // the same, where they are others
  std::span<const bool> reflex_;
  Array<Row> order_;
  Array<Vertex> vertices_;
  double tolerance_;
  Index n_pending_ = 0;
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
    : corners_{copied<Row>(corners.starts), copied<Row>(corners.ends),
               copied<Corner>(corners.around)},
      curvature_(copied(curvature)),
      reflex_(copied(reflex)) {}

void Sweeper::sweep(std::span<const double> log_heat, const Sources& sources, const Effort& effort,
                    std::span<double> distances, std::span<double> kappas) const {
  Sweep sweep(corners_, curvature_, reflex_, falling(log_heat), effort.tolerance);
  sweep.begin(sources);
  const auto all_reached = [&] {
    for (Index v = 0; v < n_vertices(); ++v)
      if (!std::isfinite(sweep.vertices()[v].front.distance) && std::isfinite(log_heat[v]))
        return false;
    return true;
  };
  for (Index sweeps = 0; sweep.is_under_way() || sweep.open_ears(log_heat); ++sweeps) {
    if (sweeps >= effort.most_sweeps && all_reached()) break;
    sweep.run(sweeps < effort.steady ? 0 : effort.returns);
  }
  for (Index v = 0; v < n_vertices(); ++v) distances[v] = sweep.vertices()[v].front.distance;
  for (Index v = 0; v < count(kappas); ++v) kappas[v] = sweep.vertices()[v].front.kappa;
}

}  // namespace geodesic
