"""Paths through places in order: chains of edges that are pulled taut."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.candidates import Candidate
from geodesic_toolkit.analysis.paths.fronts import one_place
from geodesic_toolkit.analysis.paths.insertion import insert_points
from geodesic_toolkit.analysis.paths.metric.paths import path_on_metric, pulled_through
from geodesic_toolkit.analysis.paths.path import (
    GeodesicPath,
    closed_path,
    joined_pieces,
    path_from_candidate,
)
from geodesic_toolkit.analysis.paths.prepared import prepared_mesh
from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.kinds import Curve, OffsetSources
from geodesic_toolkit.sources.points import SourcePoints

__all__ = [
    "Course",
    "check_length",
    "located_places",
    "located_stops",
    "mesh_to_pull_over",
    "passable_faces",
    "path_through",
    "pieces_between",
    "unreachable_error",
]


SAME_SHARES = 1e-8
"""Difference of barycentric weights, all together, within which two places are one."""


@dataclass(frozen=True)
class Course:
    """Options of a path through stops.

    Parameters
    ----------
    closed : bool
        On from the last to the first.
    held : bool
        Through them, rather than pulled away from them.
    min_length : float
        A closed path that is not held, and is shorter, counts as a point.
    """

    closed: bool = False
    held: bool = False
    min_length: float = 0.0


def located_stops(
    solver: GeodesicSolver, places: Iterable[tuple[Any, str]], *, closed: bool = False
) -> SourcePoints:
    """Return places of a mesh in order, from one or several groups that errors call by names.

    Raises
    ------
    UnsupportedDomainError
        Not on a mesh.
    InvalidSourceError
        Places that are none, too few, or twice the same in a row.
    """
    if not isinstance(solver.domain, MeasuredFaces):
        mesh_to_pull_over(solver)
    groups = []
    for given, name in places:
        groups.append(located_places(solver, given, name))
        if name in {"source", "target"} and groups[-1].count != 1:
            raise InvalidSourceError(
                f"{name}: a path via places has one {name}, not {groups[-1].count}"
            )
    stops = _concatenated(groups)
    least = 3 if closed else 2
    if stops.count < least:
        what = "three places or more say which way around" if closed else "two places or more"
        raise InvalidSourceError(f"way points: {what}, not {stops.count}")
    _check_steps(stops, closed=closed)
    return stops


def mesh_to_pull_over(solver: GeodesicSolver) -> TriangleMesh:
    """Return the mesh of a solver, or raise that paths through places need one."""
    if not isinstance(solver.domain, TriangleMesh):
        raise UnsupportedDomainError(
            "loops and paths through places need a triangle mesh; "
            f"{a_kind_of(solver.domain)} has no surface to pull them over"
        )
    return solver.domain


def located_places(solver: GeodesicSolver, given: Any, name: str) -> SourcePoints:
    """Return located places, or raise where something else is given than places."""
    if isinstance(given, Curve | OffsetSources):
        raise InvalidSourceError(
            f"{name}: a path runs through places, not through {a_kind_of(given)}"
        )
    return solver.locate(given, name)


def path_through(
    solver: GeodesicSolver, stops: SourcePoints, course: Course
) -> GeodesicPath | None:
    """Return the geodesic to which the shortest path along edges through stops is pulled.

    None where a closed one shrinks to a point, or to less than the course's least length.

    Raises
    ------
    UnreachableError
        No face connects a stop with the next.
    UnsupportedDomainError
        A closed one that is not held, where the mesh has costs or edge lengths.
    """
    if isinstance(solver.domain, MeasuredFaces):
        return _path_over_metric(solver, solver.domain, stops, course)
    mesh = mesh_to_pull_over(solver)
    original = passable_faces(solver, mesh)
    split = insert_points(mesh.vertices, mesh.faces[original], stops.weights)
    (faces, ends, shares), unreached = _native.geodesic_through(
        np.ascontiguousarray(split.vertices),
        np.ascontiguousarray(split.faces),
        split.vertex_of_point,
        closed=course.closed,
        held=course.held,
        min_length=course.min_length,
    )
    if unreached >= 0:
        raise _unreached(solver, unreached, stops.count)
    if not len(faces):
        return None
    way = Candidate(faces, ends, np.column_stack([1 - shares, shares]))
    path = path_from_candidate(mesh, original, split, way)
    if not course.closed:
        return path
    return closed_path(path)


def _path_over_metric(
    solver: GeodesicSolver, mesh: MeasuredFaces, stops: SourcePoints, course: Course
) -> GeodesicPath:
    """Return the path through stops on a mesh that has lengths of its own."""
    prepared = prepared_mesh(solver)
    if course.closed and not course.held:
        raise UnsupportedDomainError(
            f"a loop is not pulled taut on {a_kind_of(mesh)}; give through=True for shortest paths "
            "from each place to the next"
        )
    if not course.held:
        places = [one_place(stops, index) for index in range(stops.count)]
        pulled = pulled_through(prepared, places)
        if isinstance(pulled, int):
            raise _unreached(solver, pulled, stops.count)
        return pulled
    pieces = pieces_between(stops, partial(path_on_metric, prepared), closed=course.closed)
    if isinstance(pieces, int):
        raise _unreached(solver, pieces, stops.count)
    return joined_pieces(mesh, pieces, closed=course.closed)


def pieces_between(
    stops: SourcePoints,
    path_between: Callable[[SourcePoints, SourcePoints], GeodesicPath | None],
    *,
    closed: bool,
) -> list[GeodesicPath] | int:
    """Return the paths from each stop to the next, or the number of one that is not reached."""
    order: list[int] = [*range(stops.count), *([0] if closed else [])]
    pieces: list[GeodesicPath] = []
    for here, there in pairwise(order):
        piece = path_between(one_place(stops, here), one_place(stops, there))
        if piece is None:
            return there
        pieces.append(piece)
    return pieces


def _unreached(solver: GeodesicSolver, place: int, count: int) -> UnreachableError:
    return unreachable_error(solver, f"place {place} with place {(place - 1) % count}")


def check_length(length: object, name: str) -> None:
    """Raise where an option is not a finite length."""
    if isinstance(length, bool) or not isinstance(length, int | float):
        raise InvalidOptionError(f"{name} is a length, not {length!r}")
    if not (length >= 0 and math.isfinite(length)):
        raise InvalidOptionError(f"{name} must be finite and not negative, not {length!r}")


def unreachable_error(solver: GeodesicSolver, what: str) -> UnreachableError:
    """Return the error that says what no face connects, with the cure for seams."""
    seams = f". {solver.seams.finding}; {solver.seams.cure}" if solver.seams else ""
    return UnreachableError(
        f"no face connects {what}; they lie in different components of the mesh, in no face, or "
        f"behind masked vertices{seams}"
    )


def passable_faces(solver: GeodesicSolver, mesh: TriangleMesh) -> IntArray:
    """Return the proper faces that touch no masked vertex."""
    conducting = proper_faces(mesh.faces)
    passable = solver.passable
    if passable is not mesh and isinstance(passable, TriangleMesh):
        conducting &= passable.used[mesh.faces].all(axis=1)
    return np.flatnonzero(conducting)


def _concatenated(groups: list[SourcePoints]) -> SourcePoints:
    counts = np.concatenate([np.diff(group.begins) for group in groups])
    return SourcePoints(
        vertices=np.concatenate([group.vertices for group in groups]),
        shares=np.concatenate([group.shares for group in groups]),
        begins=np.concatenate([[0], np.cumsum(counts)]),
        n_vertices=groups[0].n_vertices,
        distances=np.concatenate([group.distances for group in groups]),
        copy=False,
    )


def _check_steps(stops: SourcePoints, *, closed: bool) -> None:
    """Raise where a place is the one before it."""
    parts = [slice(*pair) for pair in pairwise(stops.begins.tolist())]
    points = [
        dict(zip(stops.vertices[part].tolist(), stops.shares[part].tolist(), strict=True))
        for part in parts
    ]
    for index in range(0 if closed else 1, stops.count):
        here, last = points[index], points[index - 1]
        step = [here.get(vertex, 0.0) - last.get(vertex, 0.0) for vertex in {*here, *last}]
        if sum(map(abs, step)) <= SAME_SHARES:
            before = (index - 1) % stops.count
            cure = "; a closed path joins the last to the first by itself" if index == 0 else ""
            raise InvalidSourceError(
                f"way points: place {index} is place {before} again; leave one of them out{cure}"
            )
