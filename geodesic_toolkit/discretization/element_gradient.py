"""Gradients on elements: triangles, tetrahedra, polygons, cells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.checks import check_finite, check_range, coerce
from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.gradient import MIN_RELATIVE_SLOPE, Gradient, as_columns
from geodesic_toolkit.discretization.graph_laplacian import graph_laplacian
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.discretization.triangle_sums import TriangleSums, sums_of_triangles
from geodesic_toolkit.errors import InvalidDiscretizationError
from geodesic_toolkit.geometry.triangles import hat_gradients_from_inverse

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["ElementGradient"]


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class ElementGradient(Gradient):
    """Gradients that are constant on elements: triangles, tetrahedra, polygons, cells.

    Parameters
    ----------
    elements : ndarray of shape (E, m), int64
        The vertices of each element.
    coefficients : ndarray of shape (E, dim, m), float64
        On element e the gradient of u is ``coefficients[e] @ u[elements[e]]``, in any orthonormal
        frame of the element. Each row sums to zero.
    measure : ndarray of shape (E,), float64
        Area or volume of each element, non-negative.
    vertex_count : int
        Number N of vertices, including unreferenced ones.
    stars : bool
        True if the elements overlap and each belongs to the star of its first vertex, as in a point
        cloud; `measure` then is a share of each.
    copy : bool
        False transfers the arrays: they become read-only instead of being copied.

    Raises
    ------
    InvalidDiscretizationError
        Shapes that do not fit, indices out of range, values that are not finite, a negative
        measure.

    Examples
    --------
    The right triangle with legs of length 1, and the function u = x on it:

    >>> import numpy as np
    >>> from geodesic_toolkit.discretization.element_gradient import ElementGradient
    >>> gradient = ElementGradient(
    ...     elements=np.array([[0, 1, 2]]),
    ...     coefficients=np.array([[[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]]),
    ...     measure=np.array([0.5]),
    ...     vertex_count=3,
    ... )
    >>> gradient.matrix @ np.array([0.0, 1.0, 0.0])
    array([1., 0.])
    >>> gradient.stiffness().toarray()
    array([[ 1. , -0.5, -0.5],
           [-0.5,  0.5,  0. ],
           [-0.5,  0. ,  0.5]])
    """

    elements: IntArray
    measure: FloatArray
    vertex_count: int
    stars: bool
    _given: str

    def __init__(
        self,
        elements: IntArray,
        coefficients: FloatArray,
        measure: FloatArray,
        vertex_count: int,
        stars: bool = False,
        *,
        copy: bool = True,
    ) -> None:
        given = {"elements": elements, "coefficients": coefficients, "measure": measure}
        _set(self, **given, vertex_count=vertex_count, stars=stars, copy=copy)
        count, size = self.elements.shape if self.elements.ndim == 2 else (-1, -1)
        shape = self.coefficients.shape
        if len(shape) != 3 or (shape[0], shape[2]) != (count, size) or len(self.measure) != count:
            raise InvalidDiscretizationError(
                f"elements {self.elements.shape}, coefficients {shape} and measure "
                f"{self.measure.shape} must be (E, m), (E, dim, m) and (E,)"
            )
        _check(self, self.coefficients)

    @classmethod
    def of_triangles(
        cls,
        elements: IntArray,
        inverse: FloatArray,
        areas: FloatArray,
        vertex_count: int,
        *,
        copy: bool = True,
    ) -> ElementGradient:
        """Return the gradient of linear finite elements on triangles.

        It keeps three numbers for each triangle; coefficients are derived at their first use.

        Parameters
        ----------
        elements : ndarray of shape (E, 3), int64
        inverse : ndarray of shape (E, 3), float64
            The triangles in the form of :attr:`inverse_frames`.
        areas : ndarray of shape (E,), float64
        vertex_count : int
            Number N of vertices, including unreferenced ones.
        copy : bool
            False transfers the arrays: they become read-only instead of being copied.

        Returns
        -------
        ElementGradient

        Raises
        ------
        InvalidDiscretizationError
            Indices out of range; triangles of zero area.
        """
        gradient = cls.__new__(cls)
        given = {"elements": elements, "inverse_frames": inverse, "measure": areas}
        _set(gradient, **given, vertex_count=vertex_count, stars=False, copy=copy)
        _check(gradient, gradient.inverse_frames)
        return gradient

    @property
    def n_vertices(self) -> int:
        """Number N of vertices."""
        return self.vertex_count

    @property
    def dim(self) -> int:
        """Number of dimensions of the elements."""
        return 2 if self._given == "inverse_frames" else self.coefficients.shape[1]

    @property
    def of_planes(self) -> bool:
        """True if the elements have three vertices and two dimensions, as triangles do."""
        return self.elements.shape[1] == 3 and self.dim == 2

    @cached_property
    def coefficients(self) -> FloatArray:
        """The gradients of the hat functions, of shape (E, dim, m)."""
        return freeze(hat_gradients_from_inverse(self.inverse_frames))

    @cached_property
    def inverse_frames(self) -> FloatArray:
        """Triangles as three numbers ``(p, q, r)`` each, of shape (E, 3).

        In an orthonormal frame of a triangle the gradient of u is ``(p (u₁ - u₀), q (u₁ - u₀) + r
        (u₂ - u₀))``: the inverse of the matrix of its edges, which is lower triangular because the
        gradient of the second hat function is along the second axis.
        """
        first, second = self.coefficients[:, :, 1], self.coefficients[:, :, 2]
        steepness = np.hypot(second[:, 0], second[:, 1])
        axis = np.zeros_like(second)
        axis[:, 1] = 1.0  # any axis is valid for a segment, whose second hat function is 0
        np.divide(second, steepness[:, None], out=axis, where=steepness[:, None] > 0)
        across = first[:, 0] * axis[:, 1] - first[:, 1] * axis[:, 0]
        along = np.einsum("ed,ed->e", first, axis)
        return freeze(np.column_stack([across, along, steepness]))

    def unit(self, log_heat: FloatArray) -> FloatArray:
        """Return ``∇u/|∇u|`` on every element, of shape (E, dim) or (E, dim, K).

        Directions depend only on ratios inside an element, so u is scaled by its largest value
        there, and the result is accurate for arbitrarily small heat.
        """
        corner_log = log_heat[self.elements]
        largest = corner_log.max(axis=1, keepdims=True)
        largest[largest == -np.inf] = 0.0  # without heat u = 0, and so is its gradient
        corner_log -= largest
        scaled = np.exp(corner_log, out=corner_log)
        gradient = self._apply(scaled)
        gradient *= (np.ptp(scaled, axis=1) >= MIN_RELATIVE_SLOPE)[:, None]
        length = np.sqrt(np.einsum("ed...,ed...->e...", gradient, gradient))[:, None]
        np.divide(gradient, length, out=gradient, where=length > 0)
        return gradient

    def _apply(self, corner_values: FloatArray) -> FloatArray:
        """Return the gradient from differences to the first corner: exactly 0 for a constant."""
        _, dim, size = self.coefficients.shape
        trailing = corner_values.shape[2:]
        difference = corner_values[:, 1:] - corner_values[:, :1]
        gradient = np.zeros((len(self.elements), dim, *trailing))
        for axis in range(dim):
            for corner in range(1, size):
                coefficient = self.coefficients[:, axis, corner].reshape(-1, *(1,) * len(trailing))
                gradient[:, axis] += coefficient * difference[:, corner - 1]
        return gradient

    def descent_load(self, heat: Heat) -> FloatArray:
        """Return ``Gᵀ W X`` with ``X = -∇u/|∇u|``, (N,) or (N, K); on triangles in one pass."""
        if not self.of_planes:
            return super().descent_load(heat)
        triangles = (self.elements, self.inverse_frames, self.measure)
        return _native.poisson_load(*triangles, *heat.for_kernels())

    def adjoint(self, field: FloatArray) -> FloatArray:
        """Return ``Gᵀ W x`` of a field of shape (E, dim) or (E, dim, K)."""
        weighted = self.coefficients * self.measure[:, None, None]
        corners = self.elements.ravel()
        columns = as_columns(field, 2)
        result = np.empty((self.n_vertices, columns.shape[2]))
        for k in range(columns.shape[2]):
            pull = np.einsum("edm,ed->em", weighted, columns[:, :, k])
            result[:, k] = np.bincount(corners, pull.ravel(), minlength=self.n_vertices)
        return result.reshape(self.n_vertices, *field.shape[2:])

    @property
    def matrix(self) -> csr_array:
        """G of shape (E dim, N): the rows of an element follow one another."""
        from scipy.sparse import coo_array, csr_array

        count, dim, size = self.coefficients.shape
        rows = np.repeat(np.arange(count * dim), size)
        columns = np.repeat(self.elements, dim, axis=0).ravel()
        entries = (self.coefficients.ravel(), (rows, columns))
        return csr_array(coo_array(entries, shape=(count * dim, self.n_vertices)))

    @property
    def weights(self) -> FloatArray:
        """The measure of each element, once for each of its dim rows."""
        return np.repeat(self.measure, self.dim)

    def stiffness(self) -> csr_array:
        """Return ``L = Gᵀ W G``, assembled from the elements' off-diagonal entries."""
        if self.of_planes:
            return self.sums().stiffness().scipy
        size = self.elements.shape[1]
        pairs = [(i, j) for i in range(size) for j in range(i + 1, size)]
        products = [
            np.einsum("ed,ed->e", self.coefficients[:, :, i], self.coefficients[:, :, j])
            for i, j in pairs
        ]
        tails = np.concatenate([self.elements[:, i] for i, _ in pairs])
        heads = np.concatenate([self.elements[:, j] for _, j in pairs])
        entries = np.tile(self.measure, len(pairs)) * np.concatenate(products)
        return graph_laplacian(-entries, tails, heads, self.n_vertices)

    def sums(self) -> TriangleSums:
        """Return the sums over triangles: edge weights, mass and boundary."""
        return sums_of_triangles(self.elements, self.inverse_frames, self.measure, self.n_vertices)

    def __getstate__(self) -> dict[str, Any]:
        """Return the state without derived attributes."""
        derived = {"coefficients", "inverse_frames"} - {self._given}
        return {name: value for name, value in self.__dict__.items() if name not in derived}

    def __repr__(self) -> str:
        count, size = self.elements.shape
        return f"ElementGradient({count} elements of {size} vertices in {self.dim} dimensions)"


def _set(
    gradient: ElementGradient, *, vertex_count: int, stars: bool, copy: bool, **arrays: Any
) -> None:
    """Set the attributes; the form of the elements that is not given is derived on use."""
    form = "coefficients" if "coefficients" in arrays else "inverse_frames"
    vars(gradient).update(arrays, vertex_count=vertex_count, stars=stars, _given=form)
    coerce(gradient, copy=copy, elements=np.int64, measure=np.float64, **{form: np.float64})


def _check(gradient: ElementGradient, form: FloatArray) -> None:
    check_range(gradient.elements, gradient.vertex_count, "element")
    check_finite(form, "gradient coefficient")
    check_finite(gradient.measure, "measure")
    if len(gradient.measure) and gradient.measure.min() < 0:
        bad = int(gradient.measure.argmin())
        raise InvalidDiscretizationError(
            f"element {bad} has the negative measure {gradient.measure[bad]}"
        )
