"""Forward and back substitution through the supernodes: one column, or a block of them.

A solve reads the factor twice and does little with it, so it is as fast as memory is. A block of
right-hand sides shares the reading. Where a right-hand side is zero in all of a supernode's
subtree, so is the solution of ``L y = b``, and the forward substitution passes it by: heat from one
vertex touches only the way from there to the root.
"""

import numpy as np
from numba import types

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._pointers import Pointer, pointer, prefetch, shifted
from geodesic_toolkit._typing import FloatArray, IndexArray, IntArray
from geodesic_toolkit.linear.supernodal._columns import (
    dot_columns,
    dot_rows,
    minus_columns,
    minus_rows,
)
from geodesic_toolkit.linear.supernodal._halves import numbers, per_line
from geodesic_toolkit.linear.supernodal._rows import (
    BLOCK,
    copy_row,
    four_minus_rows,
    minus_one,
    rows_minus_four,
)
from geodesic_toolkit.linear.supernodal._subnormals import flush_subnormals, restore_subnormals
from geodesic_toolkit.linear.supernodal.analysis import LANES, Panels

__all__ = ["BLOCK", "solve_block", "solve_column"]

HELPERS = "cdebf00a3a429647"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

_int64 = types.Array(types.int64, 1, "C", readonly=True)
_int32 = types.Array(types.int32, 1, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)
_halves = types.Array(types.uint32, 1, "C", readonly=True)
_block = types.Array(types.float64, 2, "C", readonly=True)
_symbolic = (_int32, _int32, _int64, _int32, _int64)
_room = types.float64[::1]

FEW = 4
"""Columns of a supernode up to which x is worked on where it is."""

AHEAD = 1024
"""Numbers of a factor between those that a single column meets and those that are fetched: most
runs of a panel end before a processor has foreseen how they go on."""

CACHED = 2**20
"""Bytes of a factor that stays in the cache from one solve to the next, where nothing is fetched.
"""


@part(fused=True)
def _columns(panel: int, height: int, c: int, count: int) -> tuple[int, int, int, int]:
    """Return where up to four columns of a panel are, from c on, and that of the first for others.

    From their row c on, that is.
    """
    p = panel + c * height + c
    q = p + height if count > 1 else p
    r = q + height if count > 2 else p
    s = r + height if count > 3 else p
    return p, q, r, s


@part(fused=True)
def _fetch(factor: Pointer, begin: int, count: int, ahead: int) -> None:
    """Ask for what is `ahead` of some numbers of a factor, be it behind its end; of 0, for nothing.

    A negative number is ahead of those who go backward.
    """
    if ahead == 0:
        return
    for k in range(begin + ahead, begin + ahead + count, per_line(factor)):
        prefetch(shifted(factor, k))


@part(fused=True)
def _forward_four(
    x: Pointer, count: int, factor: Pointer, at: tuple[int, int, int, int]
) -> tuple[float, float, float, float]:
    """Solve with a triangle of up to four columns, ``x[:count]`` in place; others are 0."""
    p, q, r, s = at
    x0, x1, x2, x3 = x[0] * factor[p], 0.0, 0.0, 0.0
    x[0] = x0
    if count > 1:
        x1 = (x[1] - factor[p + 1] * x0) * factor[q + 1]
        x[1] = x1
    if count > 2:
        x2 = x[2] - factor[p + 2] * x0 - factor[q + 2] * x1
        x2 *= factor[r + 2]
        x[2] = x2
    if count > 3:
        x3 = x[3] - factor[p + 3] * x0 - factor[q + 3] * x1 - factor[r + 3] * x2
        x3 *= factor[s + 3]
        x[3] = x3
    return x0, x1, x2, x3


