// Symbolic Cholesky factorisation: the structure of the factor, from the pattern alone.
//
// Eliminating a group of columns leaves entries in other rows, which the columns of its parent in a
// tree take over. Everything here follows from that tree in nearly linear time.
//
// J. W. H. Liu, The Role of Elimination Trees in Sparse Factorization, SIAM J. Matrix Anal. Appl.
// 11, 1990, https://doi.org/10.1137/0611010
#include <algorithm>
#include <numeric>

#include "core/processor.hpp"
#include "linear/analysis.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 8;  // rows of prefetch distance

// Share of zeros that a supernode may store, for those of up to 4, 16, 48 and more columns.
//
// Few large dense blocks are quicker than many small ones with no zero in them (C. Ashcraft, R.
// Grimes, 1989, https://doi.org/10.1145/76909.76910).
double share_of_zeros(Index columns) {
  return columns <= 4 ? 0.6 : columns <= 16 ? 0.3 : columns <= 48 ? 0.12 : 0.05;
}

// The vertices of a forest, children before parents and subtrees together.
Array<Row> postorder(const Array<Row>& parent) {
  const Row n = static_cast<Row>(parent.size());
  Array<Row> order(n), stack(n), first_child(n, kNone), sibling(n);
  for (Row v = n - 1; v >= 0; --v) {
    if (parent[v] == kNone) continue;
    sibling[v] = first_child[parent[v]];
    first_child[parent[v]] = v;
  }
  Index done = 0;
  for (Row root = 0; root < n; ++root) {
    if (parent[root] != kNone) continue;
    Index depth = 0;
    stack[0] = root;
    while (depth >= 0) {
      const Row v = stack[depth], child = first_child[v];
      if (child == kNone) {
        order[done++] = v;
        --depth;
      } else {
        first_child[v] = sibling[child];
        stack[++depth] = child;
      }
    }
  }
  return order;
}

// Merge groups of columns with their parents while the zeros that this stores stay within bounds.
Array<Row> amalgamate(const Elimination& its, Analysis& result) {
  const Array<Row> post = postorder(its.parents);
  const Index n_groups = post.size(), n = its.order.size();
  Array<Row> tallest(n_groups), position(n_groups), owner(n_groups);
  struct Supernode {
    Index begins, last, entries;  // from where to where in the postorder, and without the zeros
  };
  Array<Supernode> nodes(n_groups);
  result.order = Array<Row>(n);
  result.first = Array<Row>(n_groups + 1);
  for (Index k = 0; k < n_groups; ++k) position[post[k]] = static_cast<Row>(k);
  Index column = 0, done = 0;
  for (Index k = 0; k < n_groups; ++k) {
    const Row group = post[k];
    Index begin = column, height = its.heights[group], exact = 0, earliest = k;
    for (Index v = its.starts[group]; v < its.starts[group + 1]; ++v) {
      result.order[column++] = its.order[v];
      exact += height--;
    }
    for (; done > 0; --done) {
      const Supernode& child = nodes[done - 1];
      const Row parent = its.parents[post[child.last]];
      if (parent == kNone || position[parent] < earliest || position[parent] > k) break;
      const Index columns = column - result.first[done - 1], whole = columns + height;
      const Index full = columns * whole - columns * (columns - 1) / 2;
      const Index zeros = full - exact - child.entries;
      if (static_cast<double>(zeros) > share_of_zeros(columns) * static_cast<double>(full)) break;
      begin = result.first[done - 1];
      earliest = child.begins;
      exact += child.entries;
    }
    result.first[done] = static_cast<Row>(begin);
    tallest[done] = static_cast<Row>(column - begin + height);
    nodes[done++] = {earliest, k, exact};
  }
  result.first[done] = static_cast<Row>(column);
  result.first.shorten(done + 1);
  for (Row s = 0; s < done; ++s)
    for (Index k = nodes[s].begins; k <= nodes[s].last; ++k) owner[post[k]] = s;
  result.parents = Array<Row>(done);
  for (Index s = 0; s < done; ++s) {
    const Row parent = its.parents[post[nodes[s].last]];
    result.parents[s] = parent == kNone ? kNone : owner[parent];
  }
  tallest.shorten(done);
  return tallest;
}

