#include "graphs/corners.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "graphs/axes.hpp"

namespace geodesic {
namespace {

// Corners are searched at vertices of at most so many neighbours, one bit each: samples and voxels
// have 4 to 30 neighbours, and the corners of hubs have no meaning.
constexpr Index kMaxNeighbours = 64;
// Triples of corners are examined if there are at most so many corners per edge: voxels have 4, and
// the cost grows with the third power of their number.
constexpr Index kMaxCornersPerEdge = 8;
// Relative difference up to which two sides of a rectangle are equally long.
constexpr double kLengthTolerance = 1e-6;

using Bits = std::uint64_t;
constexpr std::size_t at(Index i) { return static_cast<std::size_t>(i); }
constexpr Bits bit(Index i) { return Bits{1} << i; }
double squared(double x) { return x * x; }

// Edges from both ends, in compressed rows.
struct Rows {
  std::vector<Index> starts;
  std::vector<Row> ends, back, edge;
  std::vector<double> lengths;

  Rows(Index n, std::span<const Index> pairs, std::span<const double> given)
      : starts(at(n) + 1),
        ends(pairs.size()),
        back(pairs.size()),
        edge(pairs.size()),
        lengths(pairs.size()) {
    constexpr std::size_t kLargest = std::size_t{1} << 30;  // twice that is a Row
    if (pairs.size() > kLargest) throw std::length_error("more edges than corners can number");
    for (const Index v : pairs) ++starts[at(v) + 1];
    for (Index v = 0; v < n; ++v) starts[at(v) + 1] += starts[at(v)];
    std::vector<Index> next(starts.begin(), starts.end() - 1);
    for (std::size_t e = 0; e < given.size(); ++e) {
      const Index a = pairs[2 * e], b = pairs[2 * e + 1];
      const Index there = next[at(a)]++, home = next[at(b)]++;
      put(there, b, home, e, given[e]), put(home, a, there, e, given[e]);
    }
  }

  Index degree(Index v) const { return starts[at(v) + 1] - starts[at(v)]; }
  bool joins(Index v, Index w) const {
    const auto from = ends.begin() + starts[at(v)], to = ends.begin() + starts[at(v) + 1];
    return std::find(from, to, w) != to;
  }
  // The slot of v that leads to w.
  Index slot(Index v, Index w) const {
    Index s = starts[at(v)];
    while (ends[at(s)] != w) ++s;
    return s;
  }

 private:
  void put(Index s, Index end, Index other, std::size_t e, double length) {
    ends[at(s)] = static_cast<Row>(end), back[at(s)] = static_cast<Row>(other);
    edge[at(s)] = static_cast<Row>(e), lengths[at(s)] = length;
  }
};

enum class Kind : unsigned char { kTriangle, kRectangle, kQuadrangle, kAxes };

struct Corner {
  Row one, other;  // slots of a vertex
  double across;   // squared
  Kind kind;
};

// True if fronts need a chord between the ends: edges of a triangle have one, and in a rectangle
// that comes after another the next corner does as well.
bool is_open(Kind kind) { return kind == Kind::kQuadrangle || kind == Kind::kAxes; }

// The square of a diagonal of the quadrangle with these sides in turn that is inscribed in a
// circle, from between the first and the last to between the others (Ptolemy): its area is the
// largest.
double diagonal(double a, double b, double c, double d) {
  return (a * c + b * d) * (a * d + b * c) / (a * b + c * d);
}

// True if members of a set are all reached from the first, each to those that `joined` says.
template <class Joined>
bool connects(Bits members, const Joined& joined) {
  Bits reached = members & -members;
  for (Bits fresh = reached; fresh != 0;) {
    Bits next = 0;
    for (; fresh != 0; fresh &= fresh - 1) next |= joined[at(std::countr_zero(fresh))];
    fresh = next & members & ~reached;
    reached |= fresh;
  }
  return reached == members;
}

// Finds the corners of the triangles and the quadrangles at one vertex after the other.
class Finder {
 public:
  explicit Finder(const Rows& rows) : rows_(rows), place_(rows.starts.size() - 1, kNone) {}

