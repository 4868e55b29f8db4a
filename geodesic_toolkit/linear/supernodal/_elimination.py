"""What the Cholesky factor of a pattern looks like, before any number is known.

The parent of column j in the *elimination tree* is the row of the first entry below the diagonal of
the factor's column j. Everything here follows from it in nearly linear time.

J. W. H. Liu, *The Role of Elimination Trees in Sparse Factorization*, SIAM J. Matrix Anal. Appl.
11, 1990, https://doi.org/10.1137/0611010
"""

import numba
import numpy as np
from numba import types

from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import IndexArray, IntArray

__all__ = [
    "column_counts",
    "elimination_tree",
    "is_symmetric",
    "lower_triangle",
    "postorder",
    "stack_peak",
    "supernode_rows",
    "supernodes",
]

NONE = -1

AHEAD = 8
"""Rows by which memory is asked for ahead."""

STRICT = (0.6, 0.3, 0.12, 0.05)
"""Share of zeros that a supernode may store, for those of up to 4, 16, 48 and more columns.

Few large dense blocks are quicker than many small ones with no zero in them (C. Ashcraft, R.
Grimes, 1989, https://doi.org/10.1145/76909.76910).
"""

_int64 = types.Array(types.int64, 1, "C", readonly=True)
_int32 = types.Array(types.int32, 1, "C", readonly=True)
_new64, _new32 = types.int64[::1], types.int32[::1]


def kernel(signature: object) -> object:
    """Compile for one signature, or load what an earlier process has compiled."""
    return numba.njit(signature, cache=True, nogil=True, error_model="numpy")


@kernel(types.boolean(_int64, _int32))  # type: ignore[operator]
def is_symmetric(indptr: IntArray, indices: IndexArray) -> bool:
    """Return whether every entry of a pattern with sorted indices has its mirror image.

    Rows visited in order meet the entries of each column in order too. The other kernels trust this
    and would write to places that are not theirs.
    """
    n, last = indptr.size - 1, indices.size - 1
    mirrored = indptr[:-1].copy()
    for i in range(n):
        for p in range(indptr[i], indptr[i + 1]):
            prefetch(shifted(pointer(indices), mirrored[indices[min(p + AHEAD, last)]]))
            j = indices[p]
            if mirrored[j] == indptr[j + 1] or indices[mirrored[j]] != i:
                return False
            mirrored[j] += 1
    return True


@numba.njit(cache=True, nogil=True, error_model="numpy", forceinline=True)  # type: ignore[untyped-decorator]
def _look_ahead(indptr: IntArray, indices: IndexArray, order: IndexArray, i: int) -> None:
    """Fetch the rows that follow row ``order[i]``: they come in no order, and memory takes long."""
    if i + 2 * AHEAD < order.size:
        prefetch(shifted(pointer(indptr), np.int64(order[i + 2 * AHEAD])))
        prefetch(shifted(pointer(indices), indptr[order[i + AHEAD]]))


@kernel(_new32(_int64, _int32, _int32, _int32))  # type: ignore[operator]
def elimination_tree(
    indptr: IntArray, indices: IndexArray, order: IndexArray, rank: IndexArray
) -> IndexArray:
    """Return the parent of every column of the factor of ``A[order][:, order]``, -1 at roots.

    `rank` is the inverse of the permutation `order`.
    """
    n = order.size
    parent, ancestor = np.full(n, NONE, np.int32), np.full(n, NONE, np.int32)
    for i in range(n):
        _look_ahead(indptr, indices, order, i)
        for p in range(indptr[order[i]], indptr[order[i] + 1]):
            k = rank[indices[p]]
            while k != NONE and k < i:  # climb to the root so far, shortening the way
                above = ancestor[k]
                ancestor[k] = i
                if above == NONE:
                    parent[k] = i
                k = above
    return parent


