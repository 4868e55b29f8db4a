"""The data of a picture: a domain, a value at each vertex, the positions of the sources.

They do not depend on a graphics package, so that picture, HTML and desktop show the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, graph_of, positions_of, triangles_of
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.sources.polylines import polylines
from geodesic_toolkit.viz.arrows import spread_arrows
from geodesic_toolkit.viz.checkers import Checkers

__all__ = ["Scene", "compacted", "make_scene"]

MOST_IMPLICIT_SOURCES = 100
"""Largest number of zeros that are marked as sources; a field with more has a flat part."""


@dataclass(frozen=True)
class Scene:
    """A field on a shape, in coordinates where the shape has its centre at 0 and radius near 1.

    Large coordinates and tiny models therefore do not exceed single precision, and the sizes of
    markers need no scale.

    Attributes
    ----------
    points : ndarray of shape (N, 3)
        Positions in these coordinates; 0 if a point is missing.
    present : ndarray of shape (N,), bool
        The points to show.
    faces : ndarray of shape (F, 3)
        None if there are no triangles, as in clouds and graphs.
    edges : ndarray of shape (E, 2)
        The edges if there are no triangles, as in graphs.
    values : ndarray of shape (N,)
        NaN at vertices without a value.
    limits : (float, float)
        Ends of the colour map.
    sources : ndarray of shape (S, 3)
        Positions of the sources in these coordinates.
    curves : tuple of ndarray of shape (P, 3)
        Polylines in the frame; of closed ones the last point is the first.
    arrows : (ndarray of shape (A, 3), ndarray of shape (A, 3))
        Positions and vectors of arrows in these coordinates.
    checkers : Checkers, optional
        The pattern of the faces.
    centre : ndarray of shape (3,)
    radius : float
        ``points * radius + centre`` are the positions in the domain.
    """

    points: FloatArray
    present: BoolArray
    faces: IntArray | None
    edges: IntArray | None
    values: FloatArray
    limits: tuple[float, float]
    sources: FloatArray
    curves: tuple[FloatArray, ...]
    arrows: tuple[FloatArray, FloatArray]
    checkers: Checkers | None
    centre: FloatArray
    radius: float

    @property
    def reached(self) -> BoolArray:
        """Mask of the vertices with a value."""
        return np.isfinite(self.values)

    @property
    def face_reached(self) -> BoolArray:
        """Mask of the faces with a value at every corner."""
        assert self.faces is not None
        return np.asarray(self.reached[self.faces].all(axis=1))

    @property
    def ball(self) -> float:
        """Radius of a drawn point: neighbours overlap; on a graph they do not."""
        return float(np.clip((1.1 if self.edges is None else 0.3) * self.spacing, 0.003, 0.04))

    @property
    def band(self) -> float:
        """The distance from a level within which points are dark: one or two rows of points."""
        return 0.5 * self.spacing * self.radius

    @cached_property
    def spacing(self) -> float:
        """Typical distance of neighbouring points, in the scene's coordinates."""
        from scipy.spatial import cKDTree

        shown = self.points[self.present]
        if len(shown) < 2:
            return 1.0
        step = max(1, len(shown) // 5000)  # a sample is enough
        gaps = np.asarray(cKDTree(shown).query(shown[::step], k=min(5, len(shown)))[0])
        positive = gaps[gaps > 0]  # repeated points have no spacing
        return float(np.quantile(positive, 0.75)) if len(positive) else 1.0


def make_scene(
    domain: Domain,
    values: ArrayLike,
    *,
    sources: Any = None,
    curves: Any = (),
    positions: ArrayLike | None = None,
    limits: Sequence[float] | None = None,
    arrows: ArrayLike | None = None,
    checkers: Checkers | None = None,
) -> Scene:
    """Return the scene of a domain and its values.

    Parameters
    ----------
    domain : Domain
    values : array-like of shape (N,)
        The distance, or any other number per vertex; not finite where it has no value.
    sources : optional
        As :meth:`GeodesicSolver.distance` takes them. By default the places where the value is
        exactly 0, if they are few; an empty list marks none.
    curves : Curve, GeodesicPath, CloudPath, or sequence of them
        Lines to draw.
    positions : array-like of shape (N, 3), optional
        Positions at which the vertices of a graph are drawn.
    limits : pair of float, optional
        Ends of the colour map; the extremes of the values by default.
    arrows : array-like of shape (N, 3), optional
    checkers : Checkers, optional

    Returns
    -------
    Scene

    Raises
    ------
    UnsupportedDomainError
        The domain has no positions, and none were given.
    InvalidOptionError
        Values, positions, arrows or checkers that do not fit the domain, limits that are not an
        interval.
    InvalidSourceError
        Sources or curves that name no place.
    """
    points = _positions(domain, positions)
    field = _field(domain, values)
    faces = edges = None
    if domain.has("triangles"):
        faces = triangles_of(domain)
        faces = faces[proper_faces(faces)]
    elif domain.has("as_graph"):
        edges = graph_of(domain).edges
    finite: BoolArray = np.asarray(np.isfinite(points).all(axis=1) & domain.present)
    present = finite.copy()
    if faces is not None:
        used = np.zeros(len(points), dtype=np.bool_)
        used[faces] = True
        present &= used if used.any() else True
    low, high = points[present].min(axis=0), points[present].max(axis=0)
    centre = low + (high - low) / 2
    radius = float(np.linalg.norm((high - low) / 2)) or 1.0
    framed = (np.where(finite[:, None], points, centre) - centre) / radius
    _check_checkers(checkers, domain)
    return Scene(
        points=framed,
        present=present,
        faces=faces,
        edges=edges,
        values=field,
        limits=_limits(field[present], limits),
        sources=_source_positions(domain, sources, framed, field, finite=finite, present=present),
        curves=tuple((line - centre) / radius for line in polylines(domain, curves)),
        arrows=spread_arrows(framed, present, np.zeros_like(framed) if arrows is None else arrows),
        checkers=checkers,
        centre=centre,
        radius=radius,
    )


def compacted(rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return the points that faces or edges use, and the rows as indices into them.

    Examples
    --------
    >>> compacted(np.array([[7, 2, 4]]))
    (array([2, 4, 7]), array([[2, 0, 1]]))
    """
    used, own = np.unique(rows, return_inverse=True)
    return used, np.asarray(own, dtype=np.int64).reshape(rows.shape)


def _check_checkers(checkers: Checkers | None, domain: Domain) -> None:
    if checkers is None:
        return
    if not isinstance(checkers, Checkers):
        raise InvalidOptionError(f"checkers must be gt.viz.Checkers, not {checkers!r}")
    if len(checkers.coordinates) != domain.n_vertices:
        raise InvalidOptionError(
            f"checkers of {len(checkers.coordinates)} vertices do not fit {domain!r}"
        )


def _positions(domain: Domain, positions: ArrayLike | None) -> FloatArray:
    if positions is not None:
        given = real_numbers(positions, "positions")
        if given.shape == (domain.n_vertices, 2):
            given = np.column_stack([given, np.zeros(len(given))])
        if given.shape != (domain.n_vertices, 3) or not np.isfinite(given).any(axis=0).all():
            raise InvalidOptionError(
                f"positions must have shape ({domain.n_vertices}, 3), one finite point per vertex, "
                f"not {given.shape}"
            )
        return given
    if isinstance(domain, Domain) and domain.has("positions"):
        return positions_of(domain)
    raise UnsupportedDomainError(
        f"{a_kind_of(domain)} has no positions to draw; pass positions=, an array of shape "
        f"({domain.n_vertices}, 3), from a layout of your choice"
        if isinstance(domain, Domain)
        else f"only domains can be drawn, not {a_kind_of(domain)}"
    )


def _field(domain: Domain, values: ArrayLike) -> FloatArray:
    field = real_numbers(values, "distance").copy()
    if field.shape != (domain.n_vertices,):
        raise InvalidOptionError(
            f"the distance must have shape ({domain.n_vertices},), one number per vertex, "
            f"not {field.shape}"
        )
    field[~np.isfinite(field)] = np.nan
    return field


def _limits(field: FloatArray, limits: Sequence[float] | None) -> tuple[float, float]:
    if limits is not None:
        try:
            low, high = (float(end) for end in limits)
        except (TypeError, ValueError) as error:
            raise InvalidOptionError(f"limits must be two numbers, not {limits!r}") from error
        if not (np.isfinite([low, high]).all() and low < high):
            raise InvalidOptionError(f"limits must be finite and increasing, not {limits!r}")
        return low, high
    finite = field[np.isfinite(field)]
    if len(finite) == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return (low, high) if low < high else (low, low + (abs(low) or 1.0))


def _source_positions(
    domain: Domain,
    sources: Any,
    framed: FloatArray,
    field: FloatArray,
    *,
    finite: BoolArray,
    present: BoolArray,
) -> FloatArray:
    if sources is None:
        zeros = np.flatnonzero((field == 0) & present)
        return framed[zeros if len(zeros) <= MOST_IMPLICIT_SOURCES else zeros[:0]]
    if (
        isinstance(sources, list | tuple | np.ndarray)
        and len(np.atleast_1d(np.asarray(sources, dtype=object))) == 0
    ):
        return np.zeros((0, 3))
    weights = locate_sources(domain, sources).weights
    points_of_sources: FloatArray = weights @ framed
    somewhere = weights @ (~finite).astype(np.float64) == 0
    return np.asarray(points_of_sources[somewhere])
