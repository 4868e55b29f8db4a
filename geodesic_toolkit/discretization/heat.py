"""Heat, as it passes from the diffusion to whatever reads it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geodesic_toolkit.core.types import FloatArray

__all__ = ["Heat", "log_of"]


@dataclass(frozen=True, eq=False)
class Heat:
    """The heat u of K source sets.

    Which form it is kept in is a matter of the diffusion that makes it and of the kernels that read
    it: u itself, as long as floats hold its range, which saves a logarithm and a power of each
    value; log u beyond that. Any other reader takes :meth:`log`.

    Attributes
    ----------
    values : ndarray of shape (N,) or (N, K), float64
        u, of which every value is positive where heat comes and none has underflown; or log u,
        over an unlimited range. In either form greater values are greater heat.
    logarithmic : bool
        Which of the two.

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
        """Return heat of which u is known, (N,) or (N, K); not below 1e-300 where it matters."""
        return cls(heat, logarithmic=False)

    @classmethod
    def of_log(cls, log_heat: FloatArray) -> Heat:
        """Return heat of which log u is known, (N,) or (N, K); ``-inf`` where there is none."""
        return cls(log_heat, logarithmic=True)

    def log(self) -> FloatArray:
        """Return log u, of the shape of the values; ``-inf`` where no heat comes."""
        return self.values if self.logarithmic else log_of(self.values)

    def for_kernels(self) -> tuple[FloatArray, bool]:
        """Return the values in C order and which form they have: two arguments of kernels."""
        return np.ascontiguousarray(self.values, dtype=np.float64), self.logarithmic

    def squeezed(self) -> Heat:
        """Return the heat of shape (N,) if it is that of one source set."""
        if self.values.shape[1:] != (1,):
            return self
        return Heat(self.values[:, 0], self.logarithmic)

    def replaced(self, columns: Sequence[int], other: Heat) -> Heat:
        """Return the heat with these columns from another one; its own are written over."""
        if self.logarithmic or other.logarithmic:
            values = self.log()
            values[:, columns] = other.log()
            return Heat.of_log(values)
        self.values[:, columns] = other.values
        return self


def log_of(heat: FloatArray) -> FloatArray:
    """Return log u of heat u; ``-inf`` where it is not positive."""
    return np.log(heat, out=np.full_like(heat, -np.inf), where=~(heat <= 0))
