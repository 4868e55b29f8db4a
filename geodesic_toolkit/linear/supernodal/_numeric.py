"""The Cholesky factor, supernode by supernode: the multifrontal method.

Each supernode s gathers a dense *front*: its own entries of A, plus the update matrices of its
children. Eliminating its columns leaves a panel of the factor and an update matrix for its parent,
which waits on a stack until the parent comes, right after its last child.

I. S. Duff, J. K. Reid, *The Multifrontal Solution of Indefinite Sparse Symmetric Linear*, ACM
Trans. Math. Softw. 9, 1983, https://doi.org/10.1145/356044.356047

On an M-matrix every sum here is one of numbers of one sign, so that each entry of the factor is
accurate relative to itself.
"""

import math

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._pointers import (
    Pointer,
    address,
    pointer,
    prefetch,
    shifted,
)
from geodesic_toolkit._typing import FloatArray, IndexArray, IntArray
from geodesic_toolkit.linear.supernodal import _blas
from geodesic_toolkit.linear.supernodal._halves import numbers

__all__ = ["factorize"]

NARROW, SHORT = 8, 48
"""Columns and rows up to which plain loops beat a call to the BLAS."""

AHEAD = 64
"""Entries of the matrix by which memory is asked for ahead: they are taken in no order."""

DONE = -1

_int64 = types.Array(types.int64, 1, "C", readonly=True)
_int32 = types.Array(types.int32, 1, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)

# Sums may be reordered, which is how they are vectorised; infinities and NaN keep their meaning.
kernel = numba.njit(
    cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"}
)


@kernel  # type: ignore[untyped-decorator]
def _add_child(  # noqa: PLR0917 - kernels take no keywords
    panel: Pointer,
    update: Pointer,
    height: int,
    width: int,
    child: Pointer,
    places: Pointer,
    count: int,
) -> None:
    """Add a child's update matrix to the front of its parent, at the rows and columns `places`."""
    below = height - width
    for j in range(count):
        source, column = j * count, places[j]
        if column < width:
            target = column * height
            for i in range(j, count):
                panel[target + places[i]] += child[source + i]
        else:
            target = (column - width) * below - width
            for i in range(j, count):
                update[target + places[i]] += child[source + i]


@kernel  # type: ignore[untyped-decorator]
def _eliminate(panel: Pointer, update: Pointer, height: int, width: int, fresh: bool) -> int:
    """Eliminate the columns of a small front in place; return the first pivot <= 0, or -1."""
    below = height - width
    for c in range(width):
        column = c * height
        pivot = panel[column + c]
        if not pivot > 0:
            return c
        root = math.sqrt(pivot)
        panel[column + c] = root
        inverse = 1 / root
        for i in range(c + 1, height):
            panel[column + i] *= inverse
        for k in range(c + 1, width):
            factor, later = panel[column + k], k * height
            for i in range(k, height):
                panel[later + i] -= factor * panel[column + i]
        tail = column + width
        for j in range(below):
            factor, target = panel[tail + j], j * below
            if fresh and c == 0:
                for i in range(j, below):
                    update[target + i] = -factor * panel[tail + i]
            else:
                for i in range(j, below):
                    update[target + i] -= factor * panel[tail + i]
    return DONE


@numba.njit(  # type: ignore[untyped-decorator]
    types.int64(
        _values, _int64, _int32, _int64, _int32, _int64, _int32, _int32, _int64,
        types.float64[::1], types.uint32[::1],
        types.float64[::1], types.float64[::1], types.float64[::1], types.int64[::1],
    ),
    cache=True, nogil=True, error_model="numpy",
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
        Room for the largest panel, if only halves of them are kept.
    stack : ndarray
        Room for update matrices.
    pivots : ndarray of shape (N,)
        Receives the share of each diagonal entry that elimination leaves.
    room : ndarray of shape (2 N,), int64
    """
    n_supernodes = above.size
    waiting, waiting_at = np.empty(n_supernodes, np.int32), np.empty(n_supernodes, np.int64)
    n_waiting, top = 0, np.int64(0)
    kept, updates, row = numbers(halves), pointer(stack), pointer(rows)
    by_halves = halves.size > 0
    own_panels = pointer(front if by_halves else factor)
    local, child_rows = pointer(room), pointer(room[pivots.size :])
    memory, values, last = _blas.arguments(), pointer(data), places.size - 1
    for s in range(n_supernodes):
        start, begin = row_starts[s], np.int64(first[s])
        height, width = row_starts[s + 1] - start, first[s + 1] - begin
        below = height - width
        panel = shifted(own_panels, 0 if by_halves else panels[s])
        update = shifted(updates, top)

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
        n_children = 0
        while n_children < n_waiting and above[waiting[n_waiting - 1 - n_children]] == s:
            n_children += 1
        base = top
        if n_children:
            base = waiting_at[n_waiting - n_children]
            for k in range(below * below):
                update[k] = 0.0
        for q in range(n_waiting - n_children, n_waiting):
            child = waiting[q]
            outer = row_starts[child] + first[child + 1] - first[child]
            count = row_starts[child + 1] - outer
            for k in range(count):
                child_rows[k] = local[row[outer + k]]
            matrix = shifted(updates, waiting_at[q])
            _add_child(panel, update, height, width, matrix, child_rows, count)
        n_waiting -= n_children

        # -- elimination ---------------------------------------------------------------------------
        fresh = n_children == 0
        if width <= NARROW and below <= SHORT:
            failed = _eliminate(panel, update, height, width, fresh)
            if failed != DONE:
                return int(begin + failed)
        else:
            triangle = address(panel)
            rest = triangle + np.uintp(8 * width)
            failed = _blas.cholesky(memory, triangle, width, height)
            if failed:
                return int(begin + failed - 1)
            if below:
                _blas.divide(memory, rest, height, below, triangle, height, width, True)
                _blas.minus_gram(memory, rest, height, below, width, address(update), fresh)
        for j in range(width):
            root = panel[j * height + j]
            pivots[begin + j] = root * root / pivots[begin + j]
            panel[j * height + j] = 1 / root  # so that substitution need not divide
        if by_halves:
            for k in range(height * width):
                kept[panels[s] + k] = panel[k]

        # -- the update matrix takes the place of the children's on the stack ----------------------
        if base != top:
            lower = shifted(updates, base)
            for k in range(below * below):
                lower[k] = update[k]
        if below:
            waiting[n_waiting], waiting_at[n_waiting] = s, base
            n_waiting += 1
        top = base + below * below
    return DONE
