"""Sources as convex combinations of vertices, from which the heat method starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.errors import InvalidSourceError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["SourcePoints", "as_vertices"]

ADVICE_ON_MASKED_SOURCES = "the unmasked ones are {}.compressed(), or the complete rows of a table"
"""Advice on how to replace sources of which some are masked."""

LOG_RANGE_OF_LAYER = 200.0
"""Maximum range, in powers of e, of the sources of one right-hand side; float64 has 700."""


@dataclass(frozen=True)
class SourcePoints(FrozenArrays):
    """A set of P sources as convex combinations of vertices.

    Attributes
    ----------
    vertices : ndarray of shape (nnz,), int64
        The vertices around the points, one point after the other; repeated if points share one.
    shares : ndarray of shape (nnz,), float64
        The barycentric weights of the vertices, with sum 1 for each point.
    begins : ndarray of shape (P + 1,), int64
        Index of the first vertex of each point, and nnz at the end.
    n_vertices : int
        Number N of vertices of the domain.
    distances : ndarray of shape (nnz,), float64
        The distance of each vertex from its point; 0 for a point at a vertex.
    starts : ndarray of shape (P,), float64
        The offset of each point; 0 unless given.
    front_curvatures : ndarray of shape (nnz,), float64, optional
        Geodesic curvature κ of the front at the vertices; that of a circle around the point, ``1 /
        distances``, unless given.
    copy : bool
        False keeps the arrays without a copy, if they will not change.
    """

    vertices: IntArray
    shares: FloatArray
    begins: IntArray
    n_vertices: int
    distances: FloatArray
    starts: FloatArray = field(default_factory=lambda: np.zeros(0))
    front_curvatures: FloatArray | None = None
    copy: InitVar[bool] = True

    def __post_init__(self, copy: bool) -> None:
        if not len(self.starts):
            self._set(starts=np.zeros(self.count))
        if copy:
            arrays = {name: value for name, value in vars(self).items() if np.ndim(value)}
            self._set(**{name: array.copy() for name, array in arrays.items()})

    @classmethod
    def at_vertices(cls, vertices: IntArray, n_vertices: int) -> SourcePoints:
        """Return sources at vertices.

        Parameters
        ----------
        vertices : ndarray of shape (P,), int64
        n_vertices : int
            Number N of vertices of the domain.

        Returns
        -------
        SourcePoints
        """
        count = len(vertices)
        return cls(
            np.array(vertices, dtype=np.int64),
            np.ones(count),
            np.arange(count + 1),
            n_vertices,
            np.zeros(count),
            copy=False,
        )

    @classmethod
    def together(cls, parts: Sequence[SourcePoints]) -> SourcePoints:
        """Return the points of several sets on one domain as one set.

        Parameters
        ----------
        parts : sequence of SourcePoints
            One or more.

        Returns
        -------
        SourcePoints
        """
        counts = np.concatenate([np.diff(part.begins) for part in parts])
        return cls(
            vertices=np.concatenate([part.vertices for part in parts]),
            shares=np.concatenate([part.shares for part in parts]),
            begins=np.append(0, np.cumsum(counts)),
            n_vertices=parts[0].n_vertices,
            distances=np.concatenate([part.distances for part in parts]),
            starts=np.concatenate([part.starts for part in parts]),
            front_curvatures=np.concatenate([part.curvatures for part in parts]),
            copy=False,
        )

    def moved_to(self, representatives: IntArray) -> SourcePoints:
        """Return the same sources at the representatives of their vertices.

        Parameters
        ----------
        representatives : ndarray of shape (N,), int64

        Returns
        -------
        SourcePoints
        """
        return replace(self, vertices=representatives[self.vertices], copy=False)

    @property
    def count(self) -> int:
        """Number P of points."""
        return len(self.begins) - 1

    @cached_property
    def weights(self) -> csr_array:
        """The weights as a matrix of shape (P, N), with a row per point and unsorted entries."""
        from scipy.sparse import csr_array

        entries = (self.shares, self.vertices, self.begins)
        return csr_array(entries, shape=(self.count, self.n_vertices))

    @cached_property
    def curvatures(self) -> FloatArray:
        """Curvature κ of the front at each of the vertices, of shape (nnz,); ``inf`` at a point."""
        if self.front_curvatures is not None:
            return self.front_curvatures
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.distances)

    @property
    def are_vertices(self) -> bool:
        """True if each point is at one vertex."""
        return len(self.vertices) == self.count

    @property
    def rows(self) -> IntArray:
        """The (nnz,) point that each weight belongs to."""
        return np.repeat(np.arange(self.count), np.diff(self.begins))

    def readings(self, values: FloatArray) -> FloatArray:
        """Return values at the vertices, (N,), interpolated at the points, minus their distances.

        It is the weighted mean of the values minus the distances of the vertices from the point,
        minus its offset.

        Parameters
        ----------
        values : ndarray of shape (N,), float64

        Returns
        -------
        ndarray of shape (P,), float64
        """
        shifted = self.shares * (values[self.vertices] - self.distances)
        return np.add.reduceat(shifted, self.begins[:-1]) - self.starts

    @cached_property
    def delayed(self) -> bool:
        """True if any of the points starts at a value other than 0."""
        return bool(self.starts.any())

    @property
    def radial(self) -> bool:
        """True if distance grows from 0 in circles around points, without curves or offsets."""
        return bool((self.curvatures > 0).all() and not self.delayed)

    def first_to_start(self, components: IntArray) -> BoolArray:
        """Return a mask of the points with the smallest offset in their component.

        Parameters
        ----------
        components : ndarray of shape (P,), int64
            The connected component of each point.

        Returns
        -------
        ndarray of shape (P,), bool
        """
        if not self.delayed:
            return np.ones(self.count, dtype=np.bool_)
        least = np.full(components.max() + 1, np.inf)
        np.minimum.at(least, components, self.starts)
        return np.asarray(self.starts == least[components])

    def load(self) -> tuple[IntArray, FloatArray, float]:
        """Return a unit of heat for each point, shared by the vertices around it.

        Returns
        -------
        vertices, strengths, log_scale
            Vertices, which may repeat, and the heat to add at them; logarithm of the scale of the
            result.
        """
        return self.vertices, self.shares, 0.0

    def delayed_loads(
        self, components: IntArray, decay: FloatArray
    ) -> list[tuple[IntArray, FloatArray, float]]:
        """Return loads for points with different offsets.

        Heat falls exponentially with distance, and so does the strength of a source with its
        offset. One load is enough unless offsets differ so much that floats would underflow.

        Parameters
        ----------
        components : ndarray of shape (P,), int64
            The connected component of each point; heat does not pass between components.
        decay : ndarray of shape (P,), float64
            Rate of exponential decay of heat per unit of length at each point.

        Returns
        -------
        list of tuple
            Loads in the form of :meth:`load`.
        """
        vertices, weights, _ = self.load()
        least = np.full(components.max() + 1, np.inf)
        np.minimum.at(least, components, self.starts)
        delay = (self.starts - least[components]) * decay
        layers = np.floor(delay / LOG_RANGE_OF_LAYER)
        loads = []
        for layer in np.unique(layers):
            strength = np.where(
                layers == layer, np.exp(np.minimum(layer * LOG_RANGE_OF_LAYER - delay, 0.0)), 0.0
            )
            loads.append(
                (vertices, weights * strength[self.rows], -float(layer) * LOG_RANGE_OF_LAYER)
            )
        return loads

    def components(self, discretization: Discretization) -> IntArray:
        """Return the connected component of each point.

        Parameters
        ----------
        discretization : Discretization

        Returns
        -------
        ndarray of shape (P,), int64
        """
        return discretization.components[self.first_vertices]

    @property
    def nearest_vertices(self) -> IntArray:
        """The vertex closest to each point, of shape (P,)."""
        order = np.lexsort((self.distances, self.rows))
        return np.asarray(self.vertices[order[self.begins[:-1]]])

    @property
    def first_vertices(self) -> IntArray:
        """The first vertex of each point, of shape (P,)."""
        return np.asarray(self.vertices[self.begins[:-1]])


def as_vertices(sources: Any, n_vertices: int, name: str = "sources") -> IntArray:
    """Return `sources` as a one-dimensional array of vertex indices, checked.

    Raises
    ------
    InvalidSourceError
        An empty set, a value that is not an integer, an index out of range.
    """
    if isinstance(sources, int) and not isinstance(sources, bool) and 0 <= sources < n_vertices:
        return np.array([sources], dtype=np.int64)  # the most frequent case
    check_nothing_masked(sources, name, InvalidSourceError, ADVICE_ON_MASKED_SOURCES)
    try:
        array = np.atleast_1d(np.asarray(sources))
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read as indices: {error}") from error
    if array.size == 0:
        raise InvalidSourceError(f"{name}: there are none; give at least one vertex")
    # NumPy has no integers beyond 64 bits, and keeps those of Python.
    whole = array.dtype.kind in "iu" or all(type(one) is int for one in array.flat)
    if not whole or array.ndim != 1:
        raise InvalidSourceError(
            f"{name} must be vertex indices, one integer or a one-dimensional array of integers, "
            f"not {array.dtype} of shape {np.shape(sources)}"
        )
    outside = (array < 0) | (array >= n_vertices)
    if outside.any():
        raise InvalidSourceError(
            f"{name}: vertex {array[outside][0]} does not exist; there are {n_vertices}, "
            "numbered from 0"
        )
    return np.asarray(array, dtype=np.int64)
