"""Supernodal sparse Cholesky as a linear solver, over the kernels of ``native/linear``.

The road from a matrix to a solution: a permutation that keeps the factor sparse (approximate
minimum degree), what the factor will look like (supernodes), both for all matrices of one pattern;
then the factor (multifrontal, dense Cholesky on each supernode), and forward and back substitution,
one column or a block.

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

OF_LU = 1 / 3
"""Share of the bytes of L and U that L takes, one row index serving a whole row of a supernode.

The analysis knows how many there are; this is to refuse at once what is hopeless.
"""

MAX_ERROR_OF_COMPACT_FACTOR = 1e-4
"""Error from which on a compact factor is not used. Measured on meshes and grids of up to 560,000
vertices: 1e-6 to 7e-6."""


@final
@dataclass(frozen=True, kw_only=True)
class Supernodal(LinearSolver):
    """Supernodal sparse Cholesky: minimum-degree ordering, multifrontal, dense kernels of its own.

    The pattern is analysed once for all matrices that share it, and no step holds Python's lock.
    On an M-matrix every step adds numbers of one sign: each entry of the solution is accurate
    relative to itself.

    Parameters
    ----------
    compact : bool
        Keep the upper half of each number of a factor: its sign, its whole range and six digits.
        Half the memory, and solves that wait for memory are up to twice as fast; a solution is off
        by about 1e-6 of its largest value, and each value of heat by about 1e-6 of itself. A factor
        is tried before it is used, and kept in full where that does not hold.

    Raises
    ------
    InvalidOptionError
        `compact` is neither.

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
            OF_LU * factor_bytes(pattern.shape[0], pattern.nnz),
            f"factorising {pattern.shape[0]} unknowns with {pattern.nnz} entries",
        )
        return SupernodalAnalysis(_rows_of(pattern), compact=bool(self.compact))

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
        Keep the upper half of each number only, where that will do.

    Raises
    ------
    SolverError
        It has entries without a mirror image.
    """

    def __init__(self, pattern: CompressedRows, *, compact: bool = False) -> None:
        self.compact = compact
        self._pattern = unchanging(pattern.indptr), unchanging(pattern.indices)
        self._analysis = _analysis_of(pattern)

    def expected_bytes(self, n_factors: int) -> float:
        """Return what so many factors take, with their stacks of update matrices: exactly that."""
        one = self._analysis.factor_bytes(self.compact) + 24.0 * len(self._analysis.order)
        return self._analysis.nbytes + n_factors * one

    def factorize(self, matrix: csr_array | CompressedRows) -> SupernodalFactor:
        """Return the Cholesky factor of `matrix`; of another pattern, after an analysis of it."""
        its = _rows_of(matrix)
        analysis = self._analysis if self._fits(its) else _analysis_of(its)
        _require_finite(its)
        if self.compact:
            factor = _cholesky(its, analysis, compact=True)
            if _is_accurate(factor, its):
                return factor
        return _cholesky(its, analysis, compact=False)

    def _fits(self, matrix: CompressedRows) -> bool:
        """Return whether a matrix has the pattern that was analysed."""
        return all(
            own is other or np.array_equal(own, other)
            for own, other in zip(self._pattern, matrix.arrays[:2], strict=True)
        )


class SupernodalFactor(Factor):
    """A Cholesky factor in dense panels; solving changes nothing in it.

    Parameters
    ----------
    analysis : _native.Analysis
    factor : _native.Factor
    """

    def __init__(self, analysis: _native.Analysis, factor: _native.Factor) -> None:
        self._analysis, self._factor = analysis, factor

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, for one column or a block of them.

        Zeros in b save work: the forward substitution passes subtrees by in which b is zero.
        """
        return self._solved(right_hand_side, over=False)

    def solve_over(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x in the memory of b, if that is an array of numbers in their usual order."""
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
        """Numbers stored for the factor, the zeros of its dense panels included."""
        return self._analysis.n_stored

    @property
    def nbytes(self) -> int:
        """Bytes that they take."""
        return self._factor.nbytes

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a factor is not pickled; pickle its matrix, and factorise it again where it arrives"
        )

    def __repr__(self) -> str:
        return f"SupernodalFactor({len(self._analysis.order)} unknowns, {self.nnz} entries)"


def _analysis_of(matrix: CompressedRows) -> _native.Analysis:
    """Return the analysis of the pattern of a symmetric matrix."""
    if not _native.is_symmetric(matrix.indptr, matrix.indices):
        row, column = _without_mirror_image(matrix)
        raise SolverError(
            f"the matrix is not symmetric: it has an entry ({row}, {column}) and none at "
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
    except MemoryError as error:  # a limit of this process, or a system that does not say
        raise NotEnoughMemoryError(
            f"{work} needs about {needed / 1e9:.3g} GB of memory, which could not be had"
        ) from error
    return SupernodalFactor(analysis, factor)


def _is_accurate(factor: SupernodalFactor, matrix: CompressedRows) -> bool:
    """Return whether a factor gives back the constant vector.

    That is nearly in the null space of a Laplacian, so its equations are those that errors of the
    factor hurt most.
    """
    row_sums = _native.row_sums(*matrix.arrays)
    try:
        error = np.abs(factor.solve_over(row_sums) - 1).max(initial=0.0)
    except SolverError:  # the sums overflow, which is for the full factor to report
        return False
    return bool(error <= MAX_ERROR_OF_COMPACT_FACTOR)


def _require_finite(matrix: CompressedRows) -> None:
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(matrix.data.sum()):  # the sum of finite ones may overflow, too
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
    """Return a square matrix as kernels take it."""
    if matrix.shape[0] != matrix.shape[1]:
        raise SolverError(f"only square matrices have Cholesky factors, not one of {matrix.shape}")
    return CompressedRows.of(matrix)
