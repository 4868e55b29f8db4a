#include "wavefront/sight.hpp"

#include <cmath>
#include <complex>
#include <optional>

#include "triangles/measures.hpp"

namespace geodesic {
namespace {

using Point = std::complex<double>;

// Numbers of rings of triangles about places that are unfolded: at first, and at most, where thin
// triangles lie within reach.
constexpr int kFirstRings = 3, kMostRings = 24;

// Largest number of edges in succession across which triangles are unfolded.
constexpr int kMostCrossings = 24;

// Number of edges that a place looks through at most: overlapping stars may repeat each other.
constexpr int kMostWindows = 10'000;

// Reach of the sight of a place, in distances to the farthest vertex around it.
constexpr double kReach = 2.0;

// Share of a length by which triangles may differ about their edge: thin ones are measured with all
// edges a little longer. They differ more where the cost jumps, and lines are refracted.
constexpr double kSame = 1e-3;

// A place is on an edge if its distances from both ends sum to at most this many times its length.
constexpr double kOnEdgeRatio = 1 + 1e-9;

double cross(Point one, Point other) { return std::imag(std::conj(one) * other); }

struct Corner2 {
  Index vertex;
  Point at;
};

// An edge of an unfolded triangle, counterclockwise as the place sees it, and the third corner.
struct Window {
  Corner2 a, b;
  Index inner;
  Point low, high;  // limits of what is seen through it
  int left;         // number of edges that may still be crossed
};

// The vertices that a place sees; true if no front would come to some of them from those around it,
// and if it would see more with further rings of triangles.
struct View {
  std::vector<Corner2> seen;
  bool is_needed = false, is_cut = false;
};

double distance_to_segment(Point a, Point b) {
  const Point along = b - a;
  const double t = std::clamp(-std::real(std::conj(along) * a) / std::norm(along), 0.0, 1.0);
  return std::abs(a + t * along);
}

// The triangles within some rings of places.
class Unfolding {
 public:
  Unfolding(const Unfolded& triangles, std::span<const Index> centres, int n_rings,
            Index n_vertices)
      : stars_(triangles.stars),
        n_rings_(n_rings),
        rings_(n_vertices, static_cast<std::uint8_t>(n_rings + 1)),
        starts_(n_vertices + 1, 0) {
    const std::span<const Index> all = triangles.elements;
    const std::vector<Index> near = triangles_near(all, centres);
    std::vector<double> frames;
    for (const Index e : near)
      for (int c = 0; c < 3; ++c) {
        elements_.push_back(all[3 * e + c]);
        frames.push_back(triangles.frames[3 * e + c]);
        ++starts_[all[3 * e + c] + 1];
      }
    lengths_ = edge_lengths(frames);
    for (Index v = 0; v < n_vertices; ++v) starts_[v + 1] += starts_[v];
    around_.resize(elements_.size());
    Array<Row> free(n_vertices);
    std::copy(starts_.begin(), starts_.end() - 1, free.begin());
    for (std::size_t c = 0; c < elements_.size(); ++c)
      around_[free[elements_[c]]++] = static_cast<Index>(c / 3);
  }

  // Nothing if no triangle has the vertices of the place.
  View from(std::span<const Index> own, std::span<const double> distances) {
    const std::size_t n = own.size();
    const auto farthest = std::ranges::max_element(distances) - distances.begin();
    const auto at = [&](std::size_t k) { return (farthest + k) % n; };
    const std::optional<Index> base = triangle_with(own);
    view_ = {};
    n_windows_ = 0;
    if (!base) return {};
    reach_ = kReach * distances[at(0)];
    const auto length = [&](std::size_t j, std::size_t k) {
      return length_between(*base, own[at(j)], own[at(k)]);
    };
    const auto turn = [&](std::size_t k) {
      return angle_between(distances[at(0)], distances[at(k)], length(0, k));
    };
    const Corner2 first{own[at(0)], distances[at(0)]};
    if (n == 2) {
      look_from_edge(first, {own[at(1)], -distances[at(1)]});
      return std::move(view_);
    }
    for (std::size_t k = 0; k < 3; ++k)
      view_.is_needed |=
          distances[at(k)] + distances[at((k + 1) % 3)] <= length(k, (k + 1) % 3) * kOnEdgeRatio;
    look_out(first, {own[at(1)], std::polar(distances[at(1)], turn(1))},
             {own[at(2)], std::polar(distances[at(2)], -turn(2))});
    return std::move(view_);
  }