@part(fused=True)
def _backward_four(
    x: Pointer,
    count: int,
    factor: Pointer,
    at: tuple[int, int, int, int],
    below: tuple[float, float, float, float],
) -> None:
    """Solve with the transposed triangle; `below` are the products of the rows below it."""
    p, q, r, s = at
    x0, x1, x2, x3 = x[0] - below[0], 0.0, 0.0, 0.0
    if count > 3:
        x3 = (x[3] - below[3]) * factor[s + 3]
        x[3] = x3
        x0 -= factor[p + 3] * x3
    if count > 2:
        x2 = x[2] - below[2]
        if count > 3:
            x2 -= factor[r + 3] * x3
        x2 *= factor[r + 2]
        x[2] = x2
        x0 -= factor[p + 2] * x2
    if count > 1:
        x1 = x[1] - below[1]
        if count > 2:
            x1 -= factor[q + 2] * x2
        if count > 3:
            x1 -= factor[q + 3] * x3
        x1 *= factor[q + 1]
        x[1] = x1
        x0 -= factor[p + 1] * x1
    x[0] = x0 * factor[p]


@part(inline=True)
def _forward(  # noqa: PLR0917 - kernels take no keywords
    x: Pointer, width: int, height: int, factor: Pointer, panel: int, ahead: int
) -> None:
    """Solve with the triangle of a panel in place, and subtract what that means for the rows below.

    Four columns at a time, so that x is read and written a quarter as often. Where fewer are left,
    the first of them stands for the others, times zero.
    """
    for c in range(0, width, 4):
        count = min(width - c, 4)
        at = _columns(panel, height, c, count)
        _fetch(factor, at[0], count * height, ahead)
        x0, x1, x2, x3 = _forward_four(shifted(x, c), count, factor, at)
        p, q, r, s = at[0] + count, at[1] + count, at[2] + count, at[3] + count
        end = c + count
        minus_columns(x, end, height - end, factor, p, q, r, s, x0, x1, x2, x3)


