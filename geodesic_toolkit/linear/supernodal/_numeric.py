"""The Cholesky factor, supernode by supernode: the multifrontal method.

Each supernode s gathers a dense *front*: its own entries of A, plus the update matrices of its
children. Eliminating its columns leaves a panel of the factor and an update matrix for its parent,
which waits on a stack until the parent comes, right after its last child. One piece of memory holds
two stacks, from either end: one for supernodes of even depth, one for those of odd depth. The
children lie on one, the parent's update matrix comes onto the other, and nothing is moved.

I. S. Duff, J. K. Reid, *The Multifrontal Solution of Indefinite Sparse Symmetric Linear*, ACM
Trans. Math. Softw. 9, 1983, https://doi.org/10.1145/356044.356047

On an M-matrix every sum here is one of numbers of one sign, so that each entry of the factor is
accurate relative to itself.
"""

import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._pointers import Pointer, pointer, prefetch, shifted
from geodesic_toolkit._typing import FloatArray, IndexArray, IntArray
from geodesic_toolkit.linear.supernodal._front import DONE, eliminate
from geodesic_toolkit.linear.supernodal._halves import numbers
from geodesic_toolkit.linear.supernodal._subnormals import flush_subnormals, restore_subnormals

__all__ = ["factorize"]

HELPERS = "49df0791a967349c"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

AHEAD = 64
"""Entries of the matrix by which memory is asked for ahead: they are taken in no order."""

NONE = -1

_int64 = types.Array(types.int64, 1, "C", readonly=True)
_int32 = types.Array(types.int32, 1, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)


@part(fused=True)
def _add(  # noqa: PLR0917 - kernels take no keywords
    target: Pointer, stride: int, child: Pointer, places: Pointer, count: int, begin: int, end: int
) -> None:
    """Add some columns of a child's update matrix to its parent's, at rows and columns `places`.

    The parent's are `stride` apart; the child has `count` rows.
    """
    for j in range(begin, end):
        source, column = j * count, places[j] * stride
        for i in range(j, count):
            target[column + places[i]] += child[source + i]


@part(inline=True)
def _locate(places: Pointer, local: Pointer, rows: Pointer, count: int, width: int) -> int:
    """Write the places of rows in a front; return how many are among its columns."""
    inside = 0
    for k in range(count):
        places[k] = local[rows[k]]
        inside += places[k] < width
    return inside


@part(fused=True)
def _below(s: int, first: IndexArray, row_starts: IntArray) -> tuple[int, int]:
    """Return where the rows below the columns of a supernode begin, and how many there are."""
    begin = row_starts[s] + first[s + 1] - first[s]
    return begin, row_starts[s + 1] - begin


@kernel(
    types.int64(
        _values, _int64, _int32, _int64, _int32, _int64, _int32, _int32, _int64,
        types.float64[::1], types.uint32[::1],
        *(types.float64[::1],) * 4, types.int64[::1],
    ),
    fused=True,
)  # fmt: skip
def factorize(  # noqa: PLR0912, PLR0915, PLR0917 - one sweep; kernels take no keywords
    data: FloatArray,
    starts: IntArray,
    lower_rows: IndexArray,
    places: IntArray,
    first: IndexArray,
    row_starts: IntArray,
    rows: IndexArray,
    above: IndexArray,
    panels: IntArray,
    factor: FloatArray,
    halves: NDArray[np.uint32],
    front: FloatArray,
    stack: FloatArray,
    pack: FloatArray,
    pivots: FloatArray,
    room: IntArray,
) -> int:
    """Compute the panels of the factor; return the column of the first pivot <= 0, or -1.

    Parameters
    ----------
    data : ndarray
        The values of the matrix.
    starts, lower_rows, places, first, row_starts, rows, above, panels : ndarray
        Fields of the analysis.
    factor, halves : ndarray
        One of them receives the panels, or their upper halves, with the inverse of the diagonal;
        the other one is empty.
    front : ndarray
        Room for the largest panel and LANES numbers more, if only halves of them are kept.
    stack : ndarray
        Room for update matrices.
    pack : ndarray
        Room for :func:`~geodesic_toolkit.linear.supernodal._front.eliminate`.
    pivots : ndarray of shape (N,)
        Receives the share of each diagonal entry that elimination leaves.
    room : ndarray of shape (2 N + 3 S,), int64
        To work in, too.
    """
    n, n_supernodes = pivots.size, above.size
    local, child_rows, waiting = pointer(room), pointer(room[n:]), pointer(room[2 * n :])
    waiting_at, odd = shifted(waiting, n_supernodes), shifted(waiting, 2 * n_supernodes)
    for s in range(n_supernodes - 1, -1, -1):
        odd[s] = above[s] != NONE and not odd[above[s]]
    n_waiting, low, high = 0, 0, stack.size
    kept, updates, row = numbers(halves), pointer(stack), pointer(rows)
    by_halves = halves.size > 0
    own_panels = pointer(front if by_halves else factor)
    values, last, packed = pointer(data), places.size - 1, pointer(pack)
    mode = flush_subnormals()
    for s in range(n_supernodes):
        start, begin = row_starts[s], first[s]
        height, width = row_starts[s + 1] - start, first[s + 1] - begin
        below = height - width
        panel = shifted(own_panels, 0 if by_halves else panels[s])
        at = high - below * below if odd[s] else low
        update = shifted(updates, at)

        # -- the front: entries of A, and what the children leave ----------------------------------
        for k in range(height):  # the place of a row in this front
            local[row[start + k]] = k
        for k in range(height * width):
            panel[k] = 0.0
        for j in range(width):
            for p in range(starts[begin + j], starts[begin + j + 1]):
                prefetch(shifted(values, places[min(p + AHEAD, last)]))
                panel[j * height + local[lower_rows[p]]] += values[places[p]]
        for j in range(width):
            pivots[begin + j] = panel[j * height + j]
        children = n_waiting
        while children > 0 and above[waiting[children - 1]] == s:
            children -= 1
            outer, count = _below(waiting[children], first, row_starts)
            inside = _locate(child_rows, local, shifted(row, outer), count, width)
            child = shifted(updates, waiting_at[children])
            _add(panel, height, child, child_rows, count, 0, inside)

        # -- elimination: what it leaves below, and what the children leave there ------------------
        failed = eliminate(panel, update, height, width, packed)
        if failed != DONE:
            restore_subnormals(mode)
            return int(begin + failed)
        corner = shifted(update, -width * (below + 1))
        for q in range(children, n_waiting):
            outer, count = _below(waiting[q], first, row_starts)
            inside = _locate(child_rows, local, shifted(row, outer), count, width)
            child = shifted(updates, waiting_at[q])
            _add(corner, below, child, child_rows, count, inside, count)
        for j in range(width):
            root = 1 / panel[j * height + j]
            pivots[begin + j] = root * root / pivots[begin + j]
        if by_halves:
            for k in range(height * width):
                kept[panels[s] + k] = panel[k]

        # -- the children leave the stack on their side, and the update matrix stays on the other --
        if children < n_waiting:
            if odd[s]:
                low = waiting_at[children]
            else:
                _, count = _below(waiting[children], first, row_starts)
                high = waiting_at[children] + count * count
        n_waiting = children
        if below:
            waiting[n_waiting], waiting_at[n_waiting] = s, at
            n_waiting += 1
            if odd[s]:
                high = at
            else:
                low = at + below * below
    restore_subnormals(mode)
    return DONE