  std::vector<Corner> corners;
  std::vector<Rectangle> rectangles;
  std::vector<std::array<Row, 3>> frames;
  // Sums over the vertices: of neighbours, of vertices within two edges, of edges surrounded.
  Index neighbours = 0, near = 0, closed = 0;

  void look_about(Index x) {
    first_ = rows_.starts[at(x)], degree_ = rows_.degree(x);
    if (degree_ < 2 || degree_ > kMaxNeighbours) return;
    for (Index s = 0; s < degree_; ++s) place_[at(end(s))] = static_cast<Row>(s);
    find_triangles();
    find_quadrangles(x);
    neighbours += degree_, near += 1 + degree_;
    for (Index s = 0; s < degree_; ++s)
      closed += joined_[at(s)] != 0 && connects(joined_[at(s)], joined_);
    for (Index s = 0; s < degree_; ++s) place_[at(end(s))] = kNone;
  }

 private:
  struct Route {  // over an end of the vertex to one beyond
    Row beyond, slot, edge;
    double length;
  };

  Index end(Index s) const { return rows_.ends[at(first_ + s)]; }
  double length(Index s) const { return rows_.lengths[at(first_ + s)]; }
  Row edge(Index s) const { return rows_.edge[at(first_ + s)]; }

  void add(Index s, Index t, double across, Kind kind) {
    corners.push_back({static_cast<Row>(first_ + s), static_cast<Row>(first_ + t), across, kind});
  }

  void find_triangles() {
    routes_.clear();
    for (Index s = 0; s < degree_; ++s) {
      joined_[at(s)] = 0;
      const Index a = end(s);
      if (rows_.degree(a) > kMaxNeighbours) continue;
      for (Index r = rows_.starts[at(a)]; r < rows_.starts[at(a) + 1]; ++r) {
        const Row b = rows_.ends[at(r)];
        if (rows_.degree(b) > kMaxNeighbours) continue;
        const Row t = place_[at(b)];
        if (t == kNone) {
          routes_.push_back({b, static_cast<Row>(s), rows_.edge[at(r)], rows_.lengths[at(r)]});
        } else {
          joined_[at(s)] |= bit(t);
          if (s < t) add(s, t, squared(rows_.lengths[at(r)]), Kind::kTriangle);
        }
      }
    }
  }

  // Two paths to one vertex beyond make a quadrangle; those back to the vertex itself do not.
  void find_quadrangles(Index x) {
    std::ranges::sort(routes_, {},
                      [](const Route& route) { return std::pair(route.beyond, route.slot); });
    found_.clear();
    for (std::size_t i = 0, j; i < routes_.size(); i = j) {
      for (j = i; j < routes_.size() && routes_[j].beyond == routes_[i].beyond;) ++j;
      if (routes_[i].beyond == x) continue;
      ++near;
      for (std::size_t p = i; p < j; ++p)
        for (std::size_t q = p + 1; q < j; ++q) add_quadrangle(x, routes_[p], routes_[q]);
    }
    std::ranges::sort(found_, {},
                      [](const Corner& c) { return std::tuple(c.one, c.other, c.across); });
    std::array<Bits, at(kMaxNeighbours)> right{};
    for (std::size_t k = 0; k < found_.size(); ++k) {
      const Corner& c = found_[k];
      if (k > 0 && found_[k - 1].one == c.one && found_[k - 1].other == c.other) continue;
      add(c.one, c.other, c.across, c.kind);
      if (c.kind == Kind::kRectangle) right[at(c.one)] |= bit(c.other);
    }
    for (Index s = 0; s < degree_; ++s)
      for (Bits rest = right[at(s)]; rest != 0; rest &= rest - 1) {
        const int t = std::countr_zero(rest);
        const Bits both = right[at(s)] & right[at(t)];
        if (both == 0) continue;
        frames.push_back({edge(s), edge(t), edge(std::countr_zero(both))});
        return;
      }
  }

