"""The place of a shape that a ray from the camera meets first."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.viz.scene import Scene

__all__ = ["Picker"]

LARGE = 4.0
"""Edges of a large face are longer than so many median ones. Other faces are found from their
corners; large ones, which are few, are all tested."""

TOLERANCE_OF_EDGES = 1e-9
"""Share of a face by which a ray may miss it: a ray through an edge meets one of its faces."""

TOLERANCE_OF_POINTS = 0.01
"""Radius around the ray in which points are met, in coordinates where the shape has radius 1; more
where points are drawn larger."""

SHARE_OF_SPACING = 0.9
"""Radius, in mean distances of neighbours, in which points are met where none is closer to the ray:
between the points of a grid, whose middles are 0.71 away in a plane and 0.87 in space."""


class Picker:
    """The places of one scene that rays meet, in the scene's coordinates.

    Faces are found in their projection along the ray: a ray through an edge or a corner meets one
    of the faces there, which trees of boxes do not promise.

    Parameters
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self._points = scene.points
        self._quick = scene.points.astype(np.float32)
        self._present = scene.present
        self._radii: tuple[float, ...] = ()
        if scene.faces is None:
            self._radii = (
                max(TOLERANCE_OF_POINTS, 1.5 * scene.ball),
                SHARE_OF_SPACING * scene.spacing,
            )
        self._faces = scene.faces
        if scene.faces is not None:
            self._sort_faces(scene.faces)

    def _sort_faces(self, faces: IntArray) -> None:
        corners = self._quick[faces]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        limit = LARGE * float(np.median(longest)) if len(faces) else 0.0
        self._large = np.flatnonzero(longest > limit)
        small = np.flatnonzero(longest <= limit)
        # No point of a triangle is farther from all corners than 1/sqrt(3) of the longest side.
        self._reach = 0.58 * limit
        vertices = faces[small].ravel()
        self._around = np.repeat(small, 3)[np.argsort(vertices, kind="stable")]
        self._starts = np.zeros(len(self._points) + 1, dtype=np.int64)
        np.cumsum(np.bincount(vertices, minlength=len(self._points)), out=self._starts[1:])

    def pick(
        self, origin: FloatArray, direction: FloatArray, hidden: BoolArray | None = None
    ) -> tuple[IntArray, FloatArray] | None:
        """Return the vertices and weights of the place that a ray meets first, or None.

        Parameters
        ----------
        origin, direction : ndarray of shape (3,)
        hidden : ndarray of shape (N,), bool, optional
            Vertices that a ray passes, with their faces.

        Returns
        -------
        vertices : ndarray of shape (C,), int64
            The corners of a face; or one point, where there are no faces.
        weights : ndarray of shape (C,), float64
            Not negative, with sum 1.
        """
        length = float(np.linalg.norm(direction))
        if not (np.isfinite(origin).all() and np.isfinite(length) and length > 0):
            return None
        ahead = direction / length
        if self._faces is None:
            return self._nearest_point(origin, ahead, hidden)
        return self._first_face(origin, ahead, hidden)

    def _nearest_point(
        self, origin: FloatArray, ahead: FloatArray, hidden: BoolArray | None
    ) -> tuple[IntArray, FloatArray] | None:
        offset = self._points - origin
        depth = offset @ ahead
        squared = np.einsum("nd,nd->n", offset, offset) - depth**2
        ahead_of_it = (depth > 0) & self._present
        if hidden is not None:
            ahead_of_it &= ~hidden
        for radius in self._radii:
            met = np.flatnonzero(ahead_of_it & (squared < radius**2))
            if len(met):
                return met[[np.argmin(depth[met])]], np.ones(1)
        return None

    def _first_face(
        self, origin: FloatArray, ahead: FloatArray, hidden: BoolArray | None
    ) -> tuple[IntArray, FloatArray] | None:
        assert self._faces is not None
        across = _across(ahead)
        flat = self._quick @ across.astype(np.float32) - (origin @ across).astype(np.float32)
        met = np.flatnonzero(np.einsum("nd,nd->n", flat, flat) <= self._reach**2)
        runs = [self._around[self._starts[v] : self._starts[v + 1]] for v in met.tolist()]
        faces = self._faces[np.unique(np.concatenate([self._large, *runs]))]
        if hidden is not None:
            faces = faces[~hidden[faces].any(axis=1)]
        corners = self._points[faces] - origin
        x, y = np.moveaxis(corners @ across, 2, 0)
        areas = np.roll(x, -1, axis=1) * np.roll(y, 1, axis=1)
        areas -= np.roll(x, 1, axis=1) * np.roll(y, -1, axis=1)
        total = areas.sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):  # faces that are seen from their side
            weights = areas / total[:, None]
            inside = (weights >= -TOLERANCE_OF_EDGES).all(axis=1) & (total != 0)
        inside = np.flatnonzero(inside)
        depth = np.einsum("fc,fc->f", weights[inside], corners[inside] @ ahead)
        inside, depth = inside[depth > 0], depth[depth > 0]
        if len(inside) == 0:
            return None
        first = inside[np.argmin(depth)]
        shares = np.maximum(weights[first], 0.0)
        return faces[first], shares / shares.sum()


def _across(ahead: FloatArray) -> FloatArray:
    """Return two unit vectors across a direction, and across each other, as columns."""
    one = np.cross(ahead, np.eye(3)[np.argmin(np.abs(ahead))])
    one /= np.linalg.norm(one)
    return np.column_stack([one, np.cross(ahead, one)])
