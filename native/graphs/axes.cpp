#include "graphs/axes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace geodesic {
namespace {

// Relative difference up to which two lengths are the same.
constexpr double kLengthTolerance = 1e-6;

constexpr std::size_t at(Index i) { return static_cast<std::size_t>(i); }

class Sets {
 public:
  explicit Sets(Index n) : parents_(at(n)) { std::iota(parents_.begin(), parents_.end(), 0); }
  Row root(Row i) {
    while (parents_[at(i)] != i) i = parents_[at(i)] = parents_[at(parents_[at(i)])];
    return i;
  }
  void join(Row i, Row j) { parents_[at(root(i))] = root(j); }

 private:
  std::vector<Row> parents_;
};

// Lists of numbers for each of several others, in compressed rows.
class Lists {
 public:
  Lists(Index n, std::span<const std::pair<Row, Row>> sorted) : starts_(at(n) + 1) {
    for (const auto& [owner, member] : sorted) ++starts_[at(owner) + 1], members_.push_back(member);
    for (std::size_t i = 0; i + 1 < starts_.size(); ++i) starts_[i + 1] += starts_[i];
  }
  std::span<const Row> of(Row owner) const {
    return std::span(members_).subspan(at(starts_[at(owner)]),
                                       at(starts_[at(owner) + 1] - starts_[at(owner)]));
  }

 private:
  std::vector<Index> starts_;
  std::vector<Row> members_;
};

std::vector<Row> parallel(Index n_edges, std::span<const Rectangle> rectangles) {
  Sets sets(n_edges);
  for (const Rectangle& r : rectangles)
    sets.join(r.one, r.opposite_one), sets.join(r.other, r.opposite_other);
  std::vector<Row> number(at(n_edges), kNone), classes(at(n_edges));
  Row count = 0;
  for (Row e = 0; e < n_edges; ++e) {
    Row& own = number[at(sets.root(e))];
    if (own == kNone) own = count++;
    classes[at(e)] = own;
  }
  return classes;
}

Lists members_of(std::span<const Row> classes, Index n_classes) {
  std::vector<std::pair<Row, Row>> pairs(classes.size());
  for (std::size_t e = 0; e < pairs.size(); ++e) pairs[e] = {classes[e], static_cast<Row>(e)};
  std::ranges::sort(pairs);
  return Lists(n_classes, pairs);
}

Lists at_right_angles(std::span<const Row> classes, std::span<const Rectangle> rectangles,
                      Index n_classes) {
  std::vector<std::pair<Row, Row>> pairs;
  pairs.reserve(2 * rectangles.size());
  for (const Rectangle& r : rectangles) {
    const Row a = classes[at(r.one)], b = classes[at(r.other)];
    pairs.emplace_back(a, b), pairs.emplace_back(b, a);
  }
  std::ranges::sort(pairs);
  const auto rest = std::ranges::unique(pairs);
  pairs.erase(rest.begin(), rest.end());
  return Lists(n_classes, pairs);
}

bool alike(double one, double other) { return std::abs(one - other) <= kLengthTolerance * one; }

bool has_three_lengths_at_most(std::span<const double> lengths) {
  std::vector<double> found;
  for (const double length : lengths) {
    if (std::ranges::any_of(found, [=](double other) { return alike(length, other); })) continue;
    if (found.size() == 3) return false;
    found.push_back(length);
  }
  return true;
}

// True if no vertex has more neighbours than one of a lattice in the plane.
bool is_flat(const EdgesAround& graph) {
  for (std::size_t v = 0; v + 1 < graph.starts.size(); ++v)
    if (graph.starts[v + 1] - graph.starts[v] > 4) return false;
  return true;
}

// Assigns axes to one lattice after the other.
class Axes {
 public:
  Axes(const EdgesAround& graph, std::span<const Rectangle> rectangles)
      : graph_(graph),
        classes_(parallel(static_cast<Index>(graph.lengths.size()), rectangles)),
        n_classes_(1 + *std::ranges::max_element(classes_)),
        members_(members_of(classes_, n_classes_)),
        across_(at_right_angles(classes_, rectangles, n_classes_)),
        axis_(at(n_classes_), kNone),
        excluded_(at(n_classes_), 0),
        lattice_(graph.starts.size() - 1, kNone),
        full_(graph.starts.size() - 1),
        lengths_tell_(has_three_lengths_at_most(graph.lengths)) {}

  // Start at three classes that are mutually at right angles.
  void spread_from(const std::array<Row, 3>& frame) {
    for (const Row edge : frame)
      if (axis_[at(classes_[at(edge)])] != kNone) return;
    for (std::size_t k = 0; k < 3; ++k) axis_length_[k] = graph_.lengths[at(frame[k])];
    named_.clear(), sound_ = true;
    for (std::size_t k = 0; k < 3; ++k) name(classes_[at(frame[k])], static_cast<Row>(k));
    for (std::size_t k = 0; k < named_.size(); ++k) spread(named_[k]);
    settle();
  }

