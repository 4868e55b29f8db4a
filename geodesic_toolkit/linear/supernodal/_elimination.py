"""What the Cholesky factor of a pattern looks like, before any number is known.

Eliminating a group of columns leaves entries in other rows, which the columns of its parent in a
tree take over. Everything here follows from that tree in nearly linear time.

J. W. H. Liu, *The Role of Elimination Trees in Sparse Factorization*, SIAM J. Matrix Anal. Appl.
11, 1990, https://doi.org/10.1137/0611010
"""

import numpy as np
from numba import types

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import IndexArray, IntArray

__all__ = [
    "is_symmetric",
    "postorder",
    "stack_peak",
    "structure",
    "supernodes",
]

HELPERS = "a66f349ab98391e9"
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


def is_symmetric(indptr: IntArray, indices: IndexArray) -> bool:
    """Return whether every entry of a pattern with sorted indices has its mirror image.

    The other kernels trust this and would write to places that are not theirs.
    """
    return _mirrored(indptr, indices, indptr[:-1].copy())


@kernel(types.boolean(_int64, _int32, _new64))
def _mirrored(indptr: IntArray, indices: IndexArray, mirror: IntArray) -> bool:
    """Do so; `mirror` is where the next entry of each column should have its image.

    Rows visited in order meet the entries of each column in order too.
    """
    last, start, column, image = (
        indices.size - 1,
        pointer(indptr),
        pointer(indices),
        pointer(mirror),
    )
    for i in range(mirror.size):
        for p in range(start[i], start[i + 1]):
            prefetch(shifted(column, image[column[min(p + AHEAD, last)]]))
            j = column[p]
            if image[j] == start[j + 1] or column[image[j]] != i:
                return False
            image[j] += 1
    return True


@part(inline=True)
def _look_ahead(indptr: IntArray, indices: IndexArray, order: IndexArray, i: int) -> None:
    """Fetch the rows that follow row ``order[i]``: they come in no order, and memory takes long."""
    if i + 2 * AHEAD < order.size:
        prefetch(shifted(pointer(indptr), np.int64(order[i + 2 * AHEAD])))
        prefetch(shifted(pointer(indices), indptr[order[i + AHEAD]]))


def postorder(parent: IndexArray) -> IndexArray:
    """Return the vertices of a forest, children before parents and subtrees together."""
    order, stack = np.empty_like(parent), np.empty_like(parent)
    _traverse(parent, np.full_like(parent, NONE), np.full_like(parent, NONE), stack, order)
    return order


@kernel(types.void(_int32, *(_new32,) * 4))
def _traverse(
    parent: IndexArray,
    first_child: IndexArray,
    sibling: IndexArray,
    stack: IndexArray,
    order: IndexArray,
) -> None:
    """Write the postorder; `first_child` and `sibling` are NONE before."""
    n, done = parent.size, 0
    for v in range(n - 1, -1, -1):
        if parent[v] != NONE:
            sibling[v] = first_child[parent[v]]
            first_child[parent[v]] = v
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


