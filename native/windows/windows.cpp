#include "windows/windows.hpp"

#include <cmath>
#include <limits>
#include <queue>

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Share of an edge by which a ray may miss a vertex and still meet it. Beside a flat vertex the
// rays to either side belong to two windows, and rounding must leave no gap between them.
constexpr double kVertexTolerance = 1e-9;

// Share of a distance by which rounding may make it longer than another path of the same length.
constexpr double kRelativeRounding = 1e-13;

// Where a face is entered: through [begin, end] of its side, seen straight from (x, y), y <= 0, in
// the plane of the side. The distance at (x, y) is `start`.
struct View {
  Index side;
  double begin, end, x, y, start;

  double to(double along) const { return start + std::hypot(along - x, y); }
  double least() const { return to(std::clamp(x, begin, end)); }
};

// An event: a view; or, if `side` is less than zero, a vertex.
struct Event {
  double distance;
  View view;
  Index vertex;
  bool operator<(const Event& other) const { return distance > other.distance; }  // least on top
};

class Propagation {
 public:
  Propagation(const Polyhedron& shape, std::span<double> distances)
      : shape_(shape), distances_(distances) {
    std::ranges::fill(distances_, kInfinity);
  }

  void begin(const PointsOnFaces& points, Index p) {
    const Index first = points.begins[p], size = points.begins[p + 1] - first;
    const std::span vertices = points.vertices.subspan(first, size);
    const std::span shares = points.shares.subspan(first, size);
    const double start = points.starts[p];
    for (Index i = 0; i < size; ++i) lower(vertices[i], start + points.distances[first + i]);
    if (size == 1)
      events_.push({start, {}, vertices[0]});
    else
      look_round(vertices, shares, start);
  }

  bool run(Index most) {
    for (Index n = 0; !events_.empty(); ++n) {
      if (n > most) return false;
      const Event event = events_.top();
      events_.pop();
      if (event.vertex < 0)
        cross(event.view);
      else if (event.distance <= distances_[event.vertex])
        turn(event.vertex);
    }
    return true;
  }

 private:
  void lower(Index v, double distance) {
    if (!(distance < distances_[v])) return;
    distances_[v] = distance;
    if (shape_.turns(v)) events_.push({distance, {}, v});
  }

  // From a point within a face, or on an edge of several: through all half-edges that it does not
  // lie on.
  void look_round(std::span<const Index> vertices, std::span<const double> shares, double start) {
    for (const Index s : shape_.opposite(vertices[0])) {
      const HalfEdge& side = shape_.side(s);
      double share_of_tail = 0.0, share_of_head = 0.0;
      std::size_t found = 1;
      for (std::size_t i = 1; i < vertices.size(); ++i) {
        if (vertices[i] == side.tail) share_of_tail = shares[i], ++found;
        if (vertices[i] == side.head) share_of_head = shares[i], ++found;
      }
      if (found < vertices.size()) continue;
      const double x = share_of_head * side.length + shares[0] * side.x, y = shares[0] * side.y;
      lower(side.third, start + std::hypot(side.x - x, side.y - y));
      lower(side.tail, start + std::hypot(x, y));
      lower(side.head, start + std::hypot(side.length - x, y));
      enter_beside(s, {s, 0.0, side.length, x, -y, start});
      if (share_of_tail > 0) look_through(side, side.next, x, y, start);
      if (share_of_head > 0) look_through(side, side.last, x, y, start);
    }
  }

  // The whole of another side, from (x, y) in the plane of the first within the face.
  void look_through(const HalfEdge& from, Index s, double x, double y, double start) {
    const Line line(from, s);
    enter_beside(s, {s, 0.0, line.length, line.along(x, y), -std::abs(line.off(x, y)), start});
  }

  // All faces around a vertex see it straight through the side opposite it.
  void turn(Index v) {
    const double start = distances_[v];
    for (const Index s : shape_.opposite(v)) {
      const HalfEdge& side = shape_.side(s);
      lower(side.tail, start + std::hypot(side.x, side.y));
      lower(side.head, start + std::hypot(side.length - side.x, side.y));
      enter_beside(s, {s, 0.0, side.length, side.x, -side.y, start});
    }
  }

