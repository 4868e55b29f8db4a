"""Signed distance from curves by heat: their normals diffuse, and are integrated.

N. Feng, K. Crane, *A Heat Method for Generalized Signed Distance*, ACM Transactions on Graphics 43,
2024, https://doi.org/10.1145/3658220
"""

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.frames import ComplexArray, Frames
from geodesic_toolkit.sources.laid import LaidCurve
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.vector_heat.method import VectorHeatMethod

__all__ = ["levelled", "signed_potential"]


def signed_potential(heat: VectorHeatMethod, curves: list[LaidCurve]) -> FloatArray:
    """Return φ whose gradient has length 1 and the direction of the normals after diffusion, (N,).

    It grows to the left of the curves, and is 0 at one vertex of each connected component.

    Raises
    ------
    UnsupportedDomainError
        A metric that is not made of triangles.
    """
    gradient, frames = heat.heat.metric.gradient, heat.frames
    if not (isinstance(gradient, ElementGradient) and gradient.of_planes):
        raise UnsupportedDomainError(
            f"a signed distance needs triangles, and this discretization has {gradient!r}"
        )
    load = np.sum([_normals(curve, frames) for curve in curves], axis=0)
    vectors = heat.diffuse(load)
    corners = vectors.log_sizes[gradient.elements]  # only their ratio inside an element counts
    largest = corners.max(axis=1, keepdims=True)
    sizes = np.exp(corners - np.where(np.isfinite(largest), largest, 0.0))
    mean = (frames.turns * vectors.directions[gradient.elements] * sizes).sum(axis=1)
    length = np.abs(mean)
    mean = np.divide(mean, length, out=np.zeros_like(mean), where=length > 0)
    field = np.column_stack([mean.real, np.where(frames.mirrored, -mean.imag, mean.imag)])
    return heat.heat.integrate(field)


def levelled(
    heat: VectorHeatMethod, curves: list[LaidCurve], potential: FloatArray, *, along: bool
) -> FloatArray:
    """Return a potential shifted to 0 on curves; ``inf`` without a connection to a curve.

    Parameters
    ----------
    heat : VectorHeatMethod
    curves : list of LaidCurve
    potential : ndarray of shape (N,), float64
    along : bool
        Take off at each vertex what the potential is at the nearest place of the curves, by an
        extension: as near to a constraint as its own solve is, at the cost of two columns of the
        present factor. Otherwise the mean on the curves of each component.
    """
    metric = heat.heat.metric
    on = np.concatenate([curve.readings(potential) for curve in curves])
    if along:
        places = [curve.as_sources(len(potential)) for curve in curves]
        level = heat.extend(SourcePoints.together(places), on)
    else:
        part = metric.components
        own = np.concatenate([part[curve.vertices[:, 0]] for curve in curves])
        length = np.concatenate([curve.lengths for curve in curves])
        count = int(part.max()) + 1
        total = np.bincount(own, length, count)
        sums = np.asarray(np.bincount(own, length * on, count))
        level = np.divide(sums, total, out=np.full(count, np.nan), where=total > 0)[part]
    return np.where(np.isnan(level), np.inf, potential - level)


def _normals(curve: LaidCurve, frames: Frames) -> ComplexArray:
    """Return the normals of a curve, to its left, times length, at vertices: (N,)."""
    load = np.zeros(len(frames.normals), dtype=np.complex128)
    steps = np.diff(curve.points, axis=0)
    for end in (slice(None, -1), slice(1, None)):  # each has half of a step
        for vertices, weights in zip(curve.vertices[end].T, curve.weights[end].T, strict=True):
            np.add.at(load, vertices, 0.5j * weights * frames.to_frames(steps, vertices))
    return load