  void add_quadrangle(Index x, const Route& p, const Route& q) {
    const Bits beside = joined_[at(p.slot)];
    if (beside & bit(q.slot)) return;  // it has a diagonal
    Bits two = beside;                 // those that a fan of two triangles leads to
    for (Bits rest = beside; rest != 0; rest &= rest - 1)
      two |= joined_[at(std::countr_zero(rest))];
    if (two & joined_[at(q.slot)]) return;  // a fan of up to three fills it
    const double a = length(p.slot), b = length(q.slot), c = q.length, d = p.length;
    const bool right =
        std::abs(a - c) <= kLengthTolerance * a && std::abs(b - d) <= kLengthTolerance * b;
    const double across = right ? squared(a) + squared(b) : diagonal(a, b, c, d);
    found_.push_back({p.slot, q.slot, across, right ? Kind::kRectangle : Kind::kQuadrangle});
    if (right && x < std::min<Index>({end(p.slot), end(q.slot), p.beyond}))  // once of four times
      rectangles.push_back({edge(p.slot), edge(q.slot), q.edge, p.edge});
  }

  const Rows& rows_;
  std::vector<Row> place_;  // of a vertex among the ends of the one looked at
  Index first_ = 0, degree_ = 0;
  std::array<Bits, at(kMaxNeighbours)> joined_{};  // which ends an end has edges to
  std::vector<Route> routes_;
  std::vector<Corner> found_;
};

// Which corners a vertex has, as bits.
class Known {
 public:
  Known(const Rows& rows, std::span<const Corner> corners) : bits_(rows.ends.size()) {
    for (Index v = 0; v + 1 < static_cast<Index>(rows.starts.size()); ++v)
      for (Index s = rows.starts[at(v)]; s < rows.starts[at(v) + 1]; ++s)
        first_.push_back(rows.starts[at(v)]);
    for (const Corner& c : corners) add(c.one, c.other);
  }
  void add(Index s, Index t) {
    bits_[at(s)] |= bit(t - first_[at(s)]), bits_[at(t)] |= bit(s - first_[at(s)]);
  }
  Bits of(Index s) const { return bits_[at(s)]; }
  std::span<const Bits> about(Index first, Index degree) const {
    return std::span(bits_).subspan(at(first), at(degree));
  }

