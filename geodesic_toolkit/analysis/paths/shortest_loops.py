"""The shortest loop around a handle or a hole."""

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.candidates import Candidate
from geodesic_toolkit.analysis.paths.chains import (
    check_length,
    located_places,
    mesh_to_pull_over,
    passable_faces,
    unreachable_error,
)
from geodesic_toolkit.analysis.paths.insertion import Insertion, insert_points
from geodesic_toolkit.analysis.paths.path import GeodesicPath, closed_path, path_from_candidate
from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import (
    ContractibleLoopError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver

__all__ = ["shortest_loop"]

CURES_WITHOUT_LOOPS = (
    "for the girth of a limb, mask the vertices at both of its ends, GeodesicSolver(mesh, "
    "mask=...), which makes holes of them; or give places around it to geodesic_loop(..., "
    "through=True); or measure an isoline of a distance along it, isolines and curve_length"
)
"""Advice in the error of surfaces without loops."""


def shortest_loop(solver: GeodesicSolver, at: Any = None, *, min_hole: float = 0.0) -> GeodesicPath:
    """Return the shortest loop on a mesh that does not shrink to a point: its girth.

    The loop goes around a handle or a hole: of the whole mesh, or through a place. Boundaries are
    holes: a tube that is open at both ends has a girth, a disc has none. Regions that the solver's
    mask covers are holes, too, as no path crosses them, be it a single vertex; masks at both ends
    of a limb make a tube of it. Seams that are not welded are boundaries. In a scan the girth is
    often the outline of a missing face: give `min_hole` to go around larger holes only.

    Loops of edges are sorted into classes by the connectivity of the faces, not by their lengths.
    Through a place, the shortest of each class consists of two shortest paths along edges, and
    one more edge. These loops are pulled taut, and the shortest is returned. Of the whole mesh the
    shortest loops through vertices of a cut are, which every loop has to cross. All of it ends as a
    geodesic, as short as any loop close to it. Among loops far apart of almost equal length, it may
    be that the shortest is not found: edges lead a little longer in some directions than in others.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a TriangleMesh. Its mask is respected; heat plays no part.
    at : int, array-like of float, or SurfacePoint, optional
        One place, as :meth:`GeodesicSolver.distance` takes it, where the loop is held: it may have
        a corner there, and lead to a distant handle and back.
    min_hole : float
        Holes whose boundary is shorter, in the unit of the mesh, count as filled: a loop around
        nothing else shrinks. The loop still passes beside them.

    Returns
    -------
    GeodesicPath
        Closed; its `length` is the girth. It begins at the place.

    Raises
    ------
    ContractibleLoopError
        Every loop shrinks to a point: the component of the place, or each one, has no handle and
        one hole at most.
    InvalidOptionError
        Something else than a solver, a length that is none.
    InvalidSourceError
        Not one place.
    UnreachableError
        No face has the place.
    UnsupportedDomainError
        Not a mesh. An edge of more than two faces in the component of the place, or anywhere; holes
        shorter than `min_hole` that meet at several vertices. There the classes are not known.

    See Also
    --------
    geodesic_loop : A loop of a class that is given by way points.

    References
    ----------
    J. Erickson, S. Har-Peled, *Optimally cutting a surface into a disk*, 2004,
    https://doi.org/10.1007/s00454-003-2948-z

    J. Erickson, K. Whittlesey, *Greedy optimal homotopy and homology generators*, 2005,
    https://dl.acm.org/doi/10.5555/1070432.1070581

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> torus = gt.GeodesicSolver(gt.testing.shapes.torus(48, 24, major=2.0, minor=0.5))
    >>> round(gt.shortest_loop(torus).length, 2)  # around the tube, 2 π 0.5
    3.13
    >>> gt.shortest_loop(torus, at=100).points[0].round(3) == torus.domain.vertices[100].round(3)
    array([ True,  True,  True])
    """
    check_solver(solver, "a loop")
    check_length(min_hole, "min_hole")
    mesh = mesh_to_pull_over(solver)
    original = passable_faces(solver, mesh)
    weights = csr_array((0, mesh.n_vertices))
    if at is not None:
        place = located_places(solver, at, "at")
        if place.count != 1:
            raise InvalidSourceError(
                f"at: a loop is held at one place, not at {place.count}; call it for each"
            )
        weights = place.weights
    split = insert_points(mesh.vertices, mesh.faces[original], weights)
    start = None if at is None else int(split.vertex_of_point[0])
    if start is not None and start not in split.faces:
        raise unreachable_error(solver, "anything with the place of the loop")
    (faces, ends, shares), *unclear = _native.shortest_loop(
        np.ascontiguousarray(split.vertices),
        np.ascontiguousarray(split.faces),
        start,
        min_hole=float(min_hole),
    )
    if unclear[0] >= 0:
        raise _unclear_error(split, original, unclear)
    if not len(faces):
        raise _contractible_error(solver, through_place=at is not None, min_hole=min_hole)
    way = Candidate(faces, ends, np.column_stack([1 - shares, shares]))
    return closed_path(path_from_candidate(mesh, original, split, way))


def _unclear_error(
    split: Insertion, original: IntArray, unclear: list[int]
) -> UnsupportedDomainError:
    """Return the error of an edge of more than two faces, or of a vertex where short holes meet."""
    vertex, other = unclear
    if other < 0:
        return UnsupportedDomainError(
            f"holes shorter than min_hole meet at vertex {vertex} in a way that leaves open which "
            "faces to join; fill them in the mesh, or mask that vertex and give a longer min_hole"
        )
    at_edge = np.isin(split.faces, unclear).sum(axis=1) == 2
    faces = sorted({int(face) for face in original[split.parents[at_edge]]})
    listed = ", ".join(map(str, faces[:6])) + (", ..." if len(faces) > 6 else "")
    return UnsupportedDomainError(
        f"faces {listed} share an edge: where more than two meet, loops have no classes; "
        "remove faces until each edge has two, or give way points to geodesic_loop"
    )


def _contractible_error(
    solver: GeodesicSolver, *, through_place: bool, min_hole: float
) -> ContractibleLoopError:
    """Return the error of a surface on which every loop shrinks."""
    where = "through this place shrinks to a point: its component"
    if not through_place:
        where = "on the mesh shrinks to a point: each component"
    small = f" of {min_hole:g} or more" if min_hole else ""
    seams = f". {solver.seams.finding}; {solver.seams.cure}" if solver.seams else ""
    return ContractibleLoopError(
        f"every loop {where} has no handle, and one hole{small} at most; "
        f"{CURES_WITHOUT_LOOPS}{seams}"
    )
