"""The refined distances that paths descend."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.subdivided import on_subdivision

__all__ = ["first_to_arrive", "one_place", "refined_distance"]


def refined_distance(
    method: HeatMethod, sweeper: WavefrontSweeper, sources: SourcePoints
) -> FloatArray:
    """Return the refined distance (N,), by the sweeper if the method does not refine.

    On a metric with a subdivision at the vertices of that, (M,), by the sweeper of that.
    """
    on = method.metric.subdivision
    if on is not None:
        order = on.extended(method.log_heat(sources, only_order=True))
        return sweeper.distance(order, on_subdivision(sources, on))
    if method.refine:
        return method.distance(sources)
    return sweeper.distance(method.log_heat(sources, only_order=True), sources)


def first_to_arrive(sources: SourcePoints, back: FloatArray) -> SourcePoints:
    """Return the source with the least offset plus distance to the goal, without its offset."""
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
