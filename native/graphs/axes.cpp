#include "graphs/axes.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace geodesic {
namespace {

class Sets {
 public:
  explicit Sets(Row n) : parents_(static_cast<std::size_t>(n)) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  Row root(Row i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void join(Row i, Row j) { at(root(i)) = root(j); }

 private:
  Row& at(Row i) { return parents_[static_cast<std::size_t>(i)]; }
  std::vector<Row> parents_;
};

// Classes of parallel edges, and which ones are at right angles.
struct Classes {
  std::vector<Row> of_edge;
  std::vector<std::vector<Row>> across;
};

Classes parallel(Row n_edges, std::span<const Rectangle> rectangles) {
  Sets sets(n_edges);
  for (const Rectangle& r : rectangles)
    sets.join(r.one, r.opposite_one), sets.join(r.other, r.opposite_other);
  Classes found{std::vector<Row>(static_cast<std::size_t>(n_edges)), {}};
  for (Row e = 0, count = 0; e < n_edges; ++e) {
    const Row root = sets.root(e);
    if (root == e) found.of_edge[static_cast<std::size_t>(e)] = count++;
  }
  for (Row e = 0; e < n_edges; ++e)
    found.of_edge[static_cast<std::size_t>(e)] =
        found.of_edge[static_cast<std::size_t>(sets.root(e))];
  std::vector<std::pair<Row, Row>> pairs;
  pairs.reserve(2 * rectangles.size());
  Row count = 0;
  for (const Row c : found.of_edge) count = std::max(count, c + 1);
  for (const Rectangle& r : rectangles) {
    const Row a = found.of_edge[static_cast<std::size_t>(r.one)];
    const Row b = found.of_edge[static_cast<std::size_t>(r.other)];
    pairs.emplace_back(a, b), pairs.emplace_back(b, a);
  }
  std::ranges::sort(pairs);
  const auto rest = std::ranges::unique(pairs);
  pairs.erase(rest.begin(), rest.end());
  found.across.resize(static_cast<std::size_t>(count));
  for (const auto& [a, b] : pairs) found.across[static_cast<std::size_t>(a)].push_back(b);
  return found;
}

// One lattice after the other is given axes, from a frame or from a single class on.
class Axes {
 public:
  explicit Axes(const Classes& classes)
      : classes_(classes), axis_(classes.across.size(), kNone), seen_(classes.across.size(), 0) {}

  void begin(std::span<const Row> classes, bool solid) {
    for (const Row c : classes)
      if (axis_[at(c)] != kNone || classes_.across[at(c)].empty()) return;
    std::vector<Row> members;
    for (std::size_t k = 0; k < classes.size(); ++k) name(classes[k], static_cast<Row>(k), members);
    bool sound = true;
    for (std::size_t k = 0; k < members.size(); ++k)
      sound &= spread(members[k], solid, members);
    for (const Row c : members) {
      const auto axis = static_cast<unsigned>(axis_[at(c)] % 3);
      sound &= (seen_[at(c)] & (1U << axis)) == 0;
    }
    if (!sound)  // edges at right angles to themselves: no lattice
      for (const Row c : members) axis_[at(c)] = kUnsound;
    ++lattices_;
  }

  Row of(Row c) const { return std::max(axis_[at(c)], kNone); }

 private:
  static constexpr Row kUnsound = -2;
  static std::size_t at(Row c) { return static_cast<std::size_t>(c); }

  void name(Row c, Row axis, std::vector<Row>& members) {
    axis_[at(c)] = 3 * lattices_ + axis;
    members.push_back(c);
  }

  bool spread(Row c, bool solid, std::vector<Row>& members) {
    const auto own = static_cast<unsigned>(axis_[at(c)] % 3);
    bool sound = true;
    for (const Row other : classes_.across[at(c)]) {
      if (axis_[at(other)] == kUnsound) continue;
      seen_[at(other)] |= static_cast<unsigned char>(1U << own);
      const unsigned seen = seen_[at(other)];
      sound &= seen != 7;
      if (axis_[at(other)] != kNone) continue;
      if (!solid) name(other, static_cast<Row>(1 - own), members);
      if (solid && std::popcount(seen) == 2)
        name(other, static_cast<Row>(std::countr_zero(~seen)), members);
    }
    return sound;
  }

  const Classes& classes_;
  std::vector<Row> axis_;
  std::vector<unsigned char> seen_;  // which axes a class is at right angles to
  Row lattices_ = 0;
};

}  // namespace

std::vector<Row> axes_of_edges(Row n_edges, std::span<const Rectangle> rectangles,
                               std::span<const std::array<Row, 3>> frames) {
  const Classes classes = parallel(n_edges, rectangles);
  Axes axes(classes);
  for (const auto& frame : frames) {
    std::array<Row, 3> own{};
    for (std::size_t k = 0; k < 3; ++k) own[k] = classes.of_edge[static_cast<std::size_t>(frame[k])];
    axes.begin(own, true);
  }
  if (frames.empty())
    for (Row c = 0; c < static_cast<Row>(classes.across.size()); ++c)
      axes.begin(std::span(&c, 1), false);
  std::vector<Row> result(static_cast<std::size_t>(n_edges));
  for (std::size_t e = 0; e < result.size(); ++e) result[e] = axes.of(classes.of_edge[e]);
  return result;
}

}  // namespace geodesic
