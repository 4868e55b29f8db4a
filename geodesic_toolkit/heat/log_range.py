"""The logarithm of a positive solution, over a range that floating point does not have.

The heat of a short diffusion falls by a factor of about e per edge, so float64 ends some 700 edges
from the source. Its logarithm need not.
"""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.linear.base import Factor

__all__ = ["fill_from_neighbours", "log_solve", "settled_above"]

MIN_FINAL_VALUE = 1e-260
"""Smallest scaled value taken as it is; the 1e-48 below it still resolve what it is a sum of."""

ROWS_PER_BLOCK = 4096
"""Rows worked on at once: what comes in between stays in cache, and takes no fresh memory."""


def settled_above(diagonal: FloatArray) -> float:
    """Return the smallest value that is taken as it is, of the solution with such a diagonal.

    What a solve adds up are values times entries of the factor, as large as the roots of the
    diagonal; where these are small, products are the first to underflow.
    """
    return MIN_FINAL_VALUE / float(np.sqrt(diagonal.min(initial=1.0)))


def log_solve(
    matrix: CompressedRows,
    factor: Factor,
    right_hand_side: FloatArray,
    *,
    solution: FloatArray | None = None,
) -> tuple[FloatArray, int]:
    """Return ``log u`` for ``A u = b``, b >= 0, however small u becomes.

    Once u sinks below a threshold, split the vertices into the near ones (above it, settled) and
    the far ones. The part of u on the far side alone, w = (0, u_far), solves the same system with
    a right-hand side that lives on the interface of the two,

        A w = (A_nf u_f, -A_fn u_n),

    which can be scaled up before solving it with the same factor: the far values come out in
    scaled arithmetic, settle in their turn, and so on until nothing is left. Every stage costs one
    pair of back-substitutions and reaches some 600 edges further at the default time step.

    Parameters
    ----------
    matrix : CompressedRows of shape (N, N)
        A, symmetric positive definite with (mostly) non-positive off-diagonal entries.
    factor : Factor
        Its factor, from a componentwise accurate solver.
    right_hand_side : ndarray of shape (N, K)
        Not negative.
    solution : ndarray of shape (N, K), optional
        What the factor makes of it, where that is at hand.

    Returns
    -------
    log_solution : ndarray of shape (N, K)
        ``-inf`` where the solution is zero (not connected to b) or negative (A is not an M-matrix).
    stages : int
        How many solves the furthest column took.
    """
    n_vertices, n_columns = right_hand_side.shape
    log_solution = np.full((n_vertices, n_columns), -np.inf)
    settled = np.zeros((n_vertices, n_columns), dtype=np.bool_)
    log_scale = np.zeros(n_columns)
    columns = np.arange(n_columns)  # those that still have vertices to settle
    least = settled_above(matrix.diagonal())
    scaled_rhs = right_hand_side
    for stage in range(1, n_vertices + 2):  # each stage settles a vertex at least
        scaled = solution if solution is not None and stage == 1 else factor.solve(scaled_rhs)
        is_open = _settle(
            scaled,
            least,
            log_scale=log_scale,
            columns=columns,
            log_solution=log_solution,
            settled=settled,
        )
        if not is_open.any():
            return log_solution, stage
        columns, scaled = columns[is_open], scaled[:, is_open]
        rows, loads = _interface(matrix, scaled, settled[:, columns])
        largest = np.abs(loads).max(axis=0, initial=0.0)
        connected = largest > 0
        if not connected.any():
            return log_solution, stage
        columns, largest = columns[connected], largest[connected]
        scaled_rhs = np.zeros((n_vertices, len(columns)))
        scaled_rhs[rows] = loads[:, connected] / largest
        log_scale[columns] += np.log(largest)
    return log_solution, n_vertices + 1  # pragma: no cover - every stage settles a vertex