// Write the lower triangle of the permuted pattern and the rows of every supernode.
//
// Row i belongs to the supernodes on the paths from its entries up the tree to its own. Visiting
// the rows in order leaves each list sorted.
void trace(const Pattern& pattern, const Array<Row>& tallest, Index n_full, Analysis& result) {
  const Index n = pattern.size(), n_supernodes = result.n_supernodes();
  Array<Row> inverse_order(n), owner(n), seen(n_supernodes, kNone);
  for (Index j = 0; j < n; ++j) inverse_order[result.order[j]] = static_cast<Row>(j);
  Array<Index> end(n_supernodes);
  result.row_starts = Array<Index>(n_supernodes + 1);
  Index workspace = 0;
  for (Index s = 0; s < n_supernodes; ++s) {
    result.row_starts[s] = end[s] = workspace;
    workspace += std::min<Index>(tallest[s] + n_full, n - result.first[s]);
    std::fill(&owner[result.first[s]], &owner[result.first[s]] + result.width(s),
              static_cast<Row>(s));
  }
  result.rows = Array<Row>(workspace + kPaddingRows);
  const Index most = (static_cast<Index>(pattern.indices.size()) + n) / 2;
  result.starts = Array<Index>(n + 1);
  result.lower_rows = Array<Row>(most);
  result.places = Array<Row>(most);
  const Row *const entry = pattern.indices.data(), *const place = pattern.indptr.data();
  const Row* const order = result.order.data();
  Row *const rows = result.rows.data(), *const lower = result.lower_rows.data();
  Row* const at = result.places.data();
  Index q = result.starts[0] = 0;
  for (Row i = 0; i < n; ++i) {
    if (i + 2 * kPrefetchDistance < n) {
      prefetch(place + order[i + 2 * kPrefetchDistance]);
      prefetch(entry + place[order[i + kPrefetchDistance]]);
    }
    const Row own = owner[i];
    seen[own] = i;
    for (Row p = place[order[i]]; p < place[order[i] + 1]; ++p) {
      const Row j = inverse_order[entry[p]];
      if (j >= i) {
        lower[q] = j;
        at[q++] = p;
        continue;
      }
      for (Row s = owner[j]; seen[s] != i; s = result.parents[s]) {
        seen[s] = i;
        rows[end[s]++] = i;
      }
    }
    rows[end[own]++] = i;
    result.starts[i + 1] = q;
  }
  result.lower_rows.shorten(q);
  result.places.shorten(q);
  Index kept = 0;
  for (Index s = 0; s < n_supernodes; ++s) {  // close the gaps that full rows may have left
    const Index begin = result.row_starts[s], count = end[s] - begin;
    if (kept != begin) std::copy(rows + begin, rows + begin + count, rows + kept);
    result.row_starts[s] = kept;
    kept += count;
  }
  result.row_starts[n_supernodes] = kept;
  std::fill(rows + kept, rows + std::min<Index>(kept + kPaddingRows, result.rows.size()), 0);
  result.rows.shorten(kept);
}

void measure(Analysis& result) {
  const Index n_supernodes = result.n_supernodes();
  result.panels = Array<Index>(n_supernodes + 1);
  Array<Index> of_children(n_supernodes, 0);
  Index total = 0, height = 0, peak = 1;
  for (Index s = 0; s < n_supernodes; ++s) {
    const Index size = result.height(s) * result.width(s);
    const Index left = result.below(s) * result.below(s);
    result.panels[s] = total;
    total += size;
    result.largest = std::max(result.largest, size);
    result.tallest = std::max(result.tallest, result.height(s));
    peak = std::max(peak, height + left);
    height += left - of_children[s];
    if (result.parents[s] != kNone) of_children[result.parents[s]] += left;
  }
  result.panels[n_supernodes] = total;
  result.stack = peak;
}

}  // namespace

