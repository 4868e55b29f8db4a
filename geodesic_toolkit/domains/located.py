"""Places of a domain as convex combinations of its vertices."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains.base import Domain, as_floats, as_indices
from geodesic_toolkit.errors import InvalidDomainError, InvalidSourceError

__all__ = ["Located", "check_present"]

MAX_ROUNDING_OF_WEIGHTS = 1e-9
"""Largest negative rounding error of a weight, for computed barycentric coordinates."""

MAX_ERROR_OF_SUM = 1e-6
"""Largest error of the sum of weights, which should be 1."""


@final
@dataclass(frozen=True, eq=False, init=False)
class Located(FrozenArrays):
    """Places on a domain, each between the vertices of one element, as sources or answers.

    :meth:`Domain.closest` returns it, and :meth:`GeodesicSolver.distance` takes it: places inside
    tetrahedra, on edges, in polygons.

    Parameters
    ----------
    vertices : array-like of shape (P, C)
        The C vertices of the element that contains each place; an element with fewer vertices
        repeats one.
    weights : array-like of shape (P, C)
        The weights of the vertices: not negative, with sum 1.

    Raises
    ------
    InvalidSourceError
        Other shapes, indices that are negative or not whole, weights that are not convex.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(3)
    >>> middle = gt.Located([[0, 1]], [[0.5, 0.5]])
    >>> gt.geodesic_distance(square, middle)[:2]
    array([0.25, 0.25])
    """

    vertices: IntArray
    weights: FloatArray

    def __init__(self, vertices: ArrayLike, weights: ArrayLike) -> None:
        try:
            corners = as_indices(vertices, "vertices", "place", (None, None))
            shares = as_floats(weights, "weights", corners.shape)
        except InvalidDomainError as error:
            raise InvalidSourceError(f"places: {error}") from error
        if not corners.shape[1]:
            raise InvalidSourceError("places: each must have one vertex or more")
        if corners.size and corners.min() < 0:
            bad = int(np.flatnonzero((corners < 0).any(axis=1))[0])
            raise InvalidSourceError(f"place {bad} has the vertex {corners[bad].min()}")
        convex = (shares >= -MAX_ROUNDING_OF_WEIGHTS).all(axis=1) & (
            np.abs(shares.sum(axis=1) - 1) <= MAX_ERROR_OF_SUM
        )
        if not convex.all():
            bad = int(convex.argmin())
            raise InvalidSourceError(
                f"the weights of place {bad} are not convex: {shares[bad].tolist()}; they must be "
                "finite, not negative, and have the sum 1"
            )
        self._set(vertices=corners, weights=np.maximum(shares, 0.0))

    def __len__(self) -> int:
        return len(self.vertices)

    def check_on(self, domain: Domain, name: str = "places") -> None:
        """Raise unless all vertices exist in a domain and are not missing.

        Parameters
        ----------
        domain : Domain
        name : str
            Beginning of the message.

        Raises
        ------
        InvalidSourceError
            A vertex does not exist or is missing.
        """
        used = self.vertices[self.weights > 0]
        if used.size and used.max() >= domain.n_vertices:
            raise InvalidSourceError(
                f"{name}: vertex {used.max()} does not exist; there are {domain.n_vertices}, "
                "numbered from 0"
            )
        check_present(domain, used, name)

    def positions(self, domain: Domain) -> FloatArray:
        """Return the positions of the places.

        Parameters
        ----------
        domain : Domain
            A domain with positions.

        Returns
        -------
        ndarray of shape (P, 3), float64
            In the unit of the domain.
        """
        corners = domain.positions[self.vertices]
        return np.asarray(np.einsum("pc,pcd->pd", self.weights, corners))


def check_present(domain: Domain, vertices: IntArray, name: str) -> None:
    """Raise an `InvalidSourceError` that begins with `name` if one of the vertices is missing."""
    if type(domain).present is Domain.present:
        return  # all vertices; the default costs 25 µs of a source
    is_present = domain.present[vertices]
    if not is_present.all():
        raise InvalidSourceError(
            f"{name}: {domain.vertex_name} {vertices[~is_present][0]} of the "
            f"{type(domain).__name__} is missing (not finite)"
        )
