"""Diffusion of vectors, over a range of magnitudes beyond that of floating point."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.geometry.frames import ComplexArray
from geodesic_toolkit.heat.log_range import smallest_final_value
from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
from geodesic_toolkit.linear.patterns import factorize_pairs

__all__ = ["LogVectors", "VectorFlow"]


class LogVectors(NamedTuple):
    """Vectors by the logarithms of their lengths, and by their directions.

    Attributes
    ----------
    log_sizes : ndarray of shape (N,), float64
        ``-inf`` where nothing comes.
    directions : ndarray of shape (N,), complex128
        Of length 1, and 0 where nothing comes.
    """

    log_sizes: FloatArray
    directions: ComplexArray


class VectorFlow:
    """``(M + t L_c) x = b`` with the connection Laplacian L_c, factorised once.

    Parameters
    ----------
    matrix : CompressedRows of shape (2 N, 2 N)
        M + t L_c in its real form.
    pattern : CompressedRows of shape (N, N)
        That of L_c.
    solver : LinearSolver
    known : Analysis, optional
        One that may be of the pattern, so that nothing is analysed.
    """

    def __init__(
        self,
        matrix: CompressedRows,
        pattern: CompressedRows,
        solver: LinearSolver,
        known: Analysis | None = None,
    ) -> None:
        self.matrix = matrix
        self._factor: Factor = factorize_pairs(solver, matrix, pattern, known)
        self._restarts = solver.componentwise

    @property
    def nbytes(self) -> int:
        """Bytes of the factor."""
        return self._factor.nbytes

    def solve(self, load: ComplexArray) -> ComplexArray:
        """Return x with ``(M + t L_c) x = b``, complex (N,)."""
        pairs = np.ascontiguousarray(load).view(np.float64)
        return np.ascontiguousarray(self._factor.solve(pairs)).view(np.complex128)

    @cached_property
    def _least(self) -> float:
        return smallest_final_value(self.matrix.diagonal())

    def log_solve(self, load: ComplexArray) -> LogVectors:
        """Return the solution as logarithms of lengths, however small, and directions.

        As in :func:`geodesic_toolkit.heat.log_range.log_solve`: where a vector has sunk below a
        threshold, the solve starts again with the load of those above it on the others, scaled.
        """
        vectors = self.solve(load)
        sizes = np.abs(vectors)
        if sizes.min() > self._least:  # as on most shapes
            return LogVectors(np.log(sizes), vectors / sizes)
        count = len(load)
        log_sizes, directions = np.full(count, -np.inf), np.zeros(count, dtype=np.complex128)
        settled, log_scale = np.zeros(count, dtype=np.bool_), 0.0
        for _ in range(count + 1):  # each stage finishes a vertex at least
            new = ~settled & (sizes > self._least)
            log_sizes[new] = np.log(sizes[new]) + log_scale
            directions[new] = vectors[new] / sizes[new]
            settled |= new
            if settled.all() or not new.any() or not self._restarts:
                break
            load = self._interface(vectors, settled)
            largest = float(np.abs(load).max())
            if largest == 0:
                break
            load /= largest
            log_scale += float(np.log(largest))
            vectors = self.solve(load)
            sizes = np.abs(vectors)
        return LogVectors(log_sizes, directions)

    def _interface(self, vectors: ComplexArray, near: BoolArray) -> ComplexArray:
        """Return ``A w`` for w = (0, x_far), which is not zero at the interface only."""
        matrix = self.matrix.scipy
        inside, outside = (
            (matrix @ np.where(mask, vectors, 0).view(np.float64)).view(np.complex128)
            for mask in (near, ~near)
        )
        return np.where(near, outside, -inside)