Index Analysis::nbytes() const {
  const auto bytes = [](const auto&... arrays) {
    return ((arrays.size() * static_cast<Index>(sizeof arrays[0])) + ...);
  };
  return bytes(order, starts, lower_rows, places, first, row_starts, rows, parents, panels);
}

// True if every entry of a pattern has its mirror image: all else trusts it, and would write to
// places that are not its own. Rows visited in order meet the entries of each column in order too.
bool is_symmetric(const Pattern& pattern) {
  const Index n = pattern.size(), last = static_cast<Index>(pattern.indices.size()) - 1;
  const Row *const start = pattern.indptr.data(), *const column = pattern.indices.data();
  Array<Row> mirror(n);
  std::copy_n(start, n, mirror.data());
  for (Index i = 0; i < n; ++i) {
    for (Index p = start[i]; p < start[i + 1]; ++p) {
      prefetch(column + mirror[column[std::min(p + kPrefetchDistance, last)]]);
      const Row j = column[p];
      if (mirror[j] == start[j + 1] || column[mirror[j]] != i) return false;
      ++mirror[j];
    }
  }
  return true;
}

std::shared_ptr<const Analysis> analyze(const Pattern& pattern, const Elimination& elimination) {
  auto result = std::make_shared<Analysis>();
  result->n_entries = count(pattern.indices);
  const Array<Row> tallest = amalgamate(elimination, *result);
  trace(pattern, tallest, elimination.n_full, *result);
  measure(*result);
  return result;
}

std::shared_ptr<const Analysis> in_pairs(const Analysis& its, std::span<const Row> indptr) {
  const Index n = its.n_vertices(), n_supernodes = its.n_supernodes();
  auto result = std::make_shared<Analysis>();
  result->order = Array<Row>(2 * n);
  result->starts = Array<Index>(2 * n + 1);
  result->lower_rows = Array<Row>(2 * its.lower_rows.size());
  result->places = Array<Row>(2 * its.places.size());
  for (Index j = 0; j < n; ++j) {
    const Row begin = indptr[its.order[j]];
    for (Row part = 0; part < 2; ++part) result->order[2 * j + part] = 2 * its.order[j] + part;
    result->starts[2 * j] = 2 * its.starts[j];
    result->starts[2 * j + 1] = 2 * its.starts[j + 1];  // nothing is read of odd columns
    for (Index p = its.starts[j]; p < its.starts[j + 1]; ++p)
      for (Row part = 0; part < 2; ++part) {
        result->lower_rows[2 * p + part] = 2 * its.lower_rows[p] + part;
        result->places[2 * p + part] = 2 * (begin + its.places[p]) + part;
      }
  }
  result->starts[2 * n] = 2 * its.starts[n];
  result->first = Array<Row>(n_supernodes + 1);
  result->row_starts = Array<Index>(n_supernodes + 1);
  result->panels = Array<Index>(n_supernodes + 1);
  for (Index s = 0; s <= n_supernodes; ++s) {
    result->first[s] = 2 * its.first[s];
    result->row_starts[s] = 2 * its.row_starts[s];
    result->panels[s] = 2 * its.panels[s];
  }
  result->rows = Array<Row>(2 * its.rows.size());
  for (Index k = 0; k < its.rows.size(); ++k)
    for (Row part = 0; part < 2; ++part) result->rows[2 * k + part] = 2 * its.rows[k] + part;
  result->parents = Array<Row>(n_supernodes);
  std::ranges::copy(its.parents, result->parents.begin());
  result->n_entries = 4 * its.n_entries;
  result->stack = 4 * its.stack;
  result->tallest = 2 * its.tallest;
  result->largest = 4 * its.largest;
  result->in_pairs = true;
  return result;
}

}  // namespace geodesic