@part(inline=True)
def _backward(  # noqa: PLR0917 - kernels take no keywords
    x: Pointer, width: int, height: int, factor: Pointer, panel: int, ahead: int
) -> None:
    """Solve with the transposed triangle of a panel in place, given the solution below it."""
    for c in range((width - 1) // 4 * 4, -1, -4):
        count = min(width - c, 4)
        at = _columns(panel, height, c, count)
        _fetch(factor, at[0], count * height, -ahead)
        p, q, r, s = at[0] + count, at[1] + count, at[2] + count, at[3] + count
        end = c + count
        below = dot_columns(x, end, height - end, factor, p, q, r, s)
        _backward_four(shifted(x, c), count, factor, at, below)


@kernel(
    *(types.boolean(_values, *_symbolic, factor, _room, _room) for factor in (_values, _halves)),
    fused=True,
)
def solve_column(  # noqa: PLR0912, PLR0917 - two sweeps; kernels take no keywords
    right_hand_side: FloatArray,
    order: IndexArray,
    first: IndexArray,
    row_starts: IntArray,
    rows: IndexArray,
    panels: IntArray,
    panel_values: Panels,
    room: FloatArray,
    solution: FloatArray,
) -> bool:
    """Write x with ``A x = b`` to `solution`, and return whether all of it is finite.

    Parameters
    ----------
    right_hand_side : ndarray of shape (N,)
    order, first, row_starts, rows, panels : ndarray
        Fields of the analysis.
    panel_values : ndarray
        The factor.
    room : ndarray of shape (N + 1 + T + LANES,)
        To work in, T being the height of the tallest supernode.
    solution : ndarray of shape (N,)
    """
    n, n_supernodes = order.size, first.size - 1
    x, own = pointer(room), pointer(room[n + 1 :])  # x has one more row, which means nothing
    row, factor = pointer(rows), numbers(panel_values)  # `own`: what belongs to one supernode
    ahead = AHEAD if panel_values.size * panel_values.itemsize > CACHED else 0
    mode = flush_subnormals()
    for j in range(n):
        x[j] = right_hand_side[order[j]]
    for s in range(n_supernodes):
        begin, start = np.int64(first[s]), row_starts[s]
        width, height = first[s + 1] - begin, row_starts[s + 1] - start
        touched = False
        for j in range(begin, begin + width):
            touched |= x[j] != 0.0
        if not touched:
            continue
        below = shifted(row, start + width)
        if width <= FEW:  # most are: no copy, and a loop or two
            at = _columns(panels[s], height, 0, width)
            _fetch(factor, panels[s], width * height, ahead)
            x0, x1, x2, x3 = _forward_four(shifted(x, begin), width, factor, at)
            p, q, r, t = at[0] + width, at[1] + width, at[2] + width, at[3] + width
            minus_rows(x, below, height - width, n, factor, p, q, r, t, x0, x1, x2, x3)
            continue
        for j in range(width):
            own[j] = x[begin + j]
        for k in range(width, height):
            own[k] = 0.0
        _forward(own, width, height, factor, panels[s], ahead)
        for j in range(width):
            x[begin + j] = own[j]
        for k in range(width, height):
            x[row[start + k]] += own[k]
    x[n] = 0.0
    for s in range(n_supernodes - 1, -1, -1):
        begin, start = np.int64(first[s]), row_starts[s]
        width, height = first[s + 1] - begin, row_starts[s + 1] - start
        if width <= FEW:
            at = _columns(panels[s], height, 0, width)
            _fetch(factor, panels[s], width * height, -ahead)
            p, q, r, t = at[0] + width, at[1] + width, at[2] + width, at[3] + width
            below = shifted(row, start + width)
            dots = dot_rows(x, below, height - width, n, factor, p, q, r, t)
            _backward_four(shifted(x, begin), width, factor, at, dots)
            continue
        for j in range(width):
            own[j] = x[begin + j]
        for k in range(width, height):
            own[k] = x[row[start + k]]
        for k in range(height, height + LANES):
            own[k] = 0.0
        _backward(own, width, height, factor, panels[s], ahead)
        for j in range(width):
            x[begin + j] = own[j]
    nothing = 0.0
    for j in range(n):
        solution[order[j]] = x[j]
        nothing += 0.0 * x[j]
    restore_subnormals(mode)
    return nothing == 0.0


@part(fused=True)
def _forward_block(  # noqa: PLR0917 - kernels take no keywords
    x: Pointer,
    head: Pointer,
    width: int,
    height: int,
    factor: Pointer,
    panel: int,
    row: Pointer,
    start: int,
) -> None:
    """Solve with a panel in place for a block, and subtract what that means for the rows below.

    `head` holds the solution of the four columns at hand, apart from x.
    """
    c = 0
    while c + 4 <= width:
        p = panel + c * height + c
        q, r, s = p + height, p + 2 * height, p + 3 * height
        j = np.int64(row[start + c]) * BLOCK
        for k in range(BLOCK):
            x0 = x[j + k] * factor[p]
            x1 = (x[j + BLOCK + k] - factor[p + 1] * x0) * factor[q + 1]
            x2 = x[j + 2 * BLOCK + k] - factor[p + 2] * x0 - factor[q + 2] * x1
            x2 *= factor[r + 2]
            x3 = x[j + 3 * BLOCK + k] - factor[p + 3] * x0 - factor[q + 3] * x1
            x3 = (x3 - factor[r + 3] * x2) * factor[s + 3]
            head[k], head[BLOCK + k], head[2 * BLOCK + k], head[3 * BLOCK + k] = x0, x1, x2, x3
        for k in range(4):
            copy_row(x, j + k * BLOCK, head, k * BLOCK)
        below = shifted(row, start + c + 4)
        rows_minus_four(x, below, height - c - 4, head, factor, p + 4, q + 4, r + 4, s + 4)
        c += 4
    while c < width:
        p = panel + c * height + c
        j = np.int64(row[start + c]) * BLOCK
        for k in range(BLOCK):
            head[k] = x[j + k] * factor[p]
        copy_row(x, j, head, 0)
        for i in range(1, height - c):
            minus_one(x, np.int64(row[start + c + i]) * BLOCK, head, 0, factor[p + i])
        c += 1


@part(fused=True)
def _backward_block(  # noqa: PLR0917 - kernels take no keywords
    x: Pointer,
    head: Pointer,
    width: int,
    height: int,
    factor: Pointer,
    panel: int,
    row: Pointer,
    start: int,
) -> None:
    """Solve with the transposed triangle of a panel in place for a block."""
    c = width
    while c >= 4:
        c -= 4
        p = panel + c * height + c
        q, r, s = p + height, p + 2 * height, p + 3 * height
        j = np.int64(row[start + c]) * BLOCK
        for k in range(4):
            copy_row(head, k * BLOCK, x, j + k * BLOCK)
        below = shifted(row, start + c + 4)
        four_minus_rows(head, x, below, height - c - 4, factor, p + 4, q + 4, r + 4, s + 4)
        for k in range(BLOCK):
            x3 = head[3 * BLOCK + k] * factor[s + 3]
            x2 = (head[2 * BLOCK + k] - factor[r + 3] * x3) * factor[r + 2]
            x1 = head[BLOCK + k] - factor[q + 2] * x2 - factor[q + 3] * x3
            x1 *= factor[q + 1]
            x0 = head[k] - factor[p + 1] * x1 - factor[p + 2] * x2 - factor[p + 3] * x3
            x[j + k], x[j + BLOCK + k] = x0 * factor[p], x1
            x[j + 2 * BLOCK + k], x[j + 3 * BLOCK + k] = x2, x3
    while c > 0:
        c -= 1
        p = panel + c * height + c
        j = np.int64(row[start + c]) * BLOCK
        copy_row(head, 0, x, j)
        for i in range(1, height - c):
            minus_one(head, 0, x, np.int64(row[start + c + i]) * BLOCK, factor[p + i])
        for k in range(BLOCK):
            x[j + k] = head[k] * factor[p]


@part()
def _take_block(x: Pointer, given: Pointer, n_columns: int, order: IndexArray) -> None:
    """Write the rows of a block to x, in the order of the factor and filled up with zeros."""
    for j in range(order.size):
        begin = np.int64(order[j]) * n_columns
        if n_columns == BLOCK:
            copy_row(x, j * BLOCK, given, begin)
            continue
        for k in range(n_columns):
            x[j * BLOCK + k] = given[begin + k]
        for k in range(n_columns, BLOCK):
            x[j * BLOCK + k] = 0.0


@part()
def _give_block(
    x: Pointer, room: Pointer, found: Pointer, n_columns: int, order: IndexArray
) -> bool:
    """Write x to the rows of a block, and return whether all of it is finite."""
    for k in range(BLOCK):
        room[k] = 0.0
    for j in range(order.size):
        minus_one(room, 0, x, j * BLOCK, 0.0)  # stays 0 if that is finite
        begin = np.int64(order[j]) * n_columns
        if n_columns == BLOCK:
            copy_row(found, begin, x, j * BLOCK)
            continue
        for k in range(n_columns):
            found[begin + k] = x[j * BLOCK + k]
    nothing = 0.0
    for k in range(BLOCK):
        nothing += room[k]
    return nothing == 0.0


@kernel(
    *(
        types.boolean(_block, *_symbolic, factor, _room, types.float64[:, ::1])
        for factor in (_values, _halves)
    )
)
def solve_block(  # noqa: PLR0917 - kernels take no keywords
    right_hand_sides: FloatArray,
    order: IndexArray,
    first: IndexArray,
    row_starts: IntArray,
    rows: IndexArray,
    panels: IntArray,
    panel_values: Panels,
    room: FloatArray,
    solution: FloatArray,
) -> bool:
    """Write X with ``A X = B`` to `solution`, for up to `BLOCK` columns at once.

    Return whether all of it is finite. The block is always full inside, so that its loops are
    unrolled; missing columns are zero. Parameters as for `solve_column`, but `room` has
    ``BLOCK * (N + 4)`` numbers.
    """
    n, n_supernodes, n_columns = order.size, first.size - 1, right_hand_sides.shape[1]
    x, head = pointer(room), pointer(room[n * BLOCK :])
    row, factor = pointer(rows), numbers(panel_values)
    mode = flush_subnormals()
    _take_block(x, pointer(right_hand_sides), n_columns, order)
    for s in range(n_supernodes):
        touched = False
        for j in range(first[s] * BLOCK, first[s + 1] * BLOCK):
            touched |= x[j] != 0.0
        if touched:
            start, width = row_starts[s], first[s + 1] - first[s]
            height = row_starts[s + 1] - start
            _forward_block(x, head, width, height, factor, panels[s], row, start)
    for s in range(n_supernodes - 1, -1, -1):
        start, width = row_starts[s], first[s + 1] - first[s]
        height = row_starts[s + 1] - start
        _backward_block(x, head, width, height, factor, panels[s], row, start)
    finite = _give_block(x, head, pointer(solution), n_columns, order)
    restore_subnormals(mode)
    return finite
