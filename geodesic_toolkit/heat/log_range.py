"""The logarithm of a positive solution, over a wider range than that of floating point.

The heat of a short diffusion falls by a factor of about e per edge, so float64 underflows some 700
edges from the source. Its logarithm does not.
"""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.linear.base import Factor

__all__ = ["fill_from_neighbours", "log_solve", "smallest_final_value"]

MIN_FINAL_VALUE = 1e-260
"""Scaled values above this threshold are final: the remaining range down to underflow, 1e-48,
resolves every term of their sums."""

ROWS_PER_BLOCK = 4096
"""Rows processed at once: intermediate results stay in cache, and do not need new memory."""


def smallest_final_value(diagonal: FloatArray) -> float:
    """Return the smallest value that is final in a solution of a matrix with this diagonal.

    A solve sums products of values and entries of the factor, which are as large as the square
    roots of the diagonal; if these are small, products underflow first.
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

    Once u falls below a threshold, split the vertices into near ones (above it, with final values)
    and far ones. The part of u on the far side alone, w = (0, u_far), solves the same system with a
    right-hand side that is nonzero only at the interface,

        A w = (A_nf u_f, -A_fn u_n),

    which can be scaled up before it is solved with the same factor: the far values are found in
    scaled arithmetic, the larger ones are final, and so on until all vertices have a value. Every
    stage costs one pair of back-substitutions and reaches some 600 edges further at the default
    time step.

    Parameters
    ----------
    matrix : CompressedRows of shape (N, N)
        A, symmetric positive definite with (mostly) non-positive off-diagonal entries.
    factor : Factor
        Its factor, from a componentwise accurate solver.
    right_hand_side : ndarray of shape (N, K)
        Not negative.
    solution : ndarray of shape (N, K), optional
        Solution of the system by the factor, if it is already known.

    Returns
    -------
    log_solution : ndarray of shape (N, K)
        ``-inf`` at vertices whose solution is zero (not connected to b) or negative (A is not an
        M-matrix).
    stages : int
        Number of solves for the column with the widest range.
    """
    n_vertices, n_columns = right_hand_side.shape
    log_solution = np.full((n_vertices, n_columns), -np.inf)
    final = np.zeros((n_vertices, n_columns), dtype=np.bool_)
    log_scale = np.zeros(n_columns)
    columns = np.arange(n_columns)  # those with values that are not final
    least = smallest_final_value(matrix.diagonal())
    scaled_rhs = right_hand_side
    for stage in range(1, n_vertices + 2):  # each stage makes at least one value final
        scaled = solution if solution is not None and stage == 1 else factor.solve(scaled_rhs)
        is_open = _take_logarithms(
            scaled,
            least,
            log_scale=log_scale,
            columns=columns,
            log_solution=log_solution,
            final=final,
        )
        if not is_open.any():
            return log_solution, stage
        columns, scaled = columns[is_open], scaled[:, is_open]
        rows, loads = _interface(matrix, scaled, final[:, columns])
        largest = np.abs(loads).max(axis=0, initial=0.0)
        connected = largest > 0
        if not connected.any():
            return log_solution, stage
        columns, largest = columns[connected], largest[connected]
        scaled_rhs = np.zeros((n_vertices, len(columns)))
        scaled_rhs[rows] = loads[:, connected] / largest
        log_scale[columns] += np.log(largest)
    return log_solution, n_vertices + 1  # pragma: no cover - every stage makes a value final


def _take_logarithms(
    scaled: FloatArray,
    least: float,
    *,
    log_scale: FloatArray,
    columns: IntArray,
    log_solution: FloatArray,
    final: BoolArray,
) -> BoolArray:
    """Write the logarithms of values above `least` into some `columns` of (N, K).

    Return a mask of the columns that made progress and are not complete.
    """
    progress = np.zeros(len(columns), dtype=np.bool_)
    done = np.ones(len(columns), dtype=np.bool_)
    for start in range(0, len(scaled), ROWS_PER_BLOCK):
        rows = slice(start, start + ROWS_PER_BLOCK)
        part, before, logs = scaled[rows], final[rows, columns], log_solution[rows, columns]
        new = ~before & (np.abs(part) > least)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_solution[rows, columns] = np.where(
                new & (part > 0), np.log(part) + log_scale[columns], logs
            )
        after = before | new
        final[rows, columns] = after
        progress |= new.any(axis=0)
        done &= after.all(axis=0)
    return progress & ~done


def _interface(
    matrix: CompressedRows, solution: FloatArray, near: BoolArray
) -> tuple[IntArray, FloatArray]:
    """Return the rows at which A w is not zero for w = (0, u_far), and its values, per column.

    These rows are on either side of the interface of near and far.
    """
    mixed = np.zeros(len(near), dtype=np.bool_)
    for side in np.ascontiguousarray(np.packbits(near, axis=1).T):  # eight columns at once
        around = side[matrix.indices]
        begins = matrix.indptr[:-1]  # rows are not empty: they hold the diagonal
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
    """Return the row number of each entry in some rows, and the indices of these entries."""
    counts = matrix.indptr[rows + 1] - matrix.indptr[rows]
    row = np.repeat(np.arange(len(rows)), counts)
    begins = np.cumsum(counts) - counts
    return row, np.arange(counts.sum()) + np.repeat(matrix.indptr[rows] - begins, counts)


def fill_from_neighbours(
    matrix: CompressedRows, solution: FloatArray, missing: BoolArray, *, logarithmic: bool
) -> None:
    """Fill the `missing` entries of u, or of log u, in place from neighbours that have a value.

    This enforces the maximum principle: u_i becomes ``Σ |a_ij| u_j / (|Σ_j a_ij| + Σ |a_ij|)`` over
    the neighbours j with a value, ring by ring.

    Parameters
    ----------
    matrix : CompressedRows of shape (N, N)
    solution : ndarray of shape (N,)
        u or, if `logarithmic`, log u.
    missing : ndarray of shape (N,), bool
        Entries to fill; vertices that values do not reach get 0, or ``-inf``.
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
