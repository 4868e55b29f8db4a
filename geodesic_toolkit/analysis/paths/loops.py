"""Closed geodesics: loops that are pulled taut."""

from typing import Any

from geodesic_toolkit.analysis.paths.chains import Course, check_length, located_stops, path_through
from geodesic_toolkit.analysis.paths.path import GeodesicPath
from geodesic_toolkit.errors import ContractibleLoopError
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver

__all__ = ["geodesic_loop"]


def geodesic_loop(
    solver: GeodesicSolver, waypoints: Any, *, through: bool = False, min_length: float = 0.0
) -> GeodesicPath:
    """Return the closed geodesic that a loop through way points on a mesh is pulled to.

    The loop starts as the shortest path along edges from each way point to the next and back to the
    first. The strip of faces that it passes is unfolded, the shortest closed line through it drawn,
    and the strip led around the other side of a vertex wherever that is shorter. So the loop stays
    in its class: it goes around the same handles and holes. Where the surface bulges a class has
    several closed geodesics, and what comes out need not be the shortest of all.

    It may cross itself. Edges of more than two faces and their vertices are as borders to it: it
    passes them, and is pulled taut on either side of them.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a TriangleMesh. Its mask is respected; heat plays no part.
    waypoints : array-like of int, array-like of float, or sequence of SurfacePoint
        Three places or more in order, of one kind, as :meth:`GeodesicSolver.distance` takes them.
    through : bool
        Keep the way points on the loop: it consists of geodesics between them.
    min_length : float
        A loop that becomes shorter counts as contracted.

    Returns
    -------
    GeodesicPath
        Closed.

    Raises
    ------
    ContractibleLoopError
        The loop shrinks to a point, or to less than `min_length`: it goes around nothing.
    InvalidOptionError
        Something else than a solver, a length that is none.
    InvalidSourceError
        Candidate points that name no place, fewer than three, one twice in a row.
    UnreachableError
        No face connects a way point with the next.
    UnsupportedDomainError
        Not a mesh; one with costs or edge lengths, unless `through`.

    References
    ----------
    S.-Q. Xin, G.-J. Wang, *Efficiently determining a locally exact shortest path on polyhedral
    surfaces*, 2007, https://doi.org/10.1016/j.cad.2007.08.001

    N. Sharp, K. Crane, *You Can Find Geodesic Paths in Triangle Meshes by Just Flipping Edges*,
    2020, https://doi.org/10.1145/3414685.3417839

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> torus = gt.testing.shapes.torus(48, 24)
    >>> loop = gt.geodesic_loop(gt.GeodesicSolver(torus), [0, 8, 16])  # around the tube
    >>> loop.closed, round(loop.length, 2)
    (True, 3.13)
    """
    check_solver(solver, "a loop")
    check_length(min_length, "min_length")
    stops = located_stops(solver, [(waypoints, "way points")], closed=True)
    course = Course(closed=True, held=bool(through), min_length=float(min_length))
    loop = path_through(solver, stops, course)
    if loop is None:
        shrunk = f"to less than {min_length:g}" if min_length else "to a point"
        raise ContractibleLoopError(
            f"the loop through {stops.count} way points shrinks {shrunk}: it goes around no handle "
            "and no hole of the mesh; give way points on a loop that does, or through=True"
        )
    return loop