def supernodes(  # noqa: PLR0917 - as the order has them
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
    n_groups = len(post)
    vertices, first = np.empty_like(order), np.empty(n_groups + 1, dtype=np.int32)
    tallest, above, position, begins, last, owner = np.empty((6, n_groups), dtype=np.int32)
    entries = np.empty(n_groups, dtype=np.int64)
    count = _amalgamate(
        order, starts, heights, parents, post, allowed, vertices, first, tallest, above,
        position, begins, last, owner, entries,
    )  # fmt: skip
    return vertices, first[: count + 1].copy(), tallest[:count].copy(), above[:count].copy()


@kernel(types.int64(*(_int32,) * 5, types.UniTuple(types.float64, 4), *(_new32,) * 8, _new64))
def _amalgamate(  # noqa: PLR0917 - kernels take no keywords
    order: IndexArray,
    starts: IndexArray,
    heights: IndexArray,
    parents: IndexArray,
    post: IndexArray,
    allowed: tuple[float, float, float, float],
    vertices: IndexArray,
    first: IndexArray,
    tallest: IndexArray,
    above: IndexArray,
    position: IndexArray,
    begins: IndexArray,
    last: IndexArray,
    owner: IndexArray,
    entries: IntArray,
) -> int:
    """Write what `supernodes` returns, and return how many there are.

    Of groups: their `position` in the postorder, and what supernode is their `owner`. Of
    supernodes: from where to where in that order they are (`begins`, `last`), and how many
    `entries` of the factor they hold, without the zeros.
    """
    n_groups, column, done = post.size, 0, 0
    for k in range(n_groups):
        position[post[k]] = k
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
    for s in range(done):
        for k in range(begins[s], last[s] + 1):
            owner[post[k]] = s
    for s in range(done):
        parent = parents[post[last[s]]]
        above[s] = owner[parent] if parent != NONE else NONE
    return done


def structure(  # noqa: PLR0917 - as the analysis has them
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
    n, n_supernodes = len(order), len(above)
    most = (len(indices) + n) // 2  # of a symmetric pattern, with every diagonal entry
    starts = np.zeros(n + 1, dtype=np.int64)
    lower_rows, places = np.empty(most, dtype=np.int32), np.empty(most, dtype=np.int64)
    row_starts = np.zeros(n_supernodes + 1, dtype=np.int64)
    np.cumsum(np.minimum(tallest + n_full, n - first[:-1]), out=row_starts[1:])
    rows = np.empty(row_starts[-1], dtype=np.int32)
    owners = np.repeat(np.arange(n_supernodes, dtype=np.int32), np.diff(first))
    marks = np.full(n_supernodes, NONE, dtype=np.int32)
    count = _trace(
        indptr, indices, order, rank, above, owners, row_starts[:-1].copy(), marks,
        starts, lower_rows, places, row_starts, rows,
    )  # fmt: skip
    return starts, lower_rows[:count], places[:count], row_starts, rows[: row_starts[-1]]


@kernel(types.int64(_int64, *(_int32,) * 5, _new64, _new32, _new64, _new32, _new64, _new64, _new32))
def _trace(  # noqa: PLR0917 - kernels take no keywords
    indptr: IntArray,
    indices: IndexArray,
    order: IndexArray,
    rank: IndexArray,
    above: IndexArray,
    owners: IndexArray,
    ends: IntArray,
    marks: IndexArray,
    starts: IntArray,
    lower_rows: IndexArray,
    places: IntArray,
    row_starts: IntArray,
    rows: IndexArray,
) -> int:
    """Write what `structure` returns, and return how many entries the lower triangle has.

    `owners` are the supernodes of the columns. Rows of supernode s begin at ``row_starts[s]``, of
    which `ends` is a copy, and go up to the next; of supernodes `marks`, NONE before, are the rows
    that were there last.
    """
    n, n_supernodes = order.size, above.size
    entry, place, ranked, parent = pointer(indices), pointer(indptr), pointer(rank), pointer(above)
    lower, at, owner = pointer(lower_rows), pointer(places), pointer(owners)
    row, end, seen = pointer(rows), pointer(ends), pointer(marks)
    q = 0
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
    kept = 0
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
    return q


def stack_peak(first: IndexArray, row_starts: IntArray, above: IndexArray) -> int:
    """Return how many numbers the stack of update matrices holds at the most."""
    return _peak(first, row_starts, above, np.zeros(len(above), dtype=np.int64))


@kernel(types.int64(_int32, _int64, _int32, _new64))
def _peak(first: IndexArray, row_starts: IntArray, above: IndexArray, of_children: IntArray) -> int:
    """Return that; `of_children`, 0 before, is what the children of each supernode leave."""
    height, peak = 0, 1
    for s in range(above.size):
        below = (row_starts[s + 1] - row_starts[s]) - (first[s + 1] - first[s])
        peak = max(peak, height + below * below)
        height += below * below - of_children[s]
        if above[s] != NONE:
            of_children[above[s]] += below * below
    return peak