  // Start at any class, in the plane, where all classes that meet are at right angles.
  void spread_in_plane(Row edge) {
    const Row begin = classes_[at(edge)];
    if (axis_[at(begin)] != kNone || across_.of(begin).empty()) return;
    named_.clear(), sound_ = true;
    name(begin, 0);
    for (std::size_t k = 0; k < named_.size(); ++k) {
      const Row own = axis_[at(named_[k])] % 3;
      for (const Row other : across_.of(named_[k])) {
        if (axis_[at(other)] == kNone) name(other, 1 - own);
        sound_ = sound_ && axis_[at(other)] % 3 != own;
      }
    }
    settle();
  }

  Row of(Index edge) const { return std::max(axis_[at(classes_[at(edge)])], kNone); }

 private:
  static constexpr Row kUnsound = -2;
  using Bits = unsigned char;
  static Bits bit(Row axis) { return static_cast<Bits>(1U << axis); }

  void name(Row c, Row axis) {
    axis_[at(c)] = 3 * lattices_ + axis;
    named_.push_back(c);
  }

  void spread(Row c) {
    const Row axis = axis_[at(c)] % 3;
    sound_ = sound_ && !(excluded_[at(c)] & bit(axis));
    for (const Row other : across_.of(c)) exclude(other, bit(axis));
    for (const Row edge : members_.of(c))
      for (const Index v : {graph_.ends[2 * at(edge)], graph_.ends[2 * at(edge) + 1]})
        fill(v, axis);
  }

  // There is an edge along an axis at a vertex: with two of them there is no third.
  void fill(Index v, Row axis) {
    if (lattice_[at(v)] != lattices_) lattice_[at(v)] = lattices_, full_[at(v)] = {};
    const int edges = ++full_[at(v)][at(axis)];
    sound_ = sound_ && edges <= 2;
    const Bits taken = edges == 2 ? bit(axis) : Bits{0};
    if (edges != 2 && !lengths_tell_) return;
    for (Index k = graph_.starts[at(v)]; k < graph_.starts[at(v) + 1]; ++k)
      exclude(classes_[at(graph_.edges[at(k)])], taken);
  }

  void exclude(Row c, Bits axes) {
    Bits& excluded = excluded_[at(c)];
    if (axis_[at(c)] != kNone) {
      if (axis_[at(c)] / 3 == lattices_ && axes != bit(axis_[at(c)] % 3)) excluded |= axes;
      return;
    }
    excluded |= axes;
    const Bits all = excluded | other_lengths(c);
    if (std::popcount(all) == 2) name(c, static_cast<Row>(std::countr_zero<unsigned>(~all & 7U)));
  }

  // The axes along which edges are of other lengths, unless those are all.
  Bits other_lengths(Row c) const {
    if (!lengths_tell_) return 0;
    const double length = graph_.lengths[at(members_.of(c).front())];
    Bits found = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (!alike(length, axis_length_[k])) found |= bit(static_cast<Row>(k));
    return found == 7 ? Bits{0} : found;
  }

  void settle() {
    if (!sound_)  // at right angles to itself, or three edges along one axis: no lattice
      for (const Row c : named_) axis_[at(c)] = kUnsound;
    ++lattices_;
  }

  const EdgesAround& graph_;
  std::vector<Row> classes_;  // of parallel edges
  Row n_classes_;
  Lists members_, across_;
  std::vector<Row> axis_;
  std::vector<Bits> excluded_;  // axes that a class does not run along
  std::vector<Row> lattice_;    // of a vertex, and its edges along each axis
  std::vector<std::array<unsigned char, 3>> full_;
  bool lengths_tell_;
  std::array<double, 3> axis_length_{};
  std::vector<Row> named_;
  bool sound_ = true;
  Row lattices_ = 0;
};

}  // namespace

std::vector<Row> axes_of_edges(const EdgesAround& graph, std::span<const Rectangle> rectangles,
                               std::span<const std::array<Row, 3>> frames) {
  Axes axes(graph, rectangles);
  for (const auto& frame : frames) axes.spread_from(frame);
  if (frames.empty() && is_flat(graph))
    for (const Rectangle& rectangle : rectangles) axes.spread_in_plane(rectangle.one);
  std::vector<Row> result(graph.lengths.size());
  for (std::size_t e = 0; e < result.size(); ++e) result[e] = axes.of(static_cast<Index>(e));
  return result;
}

}  // namespace geodesic