 private:
  std::vector<Bits> bits_;
  std::vector<Index> first_;
};

void add_right_angles(const Rows& rows, std::span<const Row> axes, Known& known,
                      std::vector<Corner>& corners) {
  const auto n = static_cast<Index>(rows.starts.size()) - 1;
  for (Index v = 0; v < n; ++v) {
    const Index first = rows.starts[at(v)], degree = rows.degree(v);
    if (degree > kMaxNeighbours) continue;
    for (Index s = first; s < first + degree; ++s) {
      const Row one = axes[at(rows.edge[at(s)])];
      for (Index t = s + 1; t < first + degree; ++t) {
        const Row other = axes[at(rows.edge[at(t)])];
        if (one == kNone || other == kNone || one == other || one / 3 != other / 3) continue;
        if (known.of(s) & bit(t - first)) continue;
        const double across = squared(rows.lengths[at(s)]) + squared(rows.lengths[at(t)]);
        corners.push_back({static_cast<Row>(s), static_cast<Row>(t), across, Kind::kAxes});
        known.add(s, t);
      }
    }
  }
}

// Axes of a lattice that a chord combines, as one number; 0 where they are not known.
Row axis_set(Row axis) { return axis == kNone ? 0 : 8 * (axis / 3) + (1 << (axis % 3)); }
// The axes of two edges or chords together, 0 where they are not known to be at right angles.
Row at_right_angles(Row a, Row b) {
  return a != 0 && b != 0 && a / 8 == b / 8 && (a & b & 7) == 0 ? (a | b) : 0;
}

// The share of vertices with three edges or more whose corners connect all of these.
double covered(const Rows& rows, const Known& known) {
  Index junctions = 0, whole = 0;
  for (Index v = 0; v + 1 < static_cast<Index>(rows.starts.size()); ++v) {
    const Index first = rows.starts[at(v)], degree = rows.degree(v);
    if (degree < 3) continue;
    ++junctions;
    if (degree > kMaxNeighbours) continue;
    const Bits all = degree == kMaxNeighbours ? ~Bits{0} : bit(degree) - 1;
    whole += connects(all, known.about(first, degree));
  }
  return junctions ? static_cast<double>(whole) / static_cast<double>(junctions) : 0.0;
}

struct Chord {
  Index one, other;
  double squared;
  Row axes;  // as by axis_set
};

void drop_repeated(std::vector<Chord>& chords) {
  std::ranges::sort(chords, {},
                    [](const Chord& c) { return std::tuple(c.one, c.other, c.squared); });
  const auto rest = std::ranges::unique(
      chords, [](const Chord& c, const Chord& d) { return c.one == d.one && c.other == d.other; });
  chords.erase(rest.begin(), rest.end());
}

// The third sides of corners that no edge closes, each once: those of rectangles are not needed.
std::vector<Chord> chords_of(const Rows& rows, std::span<const Corner> corners,
                             std::span<const Row> axes) {
  const auto axis_of = [&](Row s) { return axes.empty() ? kNone : axes[at(rows.edge[at(s)])]; };
  std::vector<Chord> chords;
  for (const Corner& c : corners) {
    if (!is_open(c.kind)) continue;
    const Index a = rows.ends[at(c.one)], b = rows.ends[at(c.other)];
    const Row set = at_right_angles(axis_set(axis_of(c.one)), axis_set(axis_of(c.other)));
    chords.push_back({std::min(a, b), std::max(a, b), c.across, set});
  }
  drop_repeated(chords);
  return chords;
}
// A corner of a vertex by its ends.
struct Angle {
  Index apex, one, other;
  double across;
};

std::vector<Angle> angles_of(const Rows& rows, std::span<const Corner> corners) {
  std::vector<Angle> angles;
  angles.reserve(corners.size());
  for (const Corner& c : corners) {
    const Index a = rows.ends[at(c.one)], b = rows.ends[at(c.other)];
    const Index x = rows.ends[at(rows.back[at(c.one)])];
    angles.push_back({x, a, b, c.across});
    if (!is_open(c.kind)) continue;
    angles.push_back({a, x, b, squared(rows.lengths[at(c.other)])});
    angles.push_back({b, x, a, squared(rows.lengths[at(c.one)])});
  }
  return angles;
}

// Chords from corner to corner of a box, over an edge and the chord of the other two axes.
std::vector<Chord> through_boxes(const Rows& rows, std::span<const Row> sets,
                                 std::vector<Angle>& angles) {
  std::vector<Chord> chords;
  const auto n = static_cast<Index>(rows.starts.size()) - 1;
  for (Index v = 0; v < n; ++v) {
    for (Index s = rows.starts[at(v)]; s < rows.starts[at(v) + 1]; ++s) {
      for (Index t = s + 1; t < rows.starts[at(v) + 1]; ++t) {
        const Row set = at_right_angles(sets[at(rows.edge[at(s)])], sets[at(rows.edge[at(t)])]);
        const Index a = rows.ends[at(s)], b = rows.ends[at(t)];
        if ((set & 7) != 7 || rows.joins(a, b)) continue;
        const double one = squared(rows.lengths[at(s)]), other = squared(rows.lengths[at(t)]);
        angles.insert(angles.end(), {{v, a, b, one + other}, {a, v, b, other}, {b, v, a, one}});
        chords.push_back({std::min(a, b), std::max(a, b), one + other, set});
      }
    }
  }
  drop_repeated(chords);
  return chords;
}

void store(const Rows& rows, std::span<const Angle> angles, GraphCorners& result) {
  std::vector<std::pair<Row, Row>> slots(angles.size());
  result.begins.assign(rows.ends.size() + 1, 0);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    slots[k] = {static_cast<Row>(rows.slot(angles[k].apex, angles[k].one)),
                static_cast<Row>(rows.slot(angles[k].apex, angles[k].other))};
    ++result.begins[at(slots[k].first) + 1], ++result.begins[at(slots[k].second) + 1];
  }
  for (std::size_t s = 0; s < rows.ends.size(); ++s) result.begins[s + 1] += result.begins[s];
  std::vector<Index> next(result.begins.begin(), result.begins.end() - 1);
  result.other.resize(2 * angles.size()), result.across.resize(2 * angles.size());
  const auto put = [&](Row s, Row t, double across) {
    const Index k = next[at(s)]++;
    result.other[at(k)] = t, result.across[at(k)] = across;
  };
  for (std::size_t k = 0; k < angles.size(); ++k) {
    put(slots[k].first, slots[k].second, angles[k].across);
    put(slots[k].second, slots[k].first, angles[k].across);
  }
}

// Edges and chords, with the axes of each as by axis_set.
struct Chorded {
  std::vector<Index> edges;
  std::vector<double> lengths;
  std::vector<Row> sets;