 private:
  std::vector<Index> triangles_near(std::span<const Index> all, std::span<const Index> centres) {
    for (const Index v : centres) rings_[v] = 0;
    std::vector<Index> near;
    for (int ring = 0; ring < n_rings_; ++ring) {
      near.clear();
      for (Index e = 0; e < count(all); e += 3) {
        if (std::min({rings_[all[e]], rings_[all[e + 1]], rings_[all[e + 2]]}) > ring) continue;
        near.push_back(e / 3);
        for (Index c = e; c < e + 3; ++c)
          rings_[all[c]] = std::min(rings_[all[c]], static_cast<std::uint8_t>(ring + 1));
      }
    }
    return near;
  }

  std::span<const Index> at_vertex(Index v) const {
    return {around_.begin() + starts_[v], around_.begin() + starts_[v + 1]};
  }
  std::span<const Index> corners_of(Index e) const { return {elements_.begin() + 3 * e, 3}; }

  bool has(Index e, Index v) const {
    const auto corners = corners_of(e);
    return std::ranges::find(corners, v) != corners.end();
  }

  double length_between(Index e, Index one, Index other) const {
    const auto corners = corners_of(e);
    for (int c = 0; c < 3; ++c)
      if (corners[c] != one && corners[c] != other) return lengths_[3 * e + c];
    return 0.0;
  }

  std::optional<Index> triangle_with(std::span<const Index> own) const {
    for (const Index e : at_vertex(own[0]))
      if (std::ranges::all_of(own, [&](Index v) { return has(e, v); })) return e;
    return std::nullopt;
  }

  // The third corners of the triangles beyond an edge, with one of their triangles each. Of stars,
  // those of an end of the edge that has the triangle on this side of it, too: others overlap it.
  struct Third {
    Index vertex, triangle;
  };
  std::vector<Third> thirds(Index one, Index other, Index inner) const {
    std::vector<Third> found;
    for (const Index e : at_vertex(one)) {
      if (!has(e, other)) continue;
      for (const Index v : corners_of(e)) {
        if (v == one || v == other || v == inner) continue;
        const bool known = std::ranges::any_of(found, [&](Third it) { return it.vertex == v; });
        if (!known && is_beyond(e, one, other, inner)) found.push_back({v, e});
      }
    }
    return found;
  }

  bool is_beyond(Index e, Index one, Index other, Index inner) const {
    if (!stars_) return true;
    const Index centre = corners_of(e)[0];
    if (centre != one && centre != other) return false;
    if (inner < 0) return centre == one;
    const Index end = centre == one ? other : one;
    return std::ranges::any_of(at_vertex(centre), [&](Index its) {
      return corners_of(its)[0] == centre && has(its, end) && has(its, inner);
    });
  }

  // The third corner of a triangle, to the right of the edge from a to b.
  std::optional<Point> right_of(const Corner2& a, const Corner2& b, Third third) const {
    const Point edge = b.at - a.at;
    const double length = std::abs(edge);
    const double own = length_between(third.triangle, a.vertex, b.vertex);
    if (!(length > 0) || (!stars_ && std::abs(own - length) > kSame * length)) return std::nullopt;
    const double to_a = length_between(third.triangle, a.vertex, third.vertex);
    const double to_b = length_between(third.triangle, b.vertex, third.vertex);
    const double x = (length * length + (to_a - to_b) * (to_a + to_b)) / (2 * length);
    const double y = std::sqrt(std::max(to_a * to_a - x * x, 0.0));
    return a.at + Point(x, -y) * (edge / length);
  }

  // Look out of a triangle with its corners counterclockwise.
  void look_out(const Corner2& a, const Corner2& b, const Corner2& c) {
    look_through({a, b, c.vertex, a.at, b.at, kMostCrossings});
    look_through({b, c, a.vertex, b.at, c.at, kMostCrossings});
    look_through({c, a, b.vertex, c.at, a.at, kMostCrossings});
  }

