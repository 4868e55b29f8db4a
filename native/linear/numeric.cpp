// The Cholesky factor, supernode by supernode: the multifrontal method.
//
// Each supernode gathers a dense front: its own entries of A, plus the update matrices of its
// children. Eliminating its columns leaves a panel of the factor and an update matrix for its
// parent, which waits on a stack until the parent comes, right after its last child. One piece of
// memory holds two stacks, from either end: one for supernodes of even depth, one for those of odd
// depth. The children lie on one, the parent's update matrix comes onto the other, and nothing is
// moved.
//
// I. S. Duff, J. K. Reid, The Multifrontal Solution of Indefinite Sparse Symmetric Linear, ACM
// Trans. Math. Softw. 9, 1983, https://doi.org/10.1145/356044.356047
//
// On an M-matrix every sum here is one of numbers of one sign, so that each entry of the factor is
// accurate relative to itself.
#include "linear/numeric.hpp"

#include <vector>

#include "core/processor.hpp"
#include "core/vectors.hpp"
#include "core/workspace.hpp"
#include "linear/front.hpp"
#include "linear/substitution.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 64;  // entries of the matrix of prefetch distance

// An update matrix that waits for the parent of the supernode that left it.
struct Update {
  Row supernode;
  double* values;
};

// Eliminates fronts, one after the other. Of pairs of columns the second follows from the first.
template <class T, int Every>
class Eliminator {
 public:
  Eliminator(const Analysis& analysis, std::span<const double> data, T* panels, double* pivots)
      : its_(analysis),
        data_(data),
        panels_(panels),
        pivots_(pivots),
        local_(its_.n_vertices()),
        child_rows_(its_.tallest),
        packed_(front::packed_size(its_.tallest)),
        front_(kCopies ? its_.largest : 0) {}

  // Eliminate the front of s; return the column of the first pivot <= 0, or kNone.
  Index eliminate(Index s, std::span<const Update> children, double* update) {
    const Index height = its_.height(s), width = its_.width(s), below = height - width;
    const Index begin = its_.first[s];
    double* const panel = panel_of(s);
    gather(s, panel);
    for (const Update& child : children) {
      const Index count = its_.below(child.supernode), inside = locate(child, width);
      add(panel, height, child.values, count, 0, inside);
    }
    const Index failed = front::eliminate(panel, update, height, width, Every == 2, packed_.data());
    if (failed != kNone) return begin + failed;
    double* const corner = update - width * (below + 1);
    for (const Update& child : children) {
      const Index count = its_.below(child.supernode), inside = locate(child, width);
      add(corner, below, child.values, count, inside, count);
    }
    for (Index j = 0; j < width; j += Every) {
      const double root = 1 / panel[j * height + j];
      const double left = root * root / pivots_[begin + j];
      for (Index part = 0; part < Every; ++part) pivots_[begin + j + part] = left;
    }
    if constexpr (kCopies) {
      T* kept = panels_ + its_.panels[s];
      for (Index j = 0; j < width; j += Every, kept += height)
        for (Index i = 0; i < height; ++i) kept[i] = T(panel[j * height + i]);
    }
    return kNone;
  }

 private:
  static constexpr bool kCopies = Every == 2 || !std::is_same_v<T, double>;
  using Entry = Pack<Every>;

  double* panel_of(Index s) {
    if constexpr (kCopies)
      return front_.data();
    else
      return panels_ + its_.panels[s];
  }

  // The entries of A, and the place of every row in this front.
  void gather(Index s, double* panel) {
    const Index height = its_.height(s), width = its_.width(s), begin = its_.first[s];
    const Index last = its_.places.size() - 1;
    const Row* const rows = its_.rows_of(s);
    for (Index k = 0; k < height; ++k) local_[rows[k]] = static_cast<Row>(k);
    std::fill_n(panel, height * width, 0.0);
    for (Index j = 0; j < width; j += Every) {
      for (Index p = its_.starts[begin + j]; p < its_.starts[begin + j + 1]; p += Every) {
        prefetch(&data_[its_.places[std::min(p + kPrefetchDistance, last)]]);
        double* const place = panel + j * height + local_[its_.lower_rows[p]];
        (Entry::load(place) + Entry::load(&data_[its_.places[p]])).store(place);
      }
      pivots_[begin + j] = panel[j * height + j];
    }
  }

  // Write the places of a child's rows in this front; return how many are among its columns.
  Index locate(const Update& child, Index width) {
    const Row* const rows = its_.rows_below(child.supernode);
    const Index count = its_.below(child.supernode);
    Index inside = 0;
    for (Index k = 0; k < count; ++k) {
      child_rows_[k] = local_[rows[k]];
      inside += child_rows_[k] < width;
    }
    return inside;
  }

  // Add some columns of a child's update matrix of `count` rows, where `child_rows_` says.
  void add(double* target, Index stride, const double* child, Index count, Index begin, Index end) {
    const Row* const places = child_rows_.data();
    for (Index j = begin; j < end; j += Every) {
      const double* const source = child + j * count;
      double* const column = target + places[j] * stride;
      for (Index i = j; i < count; i += Every) {  // both parts of a pair lie together
        double* const place = column + places[i];
        (Entry::load(place) + Entry::load(source + i)).store(place);
      }
    }
  }

  const Analysis& its_;
  std::span<const double> data_;
  T* const panels_;
  double* const pivots_;
  Array<Row> local_, child_rows_;
  Array<double> packed_, front_;
};

template <class T, int Every>
Pivots factorize_every(const Analysis& its, std::span<const double> data, std::span<T> panels) {
  const FlushSubnormals flush;
  const Index n_supernodes = its.n_supernodes();
  Pivots result{kNone, Array<double>(its.n_vertices())};
  std::fill(panels.begin() + its.n_stored(), panels.end(), T(0.0));
  Array<bool> odd(n_supernodes);
  for (Index s = n_supernodes - 1; s >= 0; --s)
    odd[s] = its.parents[s] != kNone && !odd[its.parents[s]];
  Eliminator<T, Every> eliminator(its, data, panels.data(), result.left.data());
  Workspace stack(
      std::max(its.stack, kBlock * its.n_vertices()));  // solves of a block will have it
  std::vector<Update> waiting;
  double *low = stack.data(), *high = low + its.stack;
  for (Index s = 0; s < n_supernodes; ++s) {
    const Index below = its.below(s);
    double* const update = odd[s] ? high - below * below : low;
    std::size_t first = waiting.size();
    while (first > 0 && its.parents[waiting[first - 1].supernode] == s) --first;
    const std::span<const Update> children(waiting.data() + first, waiting.size() - first);
    result.failed = eliminator.eliminate(s, children, update);
    if (result.failed != kNone) return result;
    // The children leave the stack on their side, and the update matrix stays on the other.
    if (!children.empty()) {
      const Index count = its.below(children.front().supernode);
      if (odd[s])
        low = children.front().values;
      else
        high = children.front().values + count * count;
    }
    waiting.resize(first);
    if (below == 0) continue;
    waiting.push_back({static_cast<Row>(s), update});
    if (odd[s])
      high = update;
    else
      low = update + below * below;
  }
  return result;
}

}  // namespace

template <class T>
Pivots factorize(const Analysis& its, std::span<const double> data, std::span<T> panels) {
  if constexpr (std::is_same_v<T, double>)
    if (its.in_pairs) return factorize_every<T, 2>(its, data, panels);
  return factorize_every<T, 1>(its, data, panels);
}

template Pivots factorize(const Analysis&, std::span<const double>, std::span<double>);
template Pivots factorize(const Analysis&, std::span<const double>, std::span<Half>);

}  // namespace geodesic
