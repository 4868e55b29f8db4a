"""Supernodal sparse Cholesky as a linear solver, over the kernels of ``native/linear``.

Steps from a matrix to a solution: a permutation that keeps the factor sparse (approximate minimum
degree) and the structure of the factor (supernodes), both for all matrices of one pattern; then the
factor (multifrontal, dense Cholesky on each supernode), and forward and back substitution, for one
column or a block.

References
----------
T. A. Davis, S. Rajamanickam, W. M. Sid-Lakhdar, *A survey of direct methods for sparse linear
systems*, Acta Numerica 25, 2016, https://doi.org/10.1017/S0962492916000076
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NoReturn, final

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.frozen import unchanging
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError, NotEnoughMemoryError, SolverError
from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
from geodesic_toolkit.linear.memory import factor_bytes, require_memory

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Supernodal", "SupernodalAnalysis", "SupernodalFactor"]

SHARE_OF_L_IN_LU = 1 / 3
"""Share of the bytes of L and U that L takes, with one row index per row of a supernode.

The analysis gives the exact number; this estimate rejects hopeless requests before it.
"""

MAX_ERROR_OF_COMPACT_FACTOR = 1e-4
"""Maximum error of a compact factor that is used. Measured on meshes and grids of up to 560,000
vertices: 1e-6 to 7e-6."""


@final
@dataclass(frozen=True, kw_only=True)
class Supernodal(LinearSolver):
    """Supernodal sparse Cholesky: minimum-degree ordering, multifrontal, dense kernels of its own.

    The pattern is analysed once for all matrices that share it, and all steps release Python's
    lock. On an M-matrix every step adds numbers of equal sign: each entry of the solution is
    accurate relative to itself.

    Parameters
    ----------
    compact : bool
        Keep the upper half of each number of a factor: its sign, its whole range and six digits.
        It takes half the memory, and solves limited by memory bandwidth are up to twice as fast; a
        solution is off by about 1e-6 of its largest value, and each value of heat by about 1e-6 of
        itself. A factor is tested before it is used, and kept in full if it is less accurate.

    Raises
    ------
    InvalidOptionError
        `compact` is neither True nor False.

    References
    ----------
    P. R. Amestoy, T. A. Davis, I. S. Duff, *An Approximate Minimum Degree Ordering Algorithm*,
    SIAM J. Matrix Anal. Appl. 17, 1996, https://doi.org/10.1137/S0895479894278952

    J. W. H. Liu, *The Multifrontal Method for Sparse Matrix Solution: Theory and Practice*, SIAM
    Review 34, 1992, https://doi.org/10.1137/1034004

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> import geodesic_toolkit as gt
    >>> factor = gt.Supernodal().factorize(csr_array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> factor.solve(np.array([3.0, 0.0]))
    array([2., 1.])
    """

    compact: bool = False

    componentwise: ClassVar[bool] = True
    takes_rows: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("10.1137/S0895479894278952", "10.1137/1034004")

    def __post_init__(self) -> None:
        if not isinstance(self.compact, bool | np.bool_):
            raise InvalidOptionError(f"compact must be True or False, not {self.compact!r}")

    def analyse(self, pattern: csr_array | CompressedRows) -> SupernodalAnalysis:
        """Return the ordering and the supernodes of all matrices with the pattern of one."""
        require_memory(
            SHARE_OF_L_IN_LU * factor_bytes(pattern.shape[0], pattern.nnz),
            f"factorising {pattern.shape[0]} unknowns with {pattern.nnz} entries",
        )
        return SupernodalAnalysis(_rows_of(pattern), compact=bool(self.compact))

    def analyse_pairs(
        self,
        matrix: csr_array | CompressedRows,
        pattern: CompressedRows,
        known: Analysis | None = None,
    ) -> SupernodalAnalysis:
        """Return the analysis of real forms of complex Hermitian matrices with one pattern.

        The factor of a real form is the real form of a complex factor. It is stored as complex
        numbers: with all digits, in as much memory as a compact factor takes.
        """
        if not (isinstance(known, SupernodalAnalysis) and known.fits(pattern)):
            known = SupernodalAnalysis(pattern)
        return known.in_pairs(_rows_of(matrix))

    def factorize(self, matrix: csr_array | CompressedRows) -> SupernodalFactor:
        """Return the Cholesky factor of a symmetric positive definite `matrix`."""
        return self.analyse(matrix).factorize(matrix)


class SupernodalAnalysis(Analysis):
    """The ordering and the supernodes of all matrices of one pattern.

    Parameters
    ----------
    pattern : CompressedRows of shape (N, N)
        Its values are not used.
    compact : bool
        Keep only the upper half of each number, if that is accurate enough.
    analysis : _native.Analysis, optional
        The result, if it is known.

    Raises
    ------
    SolverError
        The pattern has entries without a mirror image.
    """

    def __init__(
        self,
        pattern: CompressedRows,
        *,
        compact: bool = False,
        analysis: _native.Analysis | None = None,
    ) -> None:
        self.compact = compact
        self._pattern = unchanging(pattern.indptr), unchanging(pattern.indices)
        self._analysis = _analysis_of(pattern) if analysis is None else analysis

    def in_pairs(self, matrix: CompressedRows) -> SupernodalAnalysis:
        """Return the analysis of real forms, (2 N, 2 N), of complex matrices of the pattern."""
        return SupernodalAnalysis(matrix, analysis=self._analysis.in_pairs(self._pattern[0]))

    def expected_bytes(self, n_factors: int) -> float:
        """Return the exact bytes of this many factors with their stacks of update matrices."""
        one = self._analysis.factor_bytes(self.compact) + 24.0 * len(self._analysis.order)
        return self._analysis.nbytes + n_factors * one

    def factorize(self, matrix: csr_array | CompressedRows) -> SupernodalFactor:
        """Return the Cholesky factor of `matrix`; a different pattern is analysed first."""
        rows = _rows_of(matrix)
        analysis = self._analysis if self.fits(rows) else _analysis_of(rows)
        _require_finite(rows)
        if self.compact:
            factor = _cholesky(rows, analysis, compact=True)
            if _is_accurate(factor, rows):
                return factor
        return _cholesky(rows, analysis, compact=False)

    def fits(self, matrix: CompressedRows) -> bool:
        """Return True if a matrix has the pattern that was analysed."""
        return all(
            own is other or np.array_equal(own, other)
            for own, other in zip(self._pattern, matrix.arrays[:2], strict=True)
        )


class SupernodalFactor(Factor):
    """A Cholesky factor in dense panels; solves do not change it.

    Parameters
    ----------
    analysis : _native.Analysis
    factor : _native.Factor
    """

    def __init__(self, analysis: _native.Analysis, factor: _native.Factor) -> None:
        self._analysis, self._factor = analysis, factor

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, for one column or a block of them.

        Zeros in b save work: the forward substitution skips subtrees in which b is zero.
        """
        return self._solved(right_hand_side, over=False)

    def solve_over(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x in the memory of b, if it is a C-contiguous array of float64."""
        return self._solved(right_hand_side, over=True)

    def _solved(self, right_hand_side: FloatArray, *, over: bool) -> FloatArray:
        given = np.asarray(right_hand_side)
        n = len(self._analysis.order)
        if given.ndim not in {1, 2} or len(given) != n:
            raise InvalidOptionError(
                f"{n} unknowns need a right-hand side of shape ({n},) or ({n}, K), "
                f"not {given.shape}"
            )
        b = np.ascontiguousarray(given, dtype=np.float64)
        own = b is not given and not np.may_share_memory(b, given)
        solution = b if own or (over and b.flags.writeable) else np.empty_like(b)
        self._factor.solve(b, solution)
        return solution

    @property
    def nnz(self) -> int:
        """Numbers stored for the factor, including zeros of its dense panels."""
        return self._analysis.n_stored

    @property
    def nbytes(self) -> int:
        """Bytes that these numbers take."""
        return self._factor.nbytes

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a factor cannot be pickled; pickle its matrix, and factorise it again when loaded"
        )

    def __repr__(self) -> str:
        return f"SupernodalFactor({len(self._analysis.order)} unknowns, {self.nnz} entries)"


def _analysis_of(matrix: CompressedRows) -> _native.Analysis:
    """Return the analysis of the pattern of a symmetric matrix."""
    if not _native.is_symmetric(matrix.indptr, matrix.indices):
        row, column = _without_mirror_image(matrix)
        raise SolverError(
            f"the matrix is not symmetric: it has an entry ({row}, {column}), but not "
            f"({column}, {row})"
        )
    return _native.analyze(matrix.indptr, matrix.indices)


def _cholesky(
    matrix: CompressedRows, analysis: _native.Analysis, *, compact: bool
) -> SupernodalFactor:
    """Return the Cholesky factor of a matrix whose pattern has been analysed."""
    work = f"the Cholesky factor of {matrix.shape[0]} unknowns, with {analysis.n_stored} entries,"
    needed = float(analysis.factor_bytes(compact))
    require_memory(needed, work)
    try:
        factor = _native.Factor(analysis, matrix.data, compact)
    except MemoryError as error:  # a limit of this process, or unknown memory
        raise NotEnoughMemoryError(
            f"{work} needs about {needed / 1e9:.3g} GB of memory, which could not be allocated"
        ) from error
    return SupernodalFactor(analysis, factor)


def _is_accurate(factor: SupernodalFactor, matrix: CompressedRows) -> bool:
    """Return True if a factor reproduces the constant vector.

    The constant vector is nearly in the null space of a Laplacian, so errors of the factor have
    the largest effect on it.
    """
    row_sums = _native.row_sums(*matrix.arrays)
    try:
        error = np.abs(factor.solve_over(row_sums) - 1).max(initial=0.0)
    except SolverError:  # the sums overflow; the full factor reports that
        return False
    return bool(error <= MAX_ERROR_OF_COMPACT_FACTOR)


def _require_finite(matrix: CompressedRows) -> None:
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(matrix.data.sum()):  # the sum of finite values may overflow, too
            return
    finite = np.isfinite(matrix.data)
    if not finite.all():
        entry = int(np.argmin(finite))
        row = int(np.searchsorted(matrix.indptr, entry, side="right")) - 1
        raise SolverError(
            f"the matrix is not finite: entry ({row}, {matrix.indices[entry]}) is "
            f"{matrix.data[entry]}"
        )


def _without_mirror_image(matrix: CompressedRows) -> tuple[int, int]:
    """Return the first entry of a matrix that has no counterpart across the diagonal."""
    n, rows = matrix.shape[0], matrix.row_of_entry
    entries, mirrored = rows * np.int64(n) + matrix.indices, matrix.indices * np.int64(n) + rows
    row, column = divmod(int(np.setdiff1d(entries, mirrored)[0]), n)
    return row, column


def _rows_of(matrix: csr_array | CompressedRows) -> CompressedRows:
    """Return a square matrix in the form that kernels take."""
    if matrix.shape[0] != matrix.shape[1]:
        raise SolverError(f"only square matrices have Cholesky factors, not one of {matrix.shape}")
    return CompressedRows.of(matrix)
