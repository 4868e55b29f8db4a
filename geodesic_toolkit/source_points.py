"""Sources as convex combinations of vertices: what the heat method starts from."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.errors import InvalidSourceError

__all__ = ["SourcePoints", "as_vertices"]

LAYER = 200.0
"""Powers of e between the sources of one right-hand side; float64 has 700."""


@dataclass(frozen=True)
class SourcePoints:
    """A set of sources as convex combinations of vertices.

    Attributes
    ----------
    weights : csr_array of shape (P, N)
        One row a point: its barycentric weights on the vertices around it.
    distances : ndarray of shape (nnz,), float64
        How far the point is from each of those vertices, in the order of ``weights.data``; 0 for a
        point at a vertex.
    starts : ndarray of shape (P,), float64, optional
        The distance that each point starts with; 0 unless given.
    curvatures : ndarray of shape (nnz,), float64, optional
        Geodesic curvature κ of the front when it comes to those vertices; that of a circle about
        the point, ``1 / distances``, unless given.
    """

    weights: csr_array
    distances: FloatArray
    starts: FloatArray = field(default_factory=lambda: np.zeros(0))
    curvatures: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if not len(self.starts):
            object.__setattr__(self, "starts", np.zeros(self.weights.shape[0]))
        if not len(self.curvatures):
            with np.errstate(divide="ignore"):
                object.__setattr__(self, "curvatures", 1 / self.distances)

    @classmethod
    def at_vertices(cls, vertices: IntArray, n_vertices: int) -> "SourcePoints":
        """Return sources at vertices."""
        count = len(vertices)
        entries = (np.ones(count), vertices, np.arange(count + 1))
        return cls(csr_array(entries, shape=(count, n_vertices)), np.zeros(count))

    @property
    def rows(self) -> IntArray:
        """The (nnz,) point that each weight belongs to."""
        return np.repeat(np.arange(self.weights.shape[0]), np.diff(self.weights.indptr))

    def readings(self, values: FloatArray) -> FloatArray:
        """Return what values at the vertices, (N,), are in the points, less what they begin with.

        That is their weighted mean, less how far the vertices are from the point, and its start.
        """
        above = self.weights.data * (values[self.weights.indices] - self.distances)
        return np.bincount(self.rows, above, self.weights.shape[0]) - self.starts

    @property
    def radial(self) -> bool:
        """Whether distance grows from 0 in circles about the points: no curve, no head starts."""
        return bool((self.curvatures > 0).all() and not self.starts.any())

    def first_to_start(self, components: IntArray) -> BoolArray:
        """Return the points of which none in the same component starts earlier, of shape (P,).

        Parameters
        ----------
        components : ndarray of shape (P,), int64
        """
        least = np.full(components.max() + 1, np.inf)
        np.minimum.at(least, components, self.starts)
        return np.asarray(self.starts == least[components])

    def load(self) -> tuple[IntArray, FloatArray, float]:
        """Return a unit of heat for each point, shared by the vertices around it.

        Returns
        -------
        vertices, strengths, log_scale
            What to add where, with repeated vertices; the logarithm of what to scale its heat by.
        """
        vertices = np.asarray(self.weights.indices, dtype=np.int64)
        return vertices, np.asarray(self.weights.data, dtype=np.float64), 0.0

    def delayed_loads(
        self, components: IntArray, decay: FloatArray
    ) -> list[tuple[IntArray, FloatArray, float]]:
        """Return such loads for points that start later than others.

        Heat falls exponentially: a source that starts later is weaker by that. One load serves
        unless starts differ by so much that floats would underflow.

        Parameters
        ----------
        components : ndarray of shape (P,), int64
            The connected component that each point lies in; they do not hear of one another.
        decay : ndarray of shape (P,), float64
            Powers of e by which heat falls in a unit of length there.
        """
        vertices, weights, _ = self.load()
        least = np.full(components.max() + 1, np.inf)
        np.minimum.at(least, components, self.starts)
        delay = (self.starts - least[components]) * decay
        layers = np.floor(delay / LAYER)
        loads = []
        for layer in np.unique(layers):
            strength = np.where(
                layers == layer, np.exp(np.minimum(layer * LAYER - delay, 0.0)), 0.0
            )
            loads.append((vertices, weights * strength[self.rows], -float(layer) * LAYER))
        return loads

    def components(self, discretization: Discretization) -> IntArray:
        """Return the connected component that each point lies in, of shape (P,)."""
        return discretization.components[self.first_vertices]

    @property
    def first_vertices(self) -> IntArray:
        """The (P,) first of the vertices around each point."""
        return np.asarray(self.weights.indices[self.weights.indptr[:-1]])


def as_vertices(sources: Any, n_vertices: int, name: str = "sources") -> IntArray:
    """Return `sources` as a one-dimensional array of vertex indices, checked.

    Raises
    ------
    InvalidSourceError
        None at all, something that is not an integer, an index out of range.
    """
    try:
        array = np.atleast_1d(np.asarray(sources))
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read as indices: {error}") from error
    if array.size == 0:
        raise InvalidSourceError(f"{name}: there are none; give at least one vertex")
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise InvalidSourceError(
            f"{name} must be vertex indices, one integer or a one-dimensional array of them, "
            f"not {array.dtype} of shape {np.shape(sources)}"
        )
    outside = (array < 0) | (array >= n_vertices)
    if outside.any():
        raise InvalidSourceError(
            f"{name}: vertex {array[outside][0]} does not exist; there are {n_vertices}, "
            "numbered from 0"
        )
    return np.asarray(array, dtype=np.int64)
