"""Heat, as the diffusion returns it and gradients and fronts read it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geodesic_toolkit.core.types import FloatArray

__all__ = ["Heat", "log_of"]


@dataclass(frozen=True, eq=False)
class Heat:
    """The heat u of K source sets.

    The form of the values is chosen by the diffusion and read by kernels: u itself, as long as
    floats hold its range, which saves a logarithm and a power of each value; log u beyond that.
    Other code uses :meth:`log`.

    Attributes
    ----------
    values : ndarray of shape (N,) or (N, K), float64
        u, positive and without underflow at all vertices with heat; or log u, over an unlimited
        range. In either form larger values are larger heat.
    logarithmic : bool
        True if the values are log u.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.discretization.heat import Heat
    >>> Heat.of(np.array([1.0, 0.0])).log()
    array([  0., -inf])
    """

    values: FloatArray
    logarithmic: bool

    @classmethod
    def of(cls, heat: FloatArray) -> Heat:
        """Return heat given by u, (N,) or (N, K), which must not underflow."""
        return cls(heat, logarithmic=False)

    @classmethod
    def of_log(cls, log_heat: FloatArray) -> Heat:
        """Return heat given by log u, (N,) or (N, K); ``-inf`` at vertices without heat."""
        return cls(log_heat, logarithmic=True)

    def log(self) -> FloatArray:
        """Return log u, of the shape of the values; ``-inf`` at vertices without heat."""
        return self.values if self.logarithmic else log_of(self.values)

    def for_kernels(self) -> tuple[FloatArray, bool]:
        """Return the values in C order, and True if they are log u: two arguments of kernels."""
        return np.ascontiguousarray(self.values, dtype=np.float64), self.logarithmic

    def squeezed(self) -> Heat:
        """Return the heat of one source set with shape (N,), any other unchanged."""
        if self.values.shape[1:] != (1,):
            return self
        return Heat(self.values[:, 0], self.logarithmic)

    def replaced(self, columns: Sequence[int], other: Heat) -> Heat:
        """Return the heat with these columns from another one; they are overwritten in place."""
        if self.logarithmic or other.logarithmic:
            values = self.log()
            values[:, columns] = other.log()
            return Heat.of_log(values)
        self.values[:, columns] = other.values
        return self


def log_of(heat: FloatArray) -> FloatArray:
    """Return log u of heat u; ``-inf`` at values that are not positive."""
    return np.log(heat, out=np.full_like(heat, -np.inf), where=~(heat <= 0))
