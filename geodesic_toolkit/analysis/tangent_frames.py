"""Tangent frames of the vertices, for vectors in coordinates."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver

__all__ = ["TangentFrames", "tangent_frames"]


@final
@dataclass(frozen=True, eq=False)
class TangentFrames(FrozenArrays):
    """A tangent plane with two axes at every vertex.

    Attributes
    ----------
    normals : ndarray of shape (N, 3), float64
        Of length 1; out of closed surfaces, and to the side from which faces run counterclockwise.
    x_axes, y_axes : ndarray of shape (N, 3), float64
        Of length 1; at a right angle to each other and to the normals, y_axes = normals × x_axes.
    """

    normals: FloatArray
    x_axes: FloatArray
    y_axes: FloatArray

    def __post_init__(self) -> None:
        for value in self.__dict__.values():
            freeze(value)

    def to_space(self, coordinates: ArrayLike) -> FloatArray:
        """Return vectors in space from their coordinates in the frames.

        Parameters
        ----------
        coordinates : array-like of shape (N, 2)

        Returns
        -------
        ndarray of shape (N, 3), float64

        Raises
        ------
        InvalidOptionError
            Coordinates of another shape.
        """
        given = _table(coordinates, (len(self.normals), 2), "coordinates")
        return np.asarray(given[:, :1] * self.x_axes + given[:, 1:] * self.y_axes)

    def to_frame(self, vectors: ArrayLike) -> FloatArray:
        """Return the coordinates in the frames of vectors in space, without the normal part.

        Parameters
        ----------
        vectors : array-like of shape (N, 3)

        Returns
        -------
        ndarray of shape (N, 2), float64

        Raises
        ------
        InvalidOptionError
            Another shape.
        """
        given = _table(vectors, self.normals.shape, "vectors")
        return np.stack(
            [np.einsum("nd,nd->n", given, axes) for axes in (self.x_axes, self.y_axes)], axis=1
        )


def tangent_frames(solver: GeodesicSolver) -> TangentFrames:
    """Return the tangent frames at the vertices of a solver's domain.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a point cloud.

    Returns
    -------
    TangentFrames

    Raises
    ------
    InvalidOptionError
        An argument that is not a solver.
    UnsupportedDomainError
        A graph, as an edge has no angle; a surface with one side.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> frames = gt.tangent_frames(gt.GeodesicSolver(gt.testing.shapes.grid(3)))
    >>> frames.to_frame(frames.to_space([[1.0, 2.0]] * 9))[4].round(12)
    array([1., 2.])
    """
    check_solver(solver, "tangent_frames")
    frames = solver.frames
    return TangentFrames(frames.normals, frames.x_axes, frames.y_axes)


def _table(values: ArrayLike, shape: tuple[int, ...], name: str) -> FloatArray:
    table = real_numbers(values, name)
    if table.shape != shape:
        raise InvalidOptionError(f"{name} must have shape {shape}, not {table.shape}")
    return table
