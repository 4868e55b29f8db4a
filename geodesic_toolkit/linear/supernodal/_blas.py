"""The dense kernels that SciPy ships, callable from compiled code.

:mod:`scipy.linalg.cython_blas` and :mod:`~scipy.linalg.cython_lapack` hold the addresses of the
Fortran routines that SciPy itself uses. Matrices are stored by columns, as an address and a stride;
every argument goes by reference, out of the `arguments` that a caller makes once.
"""

from typing import Any, TypeAlias

import llvmlite.binding
import numba
import numpy as np
from numba import types
from numba.extending import get_cython_function_address
from numpy.typing import NDArray

from geodesic_toolkit._typing import FloatArray, IndexArray

__all__ = ["Arguments", "arguments", "cholesky", "divide", "minus_gram", "minus_product"]

Arguments: TypeAlias = tuple[IndexArray, FloatArray, NDArray[np.uint8]]

kernel = numba.njit(cache=True, nogil=True, error_model="numpy", forceinline=True)


def _external(library: str, routine: str, n_arguments: int) -> Any:
    """Return a Fortran routine of SciPy under a symbol by which cached kernels find it again."""
    symbol = f"geodesic_toolkit_{routine}"
    place = get_cython_function_address(f"scipy.linalg.{library}", routine)
    llvmlite.binding.add_symbol(symbol, place)
    return types.ExternalFunction(symbol, types.void(*(types.uintp,) * n_arguments))


_potrf = _external("cython_lapack", "dpotrf", 5)
_syrk = _external("cython_blas", "dsyrk", 10)
_trsm = _external("cython_blas", "dtrsm", 11)
_gemm = _external("cython_blas", "dgemm", 13)


@kernel  # type: ignore[untyped-decorator]
def arguments() -> Arguments:
    """Return the memory out of which the routines read sizes, factors and letters."""
    letters = np.array([ord("L"), ord("R"), ord("N"), ord("T")], np.uint8)
    return np.zeros(6, np.int32), np.array([1.0, -1.0, 0.0]), letters


@kernel  # type: ignore[untyped-decorator]
def cholesky(memory: Arguments, a: int, order: int, stride: int) -> int:
    """Replace the lower triangle of A by L with ``L Lᵀ = A``; return the first pivot <= 0, or 0.

    The count of pivots begins at 1.
    """
    sizes, _, letters = memory
    size, letter = np.uintp(sizes.ctypes.data), np.uintp(letters.ctypes.data)
    sizes[0], sizes[1], sizes[2] = order, stride, 0
    _potrf(letter, size, a, size + np.uintp(4), size + np.uintp(8))
    return int(sizes[2])


@kernel  # type: ignore[untyped-decorator]
def divide(  # noqa: PLR0917 - kernels take no keywords
    memory: Arguments,
    x: int,
    x_stride: int,
    n_rows: int,
    a: int,
    stride: int,
    order: int,
    transposed: bool,
) -> None:
    """Replace X by ``X L⁻¹``, or by ``X L⁻ᵀ``, for L lower triangular in A."""
    sizes, factors, letters = memory
    size, factor = np.uintp(sizes.ctypes.data), np.uintp(factors.ctypes.data)
    letter = np.uintp(letters.ctypes.data)
    plain = letter + np.uintp(2)
    way = letter + np.uintp(3) if transposed else plain
    sizes[0], sizes[1], sizes[2], sizes[3] = n_rows, order, stride, x_stride
    _trsm(
        letter + np.uintp(1),
        letter,
        way,
        plain,
        size,
        size + np.uintp(4),
        factor,
        a,
        size + np.uintp(8),
        x,
        size + np.uintp(12),
    )


@kernel  # type: ignore[untyped-decorator]
def minus_gram(  # noqa: PLR0917 - kernels take no keywords
    memory: Arguments, b: int, stride: int, n_rows: int, n_columns: int, c: int, fresh: bool
) -> None:
    """Subtract ``B Bᵀ`` from the lower triangle of the dense C, taken for zero where `fresh`."""
    sizes, factors, letters = memory
    size, factor = np.uintp(sizes.ctypes.data), np.uintp(factors.ctypes.data)
    letter = np.uintp(letters.ctypes.data)
    sizes[0], sizes[1], sizes[2] = n_rows, n_columns, stride
    _syrk(
        letter,
        letter + np.uintp(2),
        size,
        size + np.uintp(4),
        factor + np.uintp(8),
        b,
        size + np.uintp(8),
        factor + np.uintp(16) if fresh else factor,
        c,
        size,
    )


@kernel  # type: ignore[untyped-decorator]
def minus_product(  # noqa: PLR0917 - kernels take no keywords
    memory: Arguments,
    x: int,
    n_rows: int,
    n_inner: int,
    b: int,
    stride: int,
    n_columns: int,
    transposed: bool,
    c: int,
    fresh: bool,
) -> None:
    """Subtract ``X B``, or ``X Bᵀ``, from the dense C, taken for zero where `fresh`.

    X and C have `n_rows` rows and no gaps between their columns.
    """
    sizes, factors, letters = memory
    size, factor = np.uintp(sizes.ctypes.data), np.uintp(factors.ctypes.data)
    plain = np.uintp(letters.ctypes.data) + np.uintp(2)
    sizes[0], sizes[1], sizes[2], sizes[3] = n_rows, n_columns, n_inner, stride
    _gemm(
        plain,
        plain + np.uintp(1) if transposed else plain,
        size,
        size + np.uintp(4),
        size + np.uintp(8),
        factor + np.uintp(8),
        x,
        size,
        b,
        size + np.uintp(12),
        factor + np.uintp(16) if fresh else factor,
        c,
        size,
    )
