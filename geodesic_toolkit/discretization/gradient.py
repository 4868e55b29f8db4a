"""The interface of a discrete gradient."""

from __future__ import annotations

import abc
import math
from typing import TYPE_CHECKING

from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.heat import Heat

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["MIN_RELATIVE_SLOPE", "Gradient", "as_columns"]

MIN_RELATIVE_SLOPE = 1e-11
"""Minimum relative difference of heat on an element for a direction; poisson_load.cpp has the
reason."""


class Gradient(FrozenArrays, abc.ABC):
    """A discrete gradient ∇, its normalisation, and its adjoint.

    A field holds the gradient of a function: an array whose leading axes enumerate the rows of
    `matrix` in order, with one more axis at the end if it holds K fields at once.
    """

    @property
    @abc.abstractmethod
    def n_vertices(self) -> int:
        """Number N of vertices."""

    @abc.abstractmethod
    def unit(self, log_heat: FloatArray) -> FloatArray:
        """Return ``∇u/|∇u|`` from ``log u``; zero on elements with a zero gradient.

        Parameters
        ----------
        log_heat : ndarray of shape (N,) or (N, K)
            Logarithm of the heat; ``-inf`` at vertices without heat.
        """

    @abc.abstractmethod
    def adjoint(self, field: FloatArray) -> FloatArray:
        """Return ``Gᵀ W x``, of shape (N,) or (N, K): *minus* the integrated divergence of `field`.

        It is the right-hand side for the positive semidefinite stiffness ``L = -Δ``: ``L φ = Gᵀ W
        x`` is the least-squares solution of ``∇φ = x``.

        Parameters
        ----------
        field : ndarray
            A field, with one more axis at the end if it holds K fields at once.
        """

    def descent_load(self, heat: Heat) -> FloatArray:
        """Return ``Gᵀ W X`` with ``X = -∇u/|∇u|``: the right-hand side of ``L φ = Gᵀ W X``.

        It is *minus* the integrated divergence of X, as L is -Δ; X is zero on elements with a zero
        gradient. It is computed by `unit` and `adjoint`; a subclass need not override it.

        Parameters
        ----------
        heat : Heat
            Heat at N vertices.

        Returns
        -------
        ndarray of the shape of the heat, (N,) or (N, K), float64
        """
        return -self.adjoint(self.unit(heat.log()))

    @property
    @abc.abstractmethod
    def matrix(self) -> csr_array:
        """The sparse matrix G of shape (R, N), derived on request."""

    @property
    @abc.abstractmethod
    def weights(self) -> FloatArray:
        """The diagonal of W, of shape (R,): the weight of each row of `matrix` in an integral."""

    @abc.abstractmethod
    def stiffness(self) -> csr_array:
        """Return ``L = Gᵀ W G``, positive semidefinite, symmetric to the bit, with ``L 1 = 0``."""


def as_columns(array: FloatArray, leading: int) -> FloatArray:
    """Return `array` with all axes after the `leading` ones merged into one axis."""
    return array.reshape(*array.shape[:leading], math.prod(array.shape[leading:]))
