"""The contract of a linear solver: analyse a pattern, factorise a matrix, solve often."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from geodesic_toolkit.core.types import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Analysis", "Factor", "LinearSolver"]


class Factor(abc.ABC):
    """A matrix made ready for solving; safe to use from several threads at once."""

    @abc.abstractmethod
    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``.

        Parameters
        ----------
        right_hand_side : ndarray of shape (N,) or (N, K)
            One column, or a block of them.

        Returns
        -------
        ndarray of the same shape
            A fresh array.

        Raises
        ------
        SolverError
            No solution was found, or it is not finite.
        """

    def solve_over(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x as `solve` does, in the memory of the right-hand side where that can be.

        For right-hand sides that are not needed afterwards, because allocating large arrays is slow. A
        solver that has nothing to gain need not override it.

        Parameters
        ----------
        right_hand_side : ndarray of shape (N,) or (N, K)
            Holds anything afterwards.

        Returns
        -------
        ndarray of the same shape
        """
        return self.solve(right_hand_side)

    @property
    @abc.abstractmethod
    def nnz(self) -> int:
        """Entries stored for the factor."""

    @property
    @abc.abstractmethod
    def nbytes(self) -> int:
        """Bytes that they take."""


class Analysis(abc.ABC):
    """What a solver knows of all matrices of one pattern; safe to use from several threads at once.

    The heat and the Poisson system of one discretization are such matrices.
    """

    @abc.abstractmethod
    def factorize(self, matrix: Any) -> Factor:
        """Return `matrix` made ready for solving.

        Parameters
        ----------
        matrix : csr_array of shape (N, N), float64
            Symmetric positive definite. One of another pattern is factorised all the same, without
            the work that would have been shared.

        Returns
        -------
        Factor

        Raises
        ------
        SolverError
            The matrix is singular or not positive definite.
        NotEnoughMemoryError
            The factor does not fit.
        """

    def expected_bytes(self, n_factors: int) -> float:  # noqa: ARG002 - not known
        """Return the bytes that making so many factors at once takes.

        Parameters
        ----------
        n_factors : int

        Returns
        -------
        float
            The analysis itself included; 0 where not known.
        """
        return 0.0


class LinearSolver(abc.ABC):
    """Recipe for solving sparse symmetric positive definite systems; the base class of plugins.

    Subclasses are final frozen dataclasses of keyword-only options, each with a default.

    Attributes
    ----------
    componentwise : bool
        Whether each entry of a solution is accurate relative to itself when the matrix is an
        M-matrix and the right-hand side is not negative. Heat falls by a factor of about e per
        edge, so its solver must be; sparse Cholesky and LU without pivoting are, an iteration
        that stops on the norm of the residual is not.
    allow_heat : bool
        Whether it may solve the heat step although it is not componentwise accurate: an option,
        where a solver has it.
    takes_rows : bool
        Whether it also takes matrices as ``CompressedRows`` of ``geodesic_toolkit.core.rows``, and
        so does without SciPy.
    references : tuple of str
        DOIs of what it implements.
    known_failures : mapping of str to str
        Laws of the conformance kit that it breaks by design, each with the reason.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> import geodesic_toolkit as gt
    >>> factor = gt.solvers["superlu"]().factorize(csr_array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> factor.solve(np.array([1.0, 1.0]))
    array([1., 1.])
    """

    componentwise: ClassVar[bool]
    takes_rows: ClassVar[bool] = False
    allow_heat = False
    references: ClassVar[tuple[str, ...]] = ()
    known_failures: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @abc.abstractmethod
    def factorize(self, matrix: csr_array) -> Factor:
        """Return `matrix` made ready for solving.

        Parameters
        ----------
        matrix : csr_array of shape (N, N), float64
            Symmetric positive definite.

        Returns
        -------
        Factor

        Raises
        ------
        SolverError
            The matrix is singular or not positive definite.
        NotEnoughMemoryError
            The factor does not fit.
        """

    def analyse(self, pattern: Any) -> Analysis:  # noqa: ARG002 - a hook
        """Return what this solver knows of all matrices with the pattern of one.

        Nothing, unless a solver overrides it that can share work between them; such a one has
        ``return self.analyse(matrix).factorize(matrix)`` for its `factorize`.

        Parameters
        ----------
        pattern : csr_array of shape (N, N), float64
            Its values are not used.

        Returns
        -------
        Analysis

        Raises
        ------
        NotEnoughMemoryError
            A factor will not fit.
        """
        return _NothingShared(self)


class _NothingShared(Analysis):
    """The analysis of solvers that begin with each matrix anew."""

    def __init__(self, solver: LinearSolver) -> None:
        self._solver = solver

    def factorize(self, matrix: Any) -> Factor:
        return self._solver.factorize(matrix)
