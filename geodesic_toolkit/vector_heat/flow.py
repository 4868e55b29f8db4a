"""Diffusion of vectors, over a range of magnitudes beyond that of floating point."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.geometry.frames import ComplexArray
from geodesic_toolkit.heat.log_range import smallest_final_value
from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
from geodesic_toolkit.linear.patterns import factorize_pairs

__all__ = ["LogVectors", "VectorFlow"]


@dataclass(frozen=True, eq=False)
class LogVectors:
    """Vectors by their directions, and by lengths of any magnitude.

    Attributes
    ----------
    directions : ndarray of shape (N,), complex128
        Of length 1, and 0 where nothing comes.
    scaled_sizes : ndarray of shape (N,), float64
        Lengths in units of their scales; 0 where nothing comes.
    log_scales : ndarray of shape (N,), float64, or float
        The logarithms of the scales.
    """

    directions: ComplexArray
    scaled_sizes: FloatArray
    log_scales: FloatArray | float = 0.0

    @property
    def log_sizes(self) -> FloatArray:
        """The logarithms of the lengths, (N,); ``-inf`` where nothing comes."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.scaled_sizes) + self.log_scales)


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
        """Return the solution as directions, and lengths however small.

        As in :func:`geodesic_toolkit.heat.log_range.log_solve`: where a vector has sunk below a
        threshold, the solve starts again with the load of those above it on the others, scaled.
        """
        sizes, own, vectors = self._polar_solve(load)
        if sizes.min() > self._least:  # as on most shapes
            return LogVectors(own, sizes)
        count = len(load)
        scaled_sizes, log_scales = np.zeros(count), np.zeros(count)
        directions = np.zeros(count, dtype=np.complex128)
        settled, log_scale = np.zeros(count, dtype=np.bool_), 0.0
        for _ in range(count + 1):  # each stage finishes a vertex at least
            new = ~settled & (sizes > self._least)
            scaled_sizes[new], log_scales[new], directions[new] = sizes[new], log_scale, own[new]
            settled |= new
            if settled.all() or not new.any() or not self._restarts:
                break
            load = self._interface(vectors, settled)
            largest = float(np.abs(load).max())
            if largest == 0:
                break
            load /= largest
            log_scale += float(np.log(largest))
            sizes, own, vectors = self._polar_solve(load)
        return LogVectors(directions, scaled_sizes, log_scales)

    def _polar_solve(self, load: ComplexArray) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Return the lengths and directions of a solution, (N,), and the solution itself."""
        vectors = self.solve(load)
        sizes, directions = _native.polar_form(vectors.view(np.float64).reshape(-1, 2))
        return sizes, directions.view(np.complex128)[:, 0], vectors

    def _interface(self, vectors: ComplexArray, near: BoolArray) -> ComplexArray:
        """Return ``A w`` for w = (0, x_far), which is not zero at the interface only."""
        matrix = self.matrix.scipy
        inside, outside = (
            (matrix @ np.where(mask, vectors, 0).view(np.float64)).view(np.complex128)
            for mask in (near, ~near)
        )
        return np.where(near, outside, -inside)
