"""Read-only arrays, kept read-only through pickling and copying."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["FrozenArrays", "freeze", "freeze_csr", "unchanging"]

Scalar = TypeVar("Scalar", bound=np.generic)


def freeze(array: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return `array`, now read-only (the caller must own its memory)."""
    array.setflags(write=False)
    return array


def unchanging(array: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return `array` if it is read-only, otherwise a copy that is."""
    return freeze(array.copy()) if array.flags.writeable else array


def freeze_csr(matrix: csr_array) -> csr_array:
    """Return `matrix` with sorted rows and read-only arrays.

    Rows are sorted first: SciPy sorts in place on demand, which read-only arrays would refuse.
    """
    matrix.sum_duplicates()
    for array in (matrix.data, matrix.indices, matrix.indptr):
        array.setflags(write=False)
    return matrix


class FrozenArrays:
    """Mixin for dataclasses of arrays: unpickled and copied arrays are read-only again.

    NumPy drops the flag when it pickles.
    """

    def _set(self, **attributes: Any) -> None:
        """Set attributes during construction of a frozen dataclass; arrays become read-only."""
        for name, value in attributes.items():
            object.__setattr__(
                self, name, freeze(value) if isinstance(value, np.ndarray) else value
            )

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for value in state.values():
            if isinstance(value, np.ndarray):
                freeze(value)
            elif hasattr(value, "sum_duplicates"):  # csr_array, without importing SciPy
                freeze_csr(value)
