"""What the Cholesky factor of a pattern looks like, before any number is known.

Eliminating a group of columns leaves entries in other rows, which the columns of its parent in a
tree take over. Everything here follows from that tree in nearly linear time.

J. W. H. Liu, *The Role of Elimination Trees in Sparse Factorization*, SIAM J. Matrix Anal. Appl.
11, 1990, https://doi.org/10.1137/0611010
"""

import numba
import numpy as np
from numba import types

from geodesic_toolkit._pointers import keep, pointer, prefetch, shifted
from geodesic_toolkit._typing import IndexArray, IntArray

__all__ = [
    "is_symmetric",
    "postorder",
    "stack_peak",
    "structure",
    "supernodes",
]

HELPERS = "5b7e21d9922a23a1"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

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


@kernel(  # type: ignore[operator]
    types.Tuple((_new32,) * 4)(*(_int32,) * 5, types.UniTuple(types.float64, 4))
)
def supernodes(  # noqa: PLR0917 - kernels take no keywords
    order: IndexArray,
    starts: IndexArray,
    heights: IndexArray,
    parents: IndexArray,
    post: IndexArray,
    allowed: tuple[float, float, float, float],
) -> tuple[IndexArray, IndexArray, IndexArray, IndexArray]:
    """Merge groups of columns with their parents while the zeros this stores stay within `allowed`.

    Parameters
    ----------
    order, starts, heights, parents : ndarray
        As :class:`~geodesic_toolkit.linear.supernodal._ordering.Elimination` has them.
    post : ndarray of shape (G,), int32
        A postorder of the groups.
    allowed : tuple of float
        Share of zeros, as `STRICT` has it.

    Returns
    -------
    order : ndarray of shape (N,), int32
        The vertices in that postorder.
    first : ndarray of shape (S + 1,), int32
        The first column of every supernode, and N at the end.
    tallest : ndarray of shape (S,), int32
        Rows of each.
    above : ndarray of shape (S,), int32
        Their parents, -1 at roots.
    """
    n_groups = post.size
    position = np.empty(n_groups, np.int32)
    for k in range(n_groups):
        position[post[k]] = k
    vertices, column = np.empty_like(order), 0
    first, tallest = np.empty(n_groups + 1, np.int32), np.empty(n_groups, np.int32)
    entries = np.empty(n_groups, np.int64)  # of the factor in the supernode, without the zeros
    begins, last = np.empty(n_groups, np.int32), np.empty(n_groups, np.int32)  # by positions
    done = 0
    for k in range(n_groups):
        begin, height, exact = column, np.int64(heights[post[k]]), np.int64(0)
        for v in range(starts[post[k]], starts[post[k] + 1]):
            vertices[column] = order[v]
            column += 1
            exact += height
            height -= 1
        earliest = k
        while done > 0:
            parent = parents[post[last[done - 1]]]
            if parent == NONE or not earliest <= position[parent] <= k:
                break
            columns = column - first[done - 1]
            whole = columns + height
            full = columns * whole - columns * (columns - 1) // 2
            zeros = full - exact - entries[done - 1]
            limit = allowed[(columns > 4) + (columns > 16) + (columns > 48)]
            if zeros > limit * full:
                break
            done -= 1
            begin, earliest = first[done], begins[done]
            exact += entries[done]
        first[done], tallest[done], entries[done] = begin, column - begin + height, exact
        begins[done], last[done] = earliest, k
        done += 1
    first[done] = column
    owner = np.empty(n_groups, np.int32)  # the supernode that has become of a group
    for s in range(done):
        for k in range(begins[s], last[s] + 1):
            owner[post[k]] = s
    above = np.empty(done, np.int32)
    for s in range(done):
        parent = parents[post[last[s]]]
        above[s] = owner[parent] if parent != NONE else NONE
    return vertices, first[: done + 1].copy(), tallest[:done].copy(), above


@kernel(  # type: ignore[operator]
    types.Tuple((_new64, _new32, _new64, _new64, _new32))(_int64, *(_int32,) * 6, types.int64)
)
def structure(  # noqa: PLR0917 - kernels take no keywords
    indptr: IntArray,
    indices: IndexArray,
    order: IndexArray,
    rank: IndexArray,
    first: IndexArray,
    tallest: IndexArray,
    above: IndexArray,
    n_full: int,
) -> tuple[IntArray, IndexArray, IntArray, IntArray, IndexArray]:
    """Return the lower triangle of ``A[order][:, order]`` and the rows of every supernode.

    Row i belongs to the supernodes on the ways from its entries of A up the tree to its own.
    Visiting the rows in order leaves each list sorted.

    Parameters
    ----------
    indptr, indices : ndarray
        The pattern of A.
    order, rank : ndarray of shape (N,), int32
        A permutation and its inverse.
    first, tallest, above : ndarray
        As `supernodes` returns them.
    n_full : int
        Rows at the end that are not counted in `tallest`.

    Returns
    -------
    starts : ndarray of shape (N + 1,), int64
    lower_rows : ndarray, int32
        The lower triangle by columns.
    places : ndarray, int64
        The position of each of its entries in the data of A.
    row_starts : ndarray of shape (S + 1,), int64
    rows : ndarray, int32
        Those of supernode s, its own columns first, are ``rows[row_starts[s]:row_starts[s + 1]]``.
    """
    n, n_supernodes = order.size, above.size
    most = (indices.size + n) // 2  # of a symmetric pattern, with every diagonal entry
    starts = np.zeros(n + 1, np.int64)
    lower_rows, places = np.empty(most, np.int32), np.empty(most, np.int64)
    owners, row_starts = np.empty(n, np.int32), np.zeros(n_supernodes + 1, np.int64)
    for s in range(n_supernodes):
        row_starts[s + 1] = row_starts[s] + min(tallest[s] + n_full, n - first[s])
        for j in range(first[s], first[s + 1]):
            owners[j] = s
    rows, ends = np.empty(row_starts[n_supernodes], np.int32), row_starts[:-1].copy()
    marks = np.full(n_supernodes, NONE, np.int32)
    entry, place, ranked, parent = pointer(indices), pointer(indptr), pointer(rank), pointer(above)
    lower, at, owner = pointer(lower_rows), pointer(places), pointer(owners)
    row, end, seen = pointer(rows), pointer(ends), pointer(marks)
    q = np.int64(0)
    for i in range(n):
        _look_ahead(indptr, indices, order, i)
        own = owner[i]
        seen[own] = i
        for p in range(place[order[i]], place[order[i] + 1]):
            j = ranked[entry[p]]
            if j >= i:
                lower[q], at[q] = j, p
                q += 1
                continue
            s = owner[j]
            while seen[s] != i:
                seen[s] = i
                row[end[s]] = i
                end[s] += 1
                s = parent[s]
        row[end[own]] = i
        end[own] += 1
        starts[i + 1] = q
    kept = np.int64(0)
    for s in range(n_supernodes):  # close the gaps that full rows may have left
        begin = row_starts[s]
        row_starts[s] = kept
        if kept == begin:
            kept = end[s]
            continue
        for k in range(begin, end[s]):
            rows[kept] = rows[k]
            kept += 1
    row_starts[n_supernodes] = kept
    keep((owners, ends, marks))
    return starts, lower_rows[:q], places[:q], row_starts, rows[:kept]


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