@kernel(_new32(_int32))  # type: ignore[operator]
def postorder(parent: IndexArray) -> IndexArray:
    """Return the vertices of a forest, children before parents and subtrees together."""
    n = parent.size
    first_child, sibling = np.full(n, NONE, np.int32), np.full(n, NONE, np.int32)
    for v in range(n - 1, -1, -1):
        if parent[v] != NONE:
            sibling[v] = first_child[parent[v]]
            first_child[parent[v]] = v
    order, done = np.empty(n, np.int32), 0
    stack = np.empty(n, np.int32)
    for root in range(n):
        if parent[root] != NONE:
            continue
        depth = 0
        stack[0] = root
        while depth >= 0:
            v = stack[depth]
            child = first_child[v]
            if child == NONE:
                order[done] = v
                done += 1
                depth -= 1
            else:
                first_child[v] = sibling[child]
                depth += 1
                stack[depth] = child
    return order


@kernel(types.Tuple((_new64, _new32, _new64))(_int64, _int32, _int32, _int32))  # type: ignore[operator]
def lower_triangle(
    indptr: IntArray, indices: IndexArray, order: IndexArray, rank: IndexArray
) -> tuple[IntArray, IndexArray, IntArray]:
    """Return the lower triangle of ``A[order][:, order]`` by columns, and where its entries are.

    Returns
    -------
    starts : ndarray of shape (N + 1,), int64
    rows : ndarray, int32
    places : ndarray, int64
        The position of each entry in the data of A.
    """
    n = order.size
    most = (indices.size + n) // 2  # of a symmetric pattern, with every diagonal entry
    starts = np.zeros(n + 1, np.int64)
    rows, places = np.empty(most, np.int32), np.empty(most, np.int64)
    q = 0
    for j in range(n):
        _look_ahead(indptr, indices, order, j)
        for p in range(indptr[order[j]], indptr[order[j] + 1]):
            i = rank[indices[p]]
            if i >= j:
                rows[q], places[q] = i, p
                q += 1
        starts[j + 1] = q
    return starts, rows[:q], places[:q]


@kernel(_new32(_int64, _int32, _int32))  # type: ignore[operator]
def column_counts(starts: IntArray, rows: IndexArray, parent: IndexArray) -> IndexArray:
    """Return the number of entries in every column of the factor, the diagonal included.

    Column j has an entry in row i where j lies in the subtree of the elimination tree that the
    entries of row i of A span. The counts are sums over subtrees of +1 at the leaves of these
    subtrees and -1 where two of them meet.

    J. R. Gilbert, E. G. Ng, B. W. Peyton, *An Efficient Algorithm to Compute Row and Column Counts
    for Sparse Cholesky Factorization*, 1994, https://doi.org/10.1137/S089547989223692
    """
    n = parent.size
    count = np.zeros(n, np.int32)
    first = np.full(n, NONE, np.int32)  # the least descendant
    ancestor = np.empty(n, np.int32)
    for j in range(n):
        ancestor[j] = j
        count[j] = first[j] == NONE
        k = j
        while k != NONE and first[k] == NONE:
            first[k] = j
            k = parent[k]
    latest, previous = np.full(n, NONE, np.int32), np.full(n, NONE, np.int32)
    for j in range(n):
        if parent[j] != NONE:
            count[parent[j]] -= 1
        for p in range(starts[j], starts[j + 1]):
            i = rows[p]
            if i == j or first[j] <= latest[i]:  # not a leaf of the subtree of row i
                continue
            latest[i] = first[j]
            count[j] += 1
            if previous[i] != NONE:  # it meets the leaf before it at their common ancestor
                meet = previous[i]
                while meet != ancestor[meet]:
                    meet = ancestor[meet]
                count[meet] -= 1
                k = previous[i]
                while k != meet:
                    k, ancestor[k] = ancestor[k], meet
            previous[i] = j
        if parent[j] != NONE:
            ancestor[j] = parent[j]
    for j in range(n):
        if parent[j] != NONE:
            count[parent[j]] += count[j]
    return count


