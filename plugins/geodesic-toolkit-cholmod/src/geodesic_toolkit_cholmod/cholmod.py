"""Sparse Cholesky factors by CHOLMOD, by way of scikit-sparse."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    MissingDependencyError,
    NotEnoughMemoryError,
    SolverError,
)

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Cholmod"]

FloatArray: TypeAlias = NDArray[np.float64]

BYTES_PER_ENTRY = 12
"""Of an entry: its value and a row index."""

MIN_PIVOT = 4 * float(np.finfo(np.float64).eps)
"""Share of a diagonal entry that elimination leaves where it is not rounding. A grounded Laplacian
of a path of n vertices leaves 1/n, and the stiffest ties of a point cloud 1e-6."""


@final
@dataclass(frozen=True, kw_only=True)
class Cholmod(gt.LinearSolver):
    """Sparse Cholesky factors by CHOLMOD, of SuiteSparse.

    The heat and the Poisson system of one discretization share an ordering. There is no pivoting,
    so that on an M-matrix each entry of a solution is accurate relative to itself.

    Parameters
    ----------
    mode : {"auto", "simplicial", "supernodal"}
        How factors are stored. CHOLMOD's licence is LGPL for the first, and GPL for the second,
        which "auto" takes for large ones.
    ordering : {"default", "amd", "metis", "nesdis", "best"}
        How fill-in is kept small.

    Raises
    ------
    InvalidOptionError
        A value outside the ones above.
    MissingDependencyError
        scikit-sparse 0.4 is not installed.

    References
    ----------
    Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, *Algorithm 887: CHOLMOD*, ACM Trans. Math.
    Softw. 35, 2008, https://doi.org/10.1145/1391989.1391995

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> distance = gt.GeodesicSolver(sphere, solver="cholmod").distance(0)
    >>> bool(abs(distance - gt.geodesic_distance(sphere, 0)).max() < 1e-6)
    True
    """

    mode: Literal["auto", "simplicial", "supernodal"] = "auto"
    ordering: Literal["default", "amd", "metis", "nesdis", "best"] = "default"

    componentwise: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("10.1145/1391989.1391995",)

    def __post_init__(self) -> None:
        for option, values in (
            ("mode", ("auto", "simplicial", "supernodal")),
            ("ordering", ("default", "amd", "metis", "nesdis", "best")),
        ):
            if getattr(self, option) not in values:
                raise InvalidOptionError(
                    f"{option} must be one of {', '.join(values)}, not {getattr(self, option)!r}"
                )
        _library()  # before a long computation, not after it

    def analyse(self, pattern: csr_array) -> Analysis:
        """Return the ordering of all matrices of this pattern."""
        columns = _columns(pattern)
        with _typed_errors(columns):
            symbolic = _library().analyze(columns, mode=self.mode, ordering_method=self.ordering)
        return Analysis(self, symbolic, columns)

    def factorize(self, matrix: csr_array) -> CholmodFactor:
        """Return the Cholesky factor of a symmetric positive definite `matrix`."""
        return self.analyse(matrix).factorize(matrix)


class Analysis(gt.Analysis):
    """An ordering, and the pattern that it is for."""

    def __init__(self, solver: Cholmod, symbolic: Any, pattern: Any) -> None:
        self._solver, self._symbolic = solver, symbolic
        self._pattern = pattern.indptr.copy(), pattern.indices.copy()
        self._lock = threading.Lock()

    def factorize(self, matrix: csr_array) -> CholmodFactor:
        """Return the Cholesky factor of `matrix`, in this ordering if it has the pattern."""
        columns = _columns(matrix)
        if not all(map(np.array_equal, self._pattern, (columns.indptr, columns.indices))):
            return self._solver.factorize(matrix)
        with self._lock, _typed_errors(columns):
            factor = self._symbolic.cholesky(columns)
            pivots, order = factor.D(), factor.P()
        shares = pivots / columns.diagonal()[order]
        worst = int(shares.argmin())
        if not shares[worst] > MIN_PIVOT:
            raise SolverError(
                f"the matrix is singular to working precision: eliminating unknown {order[worst]} "
                f"leaves {shares[worst]:.1e} of its diagonal entry"
            )
        return CholmodFactor(factor)


class CholmodFactor(gt.Factor):
    """A Cholesky factor held by CHOLMOD."""

    def __init__(self, factor: Any) -> None:
        self._factor = factor
        self._lock = threading.Lock()

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, for one column or a block of them."""
        with self._lock:  # the workspace belongs to the factor
            solution = self._factor(np.asarray(right_hand_side, dtype=np.float64, order="F"))
        if not np.isfinite(solution).all():
            raise SolverError(
                "CHOLMOD's solution is not finite: the matrix is singular to working precision"
            )
        return np.ascontiguousarray(solution)

    @cached_property
    def nnz(self) -> int:
        """Entries of the factor."""
        with self._lock:
            return int(self._factor.L().nnz)

    @property
    def nbytes(self) -> int:
        """Bytes of their values and row indices."""
        return BYTES_PER_ENTRY * self.nnz


def _library() -> Any:
    """Return scikit-sparse's module of CHOLMOD.

    Raises
    ------
    MissingDependencyError
        It is not installed, or is version 0.5, which has another interface.
    """
    try:
        library = importlib.import_module("sksparse.cholmod")
    except ImportError as error:
        raise MissingDependencyError(
            f"Cholmod needs scikit-sparse ({error}): pip install "
            "'geodesic-toolkit-cholmod[cholmod]', which needs SuiteSparse and a compiler; on "
            "Debian and Ubuntu: apt-get install libsuitesparse-dev"
        ) from error
    if not hasattr(library, "analyze"):
        raise MissingDependencyError(
            "Cholmod needs the interface of scikit-sparse 0.4, which a newer version has replaced: "
            "pip install 'scikit-sparse<0.5'"
        )
    return library


def _columns(matrix: Any) -> Any:
    """Return a symmetric matrix as CHOLMOD takes it."""
    from scipy.sparse import csc_matrix

    columns = csc_matrix(matrix)
    columns.sort_indices()
    return columns


@contextmanager
def _typed_errors(matrix: Any) -> Iterator[None]:
    """Turn errors of CHOLMOD into those of geodesic-toolkit."""
    library = _library()
    what = f"CHOLMOD could not factorise {matrix.shape[0]} unknowns with {matrix.nnz} entries"
    try:
        yield
    except (library.CholmodOutOfMemoryError, library.CholmodTooLargeError, MemoryError) as error:
        raise NotEnoughMemoryError(f"{what}: {error}") from error
    except library.CholmodError as error:
        raise SolverError(f"{what}: {error}") from error
