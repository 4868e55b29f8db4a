"""Dense Cholesky of a front: its columns are eliminated, and its rows below are left less of them.

    P = [ P₁ ]  ->  [ L₁       ]        L₁ L₁ᵀ = P₁,
        [ P₂ ]      [ P₂ L₁⁻ᵀ  ]        U = -(P₂ L₁⁻ᵀ) (P₂ L₁⁻ᵀ)ᵀ.

Columns come in fours, those in chunks: within a chunk four columns are brought up to date when
their turn comes, and behind it all that follow at once.
"""

import math

from geodesic_toolkit._compiled import part
from geodesic_toolkit._pointers import Pointer, shifted
from geodesic_toolkit.linear.supernodal._tiles import (
    ACROSS,
    LANES,
    TALL,
    divide_four,
    edge_tile,
    whole_tile,
)

__all__ = ["DONE", "eliminate", "packed_size"]

DONE = -1

CHUNK = 128
"""Columns whose products are summed up at once: what a tile reads of them stays in cache."""

SLAB = 128
"""Rows that stay in the second level of cache while all columns go over them."""

PACKED = 320
"""Rows from which on they are copied before use, so that one column is not pages from the next."""


def packed_size(tallest: int) -> int:
    """Return how many numbers of room `eliminate` needs for fronts of up to so many rows."""
    return CHUNK * (tallest + TALL) if tallest > PACKED else 0


@part(inline=True)
def _pack(room: Pointer, source: Pointer, height: int, n_rows: int, depth: int) -> None:
    """Copy columns, `height` apart, so that what a tile reads is in one piece: rows by TALL."""
    for top in range(0, n_rows, TALL):
        count = min(TALL, n_rows - top)
        for c in range(depth):
            for k in range(count):
                room[top * depth + c * TALL + k] = source[c * height + top + k]


@part(fused=True)
def _subtract_products(  # noqa: PLR0917 - kernels take no keywords
    target: Pointer,
    stride: int,
    n_rows: int,
    n_columns: int,
    source: Pointer,
    height: int,
    depth: int,
    fresh: bool,
    room: Pointer,
) -> None:
    """Subtract ``B Bᵀ`` from the lower triangle of the first columns of C, of zero where `fresh`.

    B has `depth` columns, `height` apart, C has `n_columns`, `stride` apart; both have `n_rows`.
    What lies above the diagonal of C is spoilt.
    """
    step, scale, beyond = height, 1, ACROSS - 1
    if n_rows > PACKED and n_columns > ACROSS:
        _pack(room, source, height, n_rows, depth)
        source, step, scale, beyond = room, TALL, depth, TALL - 1
    for top in range(0, n_rows, SLAB):
        bottom = min(top + SLAB, n_rows)
        for j in range(0, min(n_columns, bottom), ACROSS):
            width = min(n_columns - j, ACROSS)
            begin = j & ~beyond  # of the piece that column j of Bᵀ is in; powers of two
            column = begin * scale + (j & beyond)
            i = max(top, begin)
            while i + TALL <= bottom:
                at = j * stride + i
                whole_tile(
                    target, at, stride, source, i * scale, column, step, depth, width, 0, fresh
                )
                i += TALL
            row = i * scale
            while i < bottom:
                at = j * stride + i
                edge_tile(
                    target, at, stride, source, row, column, step, depth, width, bottom - i, fresh
                )
                i += LANES
                row += LANES


@part(inline=True)
def _eliminate_four(panel: Pointer, height: int, c: int, count: int) -> int:
    """Eliminate up to four columns from c on; return the first one with a pivot <= 0, or -1."""
    for j in range(c, c + count):
        for i in range(j, c + count):
            value = panel[j * height + i]
            for k in range(c, j):
                value -= panel[k * height + i] * panel[k * height + j]
            if i > j:
                value *= panel[j * height + j]
            elif value > 0:
                value = 1 / math.sqrt(value)
            else:  # nor is NaN
                return j
            panel[j * height + i] = value
    p = c * height
    q = p + height if count > 1 else p
    r = q + height if count > 2 else p
    s = r + height if count > 3 else p
    triangle = (
        panel[p + c],
        panel[p + c + 1], panel[q + c + 1],
        panel[p + c + 2], panel[q + c + 2], panel[r + c + 2],
        panel[p + c + 3], panel[q + c + 3], panel[r + c + 3], panel[s + c + 3],
    )  # fmt: skip
    below = c + count
    divide_four(panel, below, height - below, p, q, r, s, triangle)
    return DONE


@part(inline=True)
def eliminate(panel: Pointer, update: Pointer, height: int, width: int, room: Pointer) -> int:
    """Eliminate the columns of a front in place; return the first one with a pivot <= 0, or -1.

    Parameters
    ----------
    panel : pointer
        The front's `width` columns of `height` rows. They become those of L, but for the diagonal,
        which becomes the inverse of L's.
    update : pointer
        Receives the lower triangle of U, square and of ``height - width`` rows.
    room : pointer
        `packed_size` numbers.
    """
    for begin in range(0, width, CHUNK):
        end = min(begin + CHUNK, width)
        for c in range(begin, end + 1, ACROSS):
            count = min(end - c, ACROSS) if c < end else width - end
            row, own = shifted(panel, begin * height + c), shifted(panel, c * height + c)
            depth, below = c - begin, height - c
            if depth > 0:
                _subtract_products(own, height, below, count, row, height, depth, False, room)
            if c == end:
                break
            failed = _eliminate_four(panel, height, c, count)
            if failed != DONE:
                return failed
    below = height - width
    for begin in range(0, width, CHUNK):
        depth = min(CHUNK, width - begin)
        row = shifted(panel, begin * height + width)
        _subtract_products(update, below, below, below, row, height, depth, begin == 0, room)
    return DONE
