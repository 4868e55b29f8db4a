"""The numeric half of a factorisation."""

import math

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.errors import InvalidOptionError, NotEnoughMemoryError, SolverError
from geodesic_toolkit.linear.base import Factor
from geodesic_toolkit.linear.memory import require_memory
from geodesic_toolkit.linear.supernodal.analysis import LANES, Analysis, Panels

__all__ = ["SupernodalFactor", "factorize"]

FEW = 2
"""Columns up to which one by one is quicker than a block, which is always computed in full."""

SINGULAR = 7e-15
"""Share of a diagonal entry, times √N, below which what elimination leaves of it is rounding.

Rounding errors add up as the steps of a random walk do. Of Laplacians of grids, meshes, paths and
neighbour graphs of 3,000 to 100,000 vertices, which should leave nothing, a fifth of this was left
at the most; with one vertex held 1e-5 and more.
"""


class SupernodalFactor(Factor):
    """The panels of a Cholesky factor; solving changes nothing in it."""

    def __init__(self, analysis: Analysis, panels: Panels) -> None:
        self.analysis = analysis
        self._panels = panels

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, for one column or a block of them.

        Zeros in b save work: see :mod:`~geodesic_toolkit.linear.supernodal._solve`.
        """
        return self._solved(right_hand_side, over=False)

    def solve_over(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x in the memory of b, if that is an array of numbers in their usual order."""
        return self._solved(right_hand_side, over=True)

    def _solved(self, right_hand_side: FloatArray, *, over: bool) -> FloatArray:
        given = np.asarray(right_hand_side)
        n = self.analysis.n_vertices
        if given.ndim not in {1, 2} or len(given) != n:
            raise InvalidOptionError(
                f"{n} unknowns need a right-hand side of shape ({n},) or ({n}, K), "
                f"not {given.shape}"
            )
        b = np.ascontiguousarray(given, dtype=np.float64)
        own = b is not given and not np.may_share_memory(b, given)
        solution = b if own or (over and b.flags.writeable) else np.empty_like(b)
        if not self._solve(b, solution):
            raise SolverError(
                "the solution is not finite: the right-hand side is not, or they are too large"
            )
        return solution

    def _solve(self, b: FloatArray, solution: FloatArray) -> bool:
        """Write x to `solution`, which may be b itself, and return whether it is finite."""
        from geodesic_toolkit.linear.supernodal import _solve

        its = self.analysis
        known = (its.order, its.first, its.row_starts, its.rows, its.panels, self._panels)
        count = 1 if b.ndim == 1 else b.shape[1]
        if count <= FEW:
            with its.room(its.n_vertices + 1 + its.tallest + LANES) as room:
                if count == 1:
                    return _solve.solve_column(b.reshape(-1), *known, room, solution.reshape(-1))
                finite = True
                for k in range(count):
                    column = b[:, k].copy()
                    finite &= _solve.solve_column(column, *known, room, column)
                    solution[:, k] = column
            return finite
        with its.room(_solve.BLOCK * (its.n_vertices + 4)) as room:
            if count <= _solve.BLOCK:
                return _solve.solve_block(b, *known, room, solution)
            finite = True
            for start in range(0, count, _solve.BLOCK):
                block = b[:, start : start + _solve.BLOCK].copy()
                finite &= _solve.solve_block(block, *known, room, block)
                solution[:, start : start + _solve.BLOCK] = block
        return finite

    @property
    def nnz(self) -> int:
        """Numbers stored for the factor, the zeros of its dense panels included."""
        return self.analysis.n_stored

    @property
    def nbytes(self) -> int:
        """Bytes that they take."""
        return int(self._panels.nbytes)

    def __repr__(self) -> str:
        return f"SupernodalFactor({self.analysis.n_vertices} unknowns, {self.nnz} entries)"


def factorize(matrix: csr_array, analysis: Analysis, *, halves: bool = False) -> SupernodalFactor:
    """Return the Cholesky factor of `matrix`, whose pattern has been analysed.

    Parameters
    ----------
    matrix : csr_array of shape (N, N)
    analysis : Analysis
    halves : bool
        Keep the upper half of each number only.

    Raises
    ------
    SolverError
        It is not positive definite to working precision, or not finite; the message names the
        vertex.
    NotEnoughMemoryError
        The factor and the update matrices on their stack would not fit.
    """
    from geodesic_toolkit.linear.supernodal import _front, _numeric

    n = analysis.n_vertices
    work = f"the Cholesky factor of {n} unknowns, with {analysis.n_stored} entries,"
    needed = analysis.factor_bytes(halves=halves)
    require_memory(needed, work)
    try:
        panels = np.empty(0 if halves else analysis.n_stored + LANES)
        upper_halves = np.empty(analysis.n_stored + LANES if halves else 0, dtype=np.uint32)
        front = np.empty(analysis.largest + LANES if halves else 0)
        stack = np.empty(analysis.stack)
    except MemoryError as error:  # a limit of this process, or a system that does not say
        raise NotEnoughMemoryError(
            f"{work} needs about {needed / 1e9:.3g} GB of memory, which could not be had"
        ) from error
    pivots = np.zeros(n)
    panels[analysis.n_stored :] = upper_halves[analysis.n_stored :] = 0
    failed = _numeric.factorize(
        np.ascontiguousarray(matrix.data, dtype=np.float64),
        analysis.starts,
        analysis.lower_rows,
        analysis.places,
        analysis.first,
        analysis.row_starts,
        analysis.rows,
        analysis.above,
        analysis.panels,
        panels,
        upper_halves,
        front,
        stack,
        np.empty(_front.packed_size(analysis.tallest)),
        pivots,
        np.empty(2 * n + 3 * len(analysis.above), dtype=np.int64),
    )
    if failed >= 0 or not pivots.min(initial=1.0) > SINGULAR * math.sqrt(n):  # nor is NaN
        column = int(failed if failed >= 0 else pivots.argmin())
        raise SolverError(
            f"the matrix of {n} unknowns is not positive definite to working precision: "
            f"elimination stops at vertex {analysis.order[column]}, pivot {column + 1} of {n}"
        )
    return SupernodalFactor(analysis, upper_halves if halves else panels)
