"""The refined distances that paths descend."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["first_to_arrive", "one_place", "refined_distance"]


def refined_distance(
    solver: GeodesicSolver, metric: Discretization, places: SourcePoints
) -> FloatArray:
    """Return the refined distance (N,) over a metric, whether the solver refines or not."""
    method = solver.method
    if method.refine:
        return method.distance(places)
    sweeper = WavefrontSweeper(metric)  # which refuses what has no triangles
    return sweeper.distance(method.log_heat(places, only_order=True), places)


def first_to_arrive(sources: SourcePoints, back: FloatArray) -> SourcePoints:
    """Return the source whose offset and way to the goal are least together, without its offset."""
    return one_place(sources, int(np.argmin(sources.starts + sources.weights @ back)))


def one_place(sources: SourcePoints, index: int) -> SourcePoints:
    """Return one of several places, without its offset."""
    around = slice(sources.begins[index], sources.begins[index + 1])
    return SourcePoints(
        vertices=sources.vertices[around],
        shares=sources.shares[around],
        begins=sources.begins[index : index + 2] - sources.begins[index],
        n_vertices=sources.n_vertices,
        distances=sources.distances[around],
        front_curvatures=sources.curvatures[around],
    )