  // Look into the triangles on both sides of an edge, and through them.
  void look_from_edge(const Corner2& a, const Corner2& b) {
    bool is_above = true;
    for (const Third third : thirds(a.vertex, b.vertex, kNone)) {
      const Corner2 &first = is_above ? a : b, &second = is_above ? b : a;
      is_above = !is_above;
      const std::optional<Point> at = right_of(first, second, third);
      if (!at) continue;
      const Corner2 apex{third.vertex, *at};
      view_.seen.push_back(apex);
      view_.is_needed = true;
      look_through({first, apex, second.vertex, first.at, apex.at, kMostCrossings});
      look_through({apex, second, first.vertex, apex.at, second.at, kMostCrossings});
    }
  }

  void look_through(const Window& it) {
    if (it.left == 0 || n_windows_ == kMostWindows) return;
    if (distance_to_segment(it.a.at, it.b.at) > reach_) return;
    ++n_windows_;
    const std::vector<Third> beyond = thirds(it.a.vertex, it.b.vertex, it.inner);
    if (beyond.empty())
      view_.is_cut |= rings_[it.a.vertex] == n_rings_ && rings_[it.b.vertex] == n_rings_;
    if (!stars_ && beyond.size() != 1) return;
    for (const Third third : beyond) {
      const std::optional<Point> at = right_of(it.a, it.b, third);
      if (!at) continue;
      const Corner2 apex{third.vertex, *at};
      const double distance = std::abs(*at);
      if (distance < reach_ && cross(it.low, *at) > 0 && cross(*at, it.high) > 0) {
        view_.seen.push_back(apex);
        view_.is_needed |= distance < std::min(std::abs(it.a.at), std::abs(it.b.at));
      }
      const Point before = cross(*at, it.high) > 0 ? *at : it.high;
      const Point behind = cross(it.low, *at) > 0 ? *at : it.low;
      if (cross(it.low, before) > 0)
        look_through({it.a, apex, it.b.vertex, it.low, before, it.left - 1});
      if (cross(behind, it.high) > 0)
        look_through({apex, it.b, it.a.vertex, behind, it.high, it.left - 1});
    }
  }

  bool stars_;
  int n_rings_, n_windows_ = 0;
  Array<std::uint8_t> rings_;  // of a vertex, as far as it is known
  Array<Row> starts_;
  std::vector<Index> elements_, around_;
  Array<double> lengths_;
  double reach_ = 0.0;
  View view_;
};

// Add the vertices that place p sees besides its own, each once, the nearest of its positions.
void add(View& view, Index p, std::span<const Index> own, Sight& sight) {
  std::vector<Index> known(own.begin(), own.end());
  std::ranges::stable_sort(view.seen, {}, [](const Corner2& it) { return std::abs(it.at); });
  for (const Corner2& it : view.seen) {
    if (std::ranges::find(known, it.vertex) != known.end()) continue;
    known.push_back(it.vertex);
    sight.places.push_back(p);
    sight.vertices.push_back(it.vertex);
    sight.x.push_back(it.at.real());
    sight.y.push_back(it.at.imag());
  }
}

}  // namespace

Sight in_sight(const Places& places, const Unfolded& triangles, std::span<const bool> hidden) {
  Sight sight;
  bool is_cut = true;
  for (int n_rings = kFirstRings; is_cut && n_rings <= kMostRings; n_rings *= 2) {
    Unfolding unfolding(triangles, places.vertices, n_rings, count(hidden));
    sight = {};
    is_cut = false;
    for (Index p = 0; p + 1 < count(places.begins); ++p) {
      const auto size = static_cast<std::size_t>(places.begins[p + 1] - places.begins[p]);
      const auto begin = static_cast<std::size_t>(places.begins[p]);
      const auto own = places.vertices.subspan(begin, size);
      View view = unfolding.from(own, places.distances.subspan(begin, size));
      is_cut |= view.is_cut;
      view.is_needed |= std::ranges::any_of(own, [&](Index v) { return hidden[v]; });
      if (view.is_needed) add(view, p, own, sight);
    }
  }
  return sight;
}

}  // namespace geodesic
