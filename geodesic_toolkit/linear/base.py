"""The contract of a linear solver: analyse a pattern, factorise a matrix, solve often."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Analysis", "Factor", "LinearSolver"]


class Factor(abc.ABC):
    """A factorised matrix, ready for solves; safe to use from several threads at once."""

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
            A solution was not found, or it is not finite.
        """

    def solve_over(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x as `solve` does, in the memory of the right-hand side if possible.

        Use it for right-hand sides that are not needed afterwards, because allocating large arrays
        is slow. Solvers that cannot reuse memory need not override it.

        Parameters
        ----------
        right_hand_side : ndarray of shape (N,) or (N, K)
            Its values are undefined afterwards.

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
        """Bytes that these entries take."""


class Analysis(abc.ABC):
    """The analysis of a sparsity pattern, shared by all matrices that have it; thread-safe.

    The heat and the Poisson system of one discretization are such matrices.
    """

    @abc.abstractmethod
    def factorize(self, matrix: Any) -> Factor:
        """Return the factor of `matrix`.

        Parameters
        ----------
        matrix : csr_array of shape (N, N), float64
            Symmetric positive definite. A matrix with another pattern is factorised too, but does
            not share the analysis.

        Returns
        -------
        Factor

        Raises
        ------
        SolverError
            The matrix is singular or not positive definite.
        NotEnoughMemoryError
            The factor does not fit in memory.
        """

    def expected_bytes(self, n_factors: int) -> float:  # noqa: ARG002 - not known
        """Return the bytes that this many factors take at once.

        Parameters
        ----------
        n_factors : int

        Returns
        -------
        float
            Bytes of the factors and the analysis itself; 0 if unknown.
        """
        return 0.0


class LinearSolver(abc.ABC):
    """Recipe for solving sparse symmetric positive definite systems; the base class of plugins.

    Subclasses are final frozen dataclasses of keyword-only options, each with a default.

    Attributes
    ----------
    componentwise : bool
        True if each entry of a solution is accurate relative to itself when the matrix is an
        M-matrix and the right-hand side is not negative. Heat falls by a factor of about e per
        edge, so its solver must be componentwise; sparse Cholesky and LU without pivoting are, an
        iteration that stops at the norm of the residual is not.
    allow_heat : bool
        True if it may solve the heat step although it is not componentwise accurate: an option of
        some solvers.
    takes_rows : bool
        True if it also takes matrices as ``CompressedRows`` of ``geodesic_toolkit.core.rows``, and
        so does not need SciPy.
    references : tuple of str
        DOIs of the implemented methods.
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

    def for_heat(self) -> LinearSolver | None:
        """Return the solver of the heat step if only this one is chosen, for both steps.

        The result is None for the default solver, which a solver that is not accurate enough for
        heat leaves it to. A solver may name another one.
        """
        return self if self.componentwise or self.allow_heat else None

    def leads(self) -> bool:
        """Return True if this process runs the program: reads, prints and writes.

        A solver that spans several processes, all started with the same command, helps the one that
        leads from this call until the end, and returns False then. The command line calls it before
        it reads, and exits without a word if it is False.
        """
        return True

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
            The factor does not fit in memory.
        """

    def analyse(self, pattern: Any) -> Analysis:  # noqa: ARG002 - a hook
        """Return the analysis of all matrices with the pattern of a given one.

        The default analysis is empty. Solvers that share work between matrices override this
        method, and their `factorize` is ``return self.analyse(matrix).factorize(matrix)``.

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
            A factor would not fit in memory.
        """
        return _NothingShared(self)

    def analyse_pairs(
        self,
        matrix: Any,
        pattern: CompressedRows,  # noqa: ARG002 - a hook
        known: Analysis | None = None,  # noqa: ARG002
    ) -> Analysis:
        """Return the analysis of real forms of complex Hermitian matrices with one pattern.

        In the real form an entry ``a + i b`` is a block ``[[a, -b], [b, a]]``. The default is the
        analysis of any matrix; solvers that know complex numbers do half the work.

        Parameters
        ----------
        matrix : csr_array of shape (2 N, 2 N), float64
            The real form of one of them; its values are not used.
        pattern : CompressedRows of shape (N, N)
            The pattern of the complex matrices; its values are not used.
        known : Analysis, optional
            One that may be of this pattern.

        Returns
        -------
        Analysis
            It factorises real forms.

        Raises
        ------
        NotEnoughMemoryError
            A factor would not fit in memory.
        """
        return self.analyse(matrix)


class _NothingShared(Analysis):
    """The analysis of solvers that do not share work between matrices."""

    def __init__(self, solver: LinearSolver) -> None:
        self._solver = solver

    def factorize(self, matrix: Any) -> Factor:
        return self._solver.factorize(matrix)
