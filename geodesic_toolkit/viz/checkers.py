"""Checkerboards in the coordinates of a logarithmic map, as textures of a surface."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["Checkers"]

SIDE_OF_TEXTURE = 2048
"""Width and height of the texture in pixels, which all renderers accept."""

MAX_STRETCH_OF_EDGES = 4.0
"""Ratio of the length of an edge in the coordinates to that in space above which the map jumps."""

N_CELLS = 16
"""Number of cells along the longest logarithm, unless their size is given."""

SHARE_OF_COLOUR = 0.4
"""Share of colour in every second cell; the rest is white, as darker cells near a source, where the
default map is dark, would be black."""


@final
@dataclass(frozen=True, eq=False, init=False)
class Checkers(FrozenArrays):
    """A checkerboard in tangent coordinates, which :func:`plot` draws on a mesh or a point cloud.

    Faces with corners that are more than a cell apart in these coordinates, and more than four
    times as far as in space, have no pattern: the cut locus of the source, where the
    logarithmic map jumps, passes through them.

    Parameters
    ----------
    coordinates : array-like of shape (N, 2)
        The ``coordinates`` of a :class:`~geodesic_toolkit.LogMap`; not finite where there are none.
    size : float, optional
        Side of a square, or width of a ring, in the unit of the coordinates. By default the longest
        coordinates are 16 cells long.
    sectors : int
        Number of sectors of a polar pattern, even and at least 2; 0 for squares.

    Raises
    ------
    InvalidOptionError
        Coordinates of another shape, none of them finite; a size that is not positive; an odd or
        negative number of sectors.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(5)
    >>> checkers = gt.viz.Checkers(square.vertices[:, :2] - 0.5, size=0.25)
    >>> gt.viz.plot(square, square.vertices[:, 0], checkers=checkers, size=(200, 100)).shape
    (100, 200, 3)
    """

    coordinates: FloatArray
    size: float
    sectors: int

    def __init__(
        self, coordinates: ArrayLike, *, size: float | None = None, sectors: int = 24
    ) -> None:
        try:
            table = np.array(coordinates, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidOptionError(f"coordinates cannot be read: {error}") from error
        if table.ndim != 2 or table.shape[1] != 2:
            raise InvalidOptionError(f"coordinates must have shape (N, 2), not {table.shape}")
        radii = np.hypot(*table.T)
        largest = float(radii[np.isfinite(radii)].max(initial=0.0))
        if largest == 0:
            raise InvalidOptionError("coordinates must be finite and not 0 at one vertex or more")
        own = largest / N_CELLS if size is None else float(size)
        if not (0 < own < np.inf):
            raise InvalidOptionError(f"size must be positive and finite, not {size!r}")
        if isinstance(sectors, bool) or sectors not in range(0, 10_000, 2):
            raise InvalidOptionError(f"sectors must be an even number, or 0, not {sectors!r}")
        object.__setattr__(self, "coordinates", freeze(table))
        object.__setattr__(self, "size", own)
        object.__setattr__(self, "sectors", int(sectors))

    @property
    def radius(self) -> float:
        """Length of the longest coordinates."""
        radii = np.hypot(*self.coordinates.T)
        return float(radii[np.isfinite(radii)].max())

    def patterned(self, points: FloatArray, faces: IntArray) -> BoolArray:
        """Return a mask of the faces that the pattern covers.

        Parameters
        ----------
        points : ndarray of shape (N, 3), float64
            Positions in space.
        faces : ndarray of shape (F, 3), int64

        Returns
        -------
        ndarray of shape (F,), bool
        """
        sides, edges = (
            np.linalg.norm(table[faces] - np.roll(table[faces], 1, axis=1), axis=2)
            for table in (self.coordinates, points)
        )
        allowed = np.maximum(self.size, MAX_STRETCH_OF_EDGES * edges)
        return np.asarray((sides <= allowed).all(axis=1))  # NaN is not

    def texture(self, table: FloatArray, limits: tuple[float, float]) -> NDArray[np.uint8]:
        """Return the texture, of shape (S, S, 3), coloured by distance from its centre.

        Parameters
        ----------
        table : ndarray of shape (n, 3), float64
            Colours from the first limit to the second.
        limits : (float, float)

        Returns
        -------
        ndarray of shape (S, S, 3), uint8
        """
        axis = (np.arange(SIDE_OF_TEXTURE) + 0.5) / SIDE_OF_TEXTURE * 2 - 1
        x, y = self.radius * axis[None, :], self.radius * axis[::-1, None]
        radii = np.hypot(x, y)
        place = np.clip((radii - limits[0]) / (limits[1] - limits[0]), 0.0, 1.0)
        colours = table[np.round(place * (len(table) - 1)).astype(np.int64)]
        own = 1 - self._shares(x, y) * (1 - colours)
        return np.asarray(np.round(255 * own), dtype=np.uint8)

    def shares(self) -> FloatArray:
        """Return the share of colour, the rest being white, at each vertex, of shape (N, 1)."""
        return self._shares(*np.nan_to_num(self.coordinates).T)

    def _shares(self, x: FloatArray, y: FloatArray) -> FloatArray:
        if self.sectors:
            cells = np.floor(np.hypot(x, y) / self.size)
            cells = cells + np.floor(np.arctan2(y, x) * self.sectors / (2 * np.pi))
        else:
            cells = np.floor(x / self.size) + np.floor(y / self.size)
        return np.where(cells % 2 == 0, 1.0, SHARE_OF_COLOUR)[..., None]

    def texture_coordinates(self) -> FloatArray:
        """Return the place of each vertex in the texture, of shape (N, 2), from 0 to 1."""
        return np.asarray(np.nan_to_num(self.coordinates) / (2 * self.radius) + 0.5)
