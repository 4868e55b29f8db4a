"""Signed distance from curves: open, closed, broken, several."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from geodesic_toolkit.analysis.paths.fronts import refined_distance
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import PointCloud, TriangleMesh
from geodesic_toolkit.errors import (
    InvalidCurveError,
    InvalidOptionError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.isolines import level_set
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.solver.masks import check_unmasked
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.laid import LaidCurve, sides_of
from geodesic_toolkit.sources.locate import samples_of
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.surface_point import SurfacePoint
from geodesic_toolkit.vector_heat.signed import levelled, signed_potential

__all__ = ["signed_distance"]

JUMP = 2.0
"""Largest distance on the surface, in mean edges, of two samples of a curve, which are a quarter of
an edge apart: beyond it the curve has left the surface, and was projected to another part."""

BESIDE = 0.5
"""Mean edges from the curves beyond which the zero set of the plain distance bridges a gap."""


def signed_distance(
    solver: GeodesicSolver,
    curves: Curve | Sequence[Curve],
    *,
    unsigned: Curve | Sequence[Curve] = (),
    refine: bool | None = None,
    level: bool = True,
) -> FloatArray:
    """Return the distance from curves, positive on their left and negative on their right.

    The curves may be open, closed, or pieces of one: their normals diffuse, and determine the sides
    far away, also across gaps. Refined, the distance is swept from the curves and, in their gaps,
    from the zero set of the plain distance; only its sign is that of the heat.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a point cloud.
    curves : Curve or sequence of Curve
        Their segments may cross any number of faces: they are laid onto the surface, point by
        point. Left is left as seen from where normals point: outside, on closed surfaces.
    unsigned : Curve or sequence of Curve
        More curves, without sides: the distance from them counts, its sign is that of the others.
    refine : bool, optional
        On meshes as the solver does, on clouds plain, unless given. Measured on spheres, plain is
        better on clouds where the curve goes through points.
    level : bool
        True to make a plain distance 0 everywhere on the curves, and not only in the mean.

    Returns
    -------
    ndarray of shape (N,), float64
        In the unit of the shape; ``inf`` without a connection to a curve.

    Raises
    ------
    InvalidOptionError
        An argument that is not a solver; `refine` or `level` that is neither true nor false.
    UnsupportedDomainError
        A graph, an operator without triangles, a surface with one side.
    InvalidCurveError
        Arguments that are not curves, an empty sequence, or a curve that leaves the surface: the
        message names it, and its points before and after.
    InvalidSourceError
        A curve over a masked vertex, or on a face that does not exist.

    References
    ----------
    N. Feng, K. Crane, *A Heat Method for Generalized Signed Distance*, 2024,
    https://doi.org/10.1145/3658220

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(11))
    >>> middle = gt.Curve([[0.5, 0, 0], [0.5, 1, 0]])  # upwards: left is where x is less
    >>> gt.signed_distance(solver, middle)[:11].round(3)
    array([ 0.5,  0.4,  0.3,  0.2,  0.1,  0. , -0.1, -0.2, -0.3, -0.4, -0.5])
    """
    check_solver(solver, "signed_distance")
    if not isinstance(solver.passable, TriangleMesh | PointCloud):
        raise UnsupportedDomainError(
            f"{a_kind_of(solver.passable)} has no sides: an edge has no angle; a signed "
            "distance needs a mesh or a point cloud"
        )
    for name, value in (("refine", refine), ("level", level)):
        if not (isinstance(value, bool | np.bool_) or (name == "refine" and value is None)):
            raise InvalidOptionError(f"{name} must be True or False, not {value!r}")
    signed, others = _curves(curves, "curve"), _curves(unsigned, "unsigned curve")
    if not signed:
        raise InvalidCurveError("there are no curves; give at least one")
    laid = [_laid(solver, curve, f"curve {k}") for k, curve in enumerate(signed)]
    beside = [_laid(solver, curve, f"unsigned curve {k}") for k, curve in enumerate(others)]
    heat = solver.signed_heat
    plain = levelled(heat, laid, signed_potential(heat, laid), along=bool(level))
    on_mesh = isinstance(solver.passable, TriangleMesh)
    refined = solver.method.refine and on_mesh if refine is None else bool(refine)
    result = _refined(solver, laid, plain) if refined else plain
    if not beside:
        return result
    distance = _distance(solver, beside, refined=refined)
    return np.where(result < 0, -1.0, 1.0) * np.minimum(np.abs(result), distance)


def _curves(given: Any, name: str) -> list[Curve]:
    curves = [given] if isinstance(given, Curve) else given
    if isinstance(curves, str | bytes) or not isinstance(curves, Sequence):
        raise InvalidCurveError(f"{name}s must be a Curve or a sequence of them, not {given!r}")
    for k, curve in enumerate(curves):
        if not isinstance(curve, Curve):
            raise InvalidCurveError(f"{name} {k} must be a Curve, not {curve!r}")
    return list(curves)


def _laid(solver: GeodesicSolver, curve: Curve, name: str) -> LaidCurve:
    """Return a curve on the surface, checked."""
    passable = solver.passable
    assert isinstance(passable, TriangleMesh | PointCloud)  # for the type checker
    samples = samples_of(solver.domain, passable, curve, name)
    if len(samples.points) < 2:
        raise InvalidCurveError(f"{name} is a single place, {samples.points[0].tolist()}")
    if isinstance(passable, TriangleMesh):
        assert solver.ground is not None  # meshes have one
        faces, weights = solver.ground.triangles.closest(samples.points)
        vertices, places = passable.faces[faces], passable.vertices
    else:
        vertices, weights = solver.surface.feet(samples.points)
        places = _positions(solver)
    points = np.einsum("sc,scd->sd", weights, places[vertices])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not steps.max() <= JUMP * samples.spacing:
        bad = int(steps.argmax())
        segment = int(np.searchsorted(samples.places, bad, side="right")) - 1
        raise InvalidCurveError(
            f"{name} leaves the surface between its points {segment} and {segment + 1}: the "
            f"place nearest to it jumps by {steps[bad]:.4g} there; give points that follow the "
            "surface"
        )
    laid = LaidCurve(points, vertices, weights, samples, curve.closed)
    if solver.mask is not None:
        check_unmasked(laid.as_sources(solver.domain.n_vertices), solver.mask, name)
    return laid


def _distance(solver: GeodesicSolver, laid: list[LaidCurve], *, refined: bool) -> FloatArray:
    """Return the distance from curves, without a sign."""
    places = _positions(solver)
    together = SourcePoints.together(
        [
            curve.as_fronts(places, solver.frames.normals, solver.method.metric.boundary)
            for curve in laid
        ]
    )
    if refined:
        metric = solver.method.metric
        on = metric.subdivision
        sweeper = WavefrontSweeper(metric if on is None else on.metric)
        return refined_distance(solver.method, sweeper, together)
    return solver.method.distance(together)


def _refined(solver: GeodesicSolver, laid: list[LaidCurve], plain: FloatArray) -> FloatArray:
    """Return the refined distance from curves and what bridges their gaps, with a sign."""
    bridges = []
    if isinstance(solver.passable, TriangleMesh) and not all(curve.closed for curve in laid):
        bridges = [_laid(solver, curve, "the bridge") for curve in _bridges(solver, laid, plain)]
    distance = _distance(solver, [*laid, *bridges], refined=True)
    negative = plain < 0
    vertices, left = sides_of(laid, _positions(solver), solver.frames.normals)
    negative[vertices] = ~left
    return np.where(negative & np.isfinite(distance), -distance, distance)


def _positions(solver: GeodesicSolver) -> FloatArray:
    domain = solver.domain
    if isinstance(domain, TriangleMesh):
        return domain.vertices
    assert isinstance(domain, PointCloud)  # for the type checker
    return domain.points


def _bridges(solver: GeodesicSolver, laid: list[LaidCurve], plain: FloatArray) -> list[Curve]:
    """Return the zero set of a plain signed distance away from its curves."""
    mesh = solver.passable
    assert isinstance(mesh, TriangleMesh)  # for the type checker
    whole = solver.domain
    assert isinstance(whole, TriangleMesh)
    kept = np.arange(whole.n_faces)
    if solver.mask is not None:
        kept = np.flatnonzero(~solver.mask[whole.faces].any(axis=1))
    near = cKDTree(np.concatenate([curve.points for curve in laid]))
    beside = BESIDE * solver.method.metric.spacing
    bridges = []
    for chain in level_set(mesh.faces, plain):
        corners = mesh.vertices[mesh.faces[chain.faces]]
        points = np.einsum("pc,pcd->pd", chain.weights, corners)
        far = np.asarray(near.query(points)[0]) > beside
        if chain.closed and not far.all():  # begin near a curve, so that runs are whole
            first = int((~far).argmax())
            far, order = np.roll(far, -first), np.roll(np.arange(len(far)), -first)
        else:
            order = np.arange(len(far))
        ends = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(int)))
        for begin, end in zip(ends[::2], ends[1::2], strict=True):
            own = order[begin:end]
            if len(own) > 1:
                corner = kept[chain.faces[own]].tolist(), chain.weights[own].tolist()
                its = [
                    SurfacePoint(face, (a, b, c)) for face, (a, b, c) in zip(*corner, strict=True)
                ]
                bridges.append(Curve(its, closed=chain.closed and len(own) == len(far)))
    return bridges