  // A view across a face, to the two other half-edges of it.
  void cross(const View& view) {
    if (is_of_no_use(view)) return;
    const HalfEdge& side = shape_.side(view.side);
    const double rise = side.y - view.y;
    // Where the ray to the third corner crosses the side.
    const double middle = rise > 0 ? view.x - (side.x - view.x) * view.y / rise : side.x;
    const double miss = kVertexTolerance * side.length;
    if (view.begin - miss <= middle && middle <= view.end + miss)
      lower(side.third, view.start + std::hypot(side.x - view.x, rise));
    if (middle < view.end) {
      const Line line(side, side.next);
      pass(view, line, line.hit(view, view.end),
           middle >= view.begin ? line.length : line.hit(view, view.begin));
    }
    if (middle > view.begin) {
      const Line line(side, side.last);
      pass(view, line, middle <= view.end ? 0.0 : line.hit(view, view.end),
           line.hit(view, view.begin));
    }
  }

  // Another half-edge of a face, in the plane of the first.
  struct Line {
    Index side;
    double x, y, length, across, up;

    Line(const HalfEdge& from, Index s) : side(s), x(from.length), y(0.0) {
      double to_x = from.x, to_y = from.y;
      if (s == from.last) x = from.x, y = from.y, to_x = 0.0, to_y = 0.0;
      length = std::hypot(to_x - x, to_y - y);
      across = length > 0 ? (to_x - x) / length : 0.0;
      up = length > 0 ? (to_y - y) / length : 0.0;
    }
    double along(double px, double py) const { return (px - x) * across + (py - y) * up; }
    double off(double px, double py) const { return (px - x) * up - (py - y) * across; }

    // Where the ray through a place on the first side comes to this one.
    double hit(const View& view, double place) const {
      const double source = off(view.x, view.y), through = off(place, 0.0), at = along(place, 0.0);
      // The distance from the line is within rounding: the point is on it.
      if (!(std::abs(source - through) > kRelativeRounding * std::abs(source))) return at;
      const double from = along(view.x, view.y);
      return std::clamp(from + (at - from) * (source / (source - through)), 0.0, length);
    }
  };

  void pass(const View& view, const Line& line, double begin, double end) {
    if (!(begin < end)) return;
    const double y = -std::abs(line.off(view.x, view.y));
    enter_beside(line.side, {line.side, begin, end, line.along(view.x, view.y), y, view.start});
  }

  // Enter the other faces at a side, whose planes may have its tail for their head.
  void enter_beside(Index s, const View& view) {
    if (is_of_no_use(view)) return;
    const HalfEdge& side = shape_.side(s);
    for (const Index other : shape_.beside(s)) {
      if (other == s) continue;
      View next = view;
      next.side = other;
      if (shape_.side(other).tail != side.tail) {
        next.begin = side.length - view.end;
        next.end = side.length - view.begin;
        next.x = side.length - view.x;
      }
      events_.push({next.least(), next, -1});
    }
  }

  // True if every point of an interval is closer to an end of its edge.
  bool is_of_no_use(const View& view) const {
    const HalfEdge& side = shape_.side(view.side);
    const double by_tail = distances_[side.tail] + view.end,
                 by_head = distances_[side.head] + side.length - view.begin;
    return by_tail < (1 - kRelativeRounding) * view.to(view.end) ||
           by_head < (1 - kRelativeRounding) * view.to(view.begin);
  }

  const Polyhedron& shape_;
  std::span<double> distances_;
  std::priority_queue<Event> events_;
};

}  // namespace

bool exact_distances(const Polyhedron& shape, const PointsOnFaces& points, Index most,
                     std::span<double> distances) {
  Propagation propagation(shape, distances);
  for (Index p = 0; p < count(points.starts); ++p) propagation.begin(points, p);
  return propagation.run(most);
}

}  // namespace geodesic