@kernel(_new32(_int32, _int32, types.UniTuple(types.float64, 4)))  # type: ignore[operator]
def supernodes(
    parent: IndexArray, counts: IndexArray, allowed: tuple[float, float, float, float]
) -> IndexArray:
    """Return the first column of every supernode, and N at the end.

    Columns that follow one another and share their rows form one; a supernode is then merged with
    the one before it, its child, while the zeros that this stores stay within `allowed`.
    """
    n = parent.size
    first = np.empty(n + 1, np.int32)
    entries = np.empty(n, np.int64)  # of the factor in the supernode, without the zeros
    done = 0
    start = 0
    while start < n:
        stop = start + 1
        while stop < n and parent[stop - 1] == stop and counts[stop - 1] == counts[stop] + 1:
            stop += 1
        begin, exact = start, np.int64(0)
        for j in range(start, stop):
            exact += counts[j]
        while done > 0:
            above = parent[begin - 1]
            if not begin <= above < stop:
                break
            merged, columns = first[done - 1], stop - first[done - 1]
            height = columns + counts[stop - 1] - 1
            full = np.int64(columns) * height - np.int64(columns) * (columns - 1) // 2
            zeros = full - exact - entries[done - 1]
            limit = allowed[(columns > 4) + (columns > 16) + (columns > 48)]
            if zeros > limit * full:
                break
            begin = merged
            exact += entries[done - 1]
            done -= 1
        first[done], entries[done] = begin, exact
        done += 1
        start = stop
    first[done] = n
    return first[: done + 1].copy()


@kernel(  # type: ignore[operator]
    types.Tuple((_new64, _new32, _new32))(_int64, _int32, _int32, _int32, _int32)
)
def supernode_rows(
    starts: IntArray, rows: IndexArray, parent: IndexArray, counts: IndexArray, first: IndexArray
) -> tuple[IntArray, IndexArray, IndexArray]:
    """Return the rows of every supernode in ascending order, and the tree of supernodes.

    Row i belongs to the supernodes on the ways from its entries of A up the tree to its own.
    Visiting the rows in order leaves each list sorted.

    Returns
    -------
    row_starts : ndarray of shape (S + 1,), int64
    supernode_rows : ndarray, int32
        The columns of the supernode itself come first.
    supernode_parent : ndarray of shape (S,), int32
    """
    n, n_supernodes = parent.size, first.size - 1
    owner = np.empty(n, np.int32)
    row_starts = np.zeros(n_supernodes + 1, np.int64)
    above = np.full(n_supernodes, NONE, np.int32)
    for s in range(n_supernodes):
        last = first[s + 1] - 1
        row_starts[s + 1] = row_starts[s] + (last - first[s]) + counts[last]
        for j in range(first[s], first[s + 1]):
            owner[j] = s
    for s in range(n_supernodes):
        root = parent[first[s + 1] - 1]
        above[s] = NONE if root == NONE else owner[root]
    # The transpose of the lower triangle gives the entries of each row.
    row_ends = np.zeros(n + 1, np.int64)
    for p in range(rows.size):
        row_ends[rows[p] + 1] += 1
    for i in range(n):
        row_ends[i + 1] += row_ends[i]
    fill = row_ends[:-1].copy()
    columns = np.empty(rows.size, np.int32)
    for j in range(n):
        for p in range(starts[j], starts[j + 1]):
            columns[fill[rows[p]]] = j
            fill[rows[p]] += 1
    lists, end = np.empty(row_starts[n_supernodes], np.int32), row_starts[:-1].copy()
    seen = np.full(n_supernodes, NONE, np.int32)
    for i in range(n):
        own = owner[i]
        for p in range(row_ends[i], row_ends[i + 1]):
            s = owner[columns[p]]
            while seen[s] != i:
                seen[s] = i
                lists[end[s]] = i
                end[s] += 1
                if s == own:
                    break
                s = above[s]
        if seen[own] != i:  # no entry of A leads here: not even the diagonal is in the pattern
            lists[end[own]] = i
            end[own] += 1
    return row_starts, lists, above


@kernel(types.int64(_int32, _int64, _int32))  # type: ignore[operator]
def stack_peak(first: IndexArray, row_starts: IntArray, above: IndexArray) -> int:
    """Return how many numbers the stack of update matrices holds at the most."""
    n_supernodes = above.size
    of_children = np.zeros(n_supernodes, np.int64)
    height, peak = np.int64(0), np.int64(1)
    for s in range(n_supernodes):
        below = (row_starts[s + 1] - row_starts[s]) - (first[s + 1] - first[s])
        peak = max(peak, height + below * below)
        height += below * below - of_children[s]
        if above[s] != NONE:
            of_children[above[s]] += below * below
    return int(peak)
