// The symbolic half of a factorisation: everything that the pattern alone decides.
#pragma once

#include <memory>

#include "core/matrix.hpp"

namespace geodesic {

// Numbers that the substitution reads at once, wherever a column ends.
inline constexpr int kPaddingRows = 8;

// An order of elimination, in groups of vertices that are eliminated together.
struct Elimination {
  Array<Row> order;    // the vertices
  Array<Row> starts;   // group g is order[starts[g], starts[g + 1])
  Array<Row> heights;  // rows of the first column of each group, without those set aside as full
  Array<Row> parents;  // the group that receives the update of this one, or kNone
  Index n_full = 0;    // vertices that were set aside: the last group
};

// Column j of the factor belongs to vertex order[j]. Supernode s has the columns
// first[s] <= j < first[s + 1] and the rows rows[row_starts[s], row_starts[s + 1]), of which its
// own columns come first; its dense panel of that shape is stored by columns from panels[s].
struct Analysis {
  Array<Row> order;
  Array<Index> starts;    // the permuted lower triangle by columns,
  Array<Row> lower_rows;  // and where its entries are in a matrix's data
  Array<Row> places;
  Array<Row> first;
  Array<Index> row_starts;
  Array<Row> rows;
  Array<Row> parents;  // the parent of each supernode, kNone at roots
  Array<Index> panels;
  Index n_entries = 0;    // of the pattern that was analysed
  Index stack = 0;        // numbers on the stack of update matrices, at the most
  Index tallest = 0;      // rows of the tallest supernode
  Index largest = 0;      // numbers in the largest panel
  bool in_pairs = false;  // whether it is of a matrix of complex numbers; see `in_pairs`

  Index n_vertices() const { return order.size(); }
  Index n_supernodes() const { return parents.size(); }
  Index n_stored() const { return panels[n_supernodes()]; }
  // Bytes of the arrays.
  Index nbytes() const;
  Index width(Index s) const { return first[s + 1] - first[s]; }
  Index height(Index s) const { return row_starts[s + 1] - row_starts[s]; }
  Index below(Index s) const { return height(s) - width(s); }
  const Row* rows_of(Index s) const { return rows.data() + row_starts[s]; }
  const Row* rows_below(Index s) const { return rows_of(s) + width(s); }
};

// Analyse a pattern that has both triangles and sorted columns.
bool is_symmetric(const Pattern& pattern);
Elimination minimum_degree(const Pattern& pattern);
std::shared_ptr<const Analysis> analyze(const Pattern& pattern, const Elimination& elimination);

// The analysis of Hermitian matrices with a pattern, from that of the pattern, in their real form:
// an entry a + i b is a block [[a, -b], [b, a]].
//
// So are the entries of the factor, as its diagonal is real, and its odd columns follow from the
// even ones: only those are computed and stored. `indptr` is that of the pattern.
std::shared_ptr<const Analysis> in_pairs(const Analysis& analysis, std::span<const Row> indptr);

}  // namespace geodesic