  void add(const std::vector<Chord>& chords) {
    for (const Chord& c : chords) {
      edges.push_back(c.one), edges.push_back(c.other);
      lengths.push_back(std::sqrt(c.squared)), sets.push_back(c.axes);
    }
  }
};

void judge(std::span<const Corner> corners, Index n_edges, bool boxes, GraphCorners& result) {
  const auto share = [&](auto is_such) {
    return static_cast<double>(std::ranges::count_if(corners, is_such)) /
           static_cast<double>(std::max<std::size_t>(corners.size(), 1));
  };
  result.lattice = share([](const Corner& c) {
                     return c.kind == Kind::kRectangle || c.kind == Kind::kAxes;
                   }) > 0.9;
  const double triangles = share([](const Corner& c) { return c.kind == Kind::kTriangle; });
  result.solid = (boxes || triangles < 0.5) && count(corners) <= kMaxCornersPerEdge * n_edges;
}

}  // namespace

GraphCorners corners_of(Index n, std::span<const Index> edges, std::span<const double> lengths) {
  GraphCorners result;
  Chorded chorded{{edges.begin(), edges.end()}, {lengths.begin(), lengths.end()}, {}};
  std::vector<Angle> angles;
  bool boxes = false;
  {
    const Rows rows(n, edges, lengths);
    Finder finder(rows);
    for (Index v = 0; v < n; ++v) finder.look_about(v);
    std::vector<Corner>& corners = finder.corners;
    Known known(rows, corners);
    std::vector<Row> axes;
    if (!finder.rectangles.empty()) {
      axes =
          axes_of_edges({edges, lengths, rows.starts, rows.edge}, finder.rectangles, finder.frames);
      add_right_angles(rows, axes, known, corners);
    }
    judge(corners, static_cast<Index>(lengths.size()), !finder.frames.empty(), result);
    result.covered = covered(rows, known);
    const double sides = static_cast<double>(std::max<Index>(finder.neighbours, 1));
    result.growth = static_cast<double>(finder.near) / sides;
    result.closed = static_cast<double>(finder.closed) / sides;
    boxes = !finder.frames.empty();
    for (const Row axis : axes) chorded.sets.push_back(axis_set(axis));
    angles = angles_of(rows, corners);
    chorded.add(chords_of(rows, corners, axes));
  }
  if (boxes) {
    const Rows rows(n, chorded.edges, chorded.lengths);
    chorded.add(through_boxes(rows, chorded.sets, angles));
  }
  Rows rows(n, chorded.edges, chorded.lengths);
  store(rows, angles, result);
  result.starts = std::move(rows.starts), result.ends = std::move(rows.ends);
  result.lengths = std::move(rows.lengths), result.back = std::move(rows.back);
  result.reaches.resize(at(n));
  for (Index v = 0; v < n; ++v)
    for (Index s = result.starts[at(v)]; s < result.starts[at(v) + 1]; ++s)
      result.reaches[at(v)] = std::max(result.reaches[at(v)], result.lengths[at(s)]);
  return result;
}

}  // namespace geodesic