def _settle(
    scaled: FloatArray,
    least: float,
    *,
    log_scale: FloatArray,
    columns: IntArray,
    log_solution: FloatArray,
    settled: BoolArray,
) -> BoolArray:
    """Take the logarithms of what has not sunk to `least`, into some `columns` of (N, K).

    Returns which of these columns made progress and are not done yet.
    """
    progress = np.zeros(len(columns), dtype=np.bool_)
    done = np.ones(len(columns), dtype=np.bool_)
    for start in range(0, len(scaled), ROWS_PER_BLOCK):
        rows = slice(start, start + ROWS_PER_BLOCK)
        part, before, logs = scaled[rows], settled[rows, columns], log_solution[rows, columns]
        new = ~before & (np.abs(part) > least)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_solution[rows, columns] = np.where(
                new & (part > 0), np.log(part) + log_scale[columns], logs
            )
        after = before | new
        settled[rows, columns] = after
        progress |= new.any(axis=0)
        done &= after.all(axis=0)
    return progress & ~done


def _interface(
    matrix: CompressedRows, solution: FloatArray, near: BoolArray
) -> tuple[IntArray, FloatArray]:
    """Return the rows where A w is not zero for w = (0, u_far), and what it is there, per column.

    These are the rows on either side of the interface of near and far.
    """
    mixed = np.zeros(len(near), dtype=np.bool_)
    for side in np.ascontiguousarray(np.packbits(near, axis=1).T):  # eight columns at once
        around = side[matrix.indices]
        begins = matrix.indptr[:-1]  # no row is empty: its diagonal is there
        mixed |= np.bitwise_or.reduceat(around, begins) != np.bitwise_and.reduceat(around, begins)
    rows = np.flatnonzero(mixed)
    i, entries = _entries_of(matrix, rows)
    j, a = matrix.indices[entries], matrix.data[entries]
    inside = near[rows[i]]
    terms = np.where(inside != near[j], a[:, None] * solution[j], 0.0)
    terms[~inside] *= -1
    starts = np.searchsorted(i, np.arange(len(rows)))
    return rows, np.add.reduceat(terms, starts, axis=0) if len(rows) else terms


def _entries_of(matrix: CompressedRows, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return the places of all entries in some rows, and which of the rows each is in."""
    counts = matrix.indptr[rows + 1] - matrix.indptr[rows]
    row = np.repeat(np.arange(len(rows)), counts)
    begins = np.cumsum(counts) - counts
    return row, np.arange(counts.sum()) + np.repeat(matrix.indptr[rows] - begins, counts)


def fill_from_neighbours(
    matrix: CompressedRows, solution: FloatArray, missing: BoolArray, *, logarithmic: bool
) -> None:
    """Fill the `missing` entries of u, or of log u, in place from neighbours that have a value.

    The maximum principle made true: u_i becomes ``Σ |a_ij| u_j / (|Σ_j a_ij| + Σ |a_ij|)`` over the
    neighbours j with a value, ring by ring.

    Parameters
    ----------
    matrix : CompressedRows of shape (N, N)
    solution : ndarray of shape (N,)
        u or, if `logarithmic`, log u.
    missing : ndarray of shape (N,), bool
        Where to fill; vertices that no value reaches get 0, or ``-inf``.
    logarithmic : bool
    """
    nothing = -np.inf if logarithmic else 0.0
    solution[missing] = nothing
    rows = np.flatnonzero(missing)
    if not logarithmic:
        _native.fill(*matrix.arrays, solution, rows.astype(np.int32))
        return
    row, entries = _entries_of(matrix, rows)
    neighbour, value = matrix.indices[entries], matrix.data[entries]
    mass = np.abs(np.bincount(row, value, minlength=len(rows)))
    at_neighbours = (rows[row] != neighbour) & (value != 0)
    row, neighbour = row[at_neighbours], neighbour[at_neighbours]
    weight = np.abs(value[at_neighbours])
    total = mass + np.bincount(row, weight, minlength=len(rows))
    while len(row):
        known = solution[neighbour] > nothing
        reached = np.zeros(len(rows), dtype=np.bool_)
        reached[row[known]] = True
        if not reached.any():
            return
        near, around = row[known], solution[neighbour[known]]
        largest = np.zeros(len(rows))
        if logarithmic:
            largest[:] = -np.inf
            np.maximum.at(largest, near, around)
            around = np.exp(around - largest[near])
        sums = np.bincount(near, weight[known] * around, minlength=len(rows))
        mean = sums[reached] / total[reached]
        solution[rows[reached]] = np.log(mean) + largest[reached] if logarithmic else mean
        if reached.all():
            return
        waiting = ~reached[row]
        row, neighbour, weight = row[waiting], neighbour[waiting], weight[waiting]
