"""Polylines in space: their samples, distances to them, and their curvature within a surface."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray

__all__ = [
    "bends_of_polyline",
    "distance_to_segments",
    "polyline_length",
    "sample_polyline",
]

MIN_ANGLE_OF_KINKS = 0.5
"""Minimum turn of a polyline, in radians, at a kink of the curve instead of a bend: the turn along
one edge of the smallest circle that a mesh resolves, with a radius of two edges. Within an edge's
length the sum of all other turns must be smaller, or else the corner is one of the steps of a
staircase, or of a loop too small to have corners.
"""

WINDOW_OF_CURVATURE = 4.0
"""Length, in mean edge lengths, over which a bend is averaged: steps from face to face are
noise."""


def polyline_length(corners: FloatArray, *, closed: bool = False) -> float:
    """Return the length of a polyline with corners of shape (P, 3)."""
    ends = np.concatenate([corners, corners[:1]]) if closed else corners
    return float(np.linalg.norm(np.diff(ends, axis=0), axis=1).sum())


def sample_polyline(corners: FloatArray, step: float) -> tuple[FloatArray, IntArray]:
    """Return points along a polyline, including its corners, at most `step` apart.

    Parameters
    ----------
    corners : ndarray of shape (P, 3)
    step : float

    Returns
    -------
    samples : ndarray of shape (S, 3)
    places : ndarray of shape (P,), int64
        Indices of the samples at the corners.
    """
    edges = np.diff(corners, axis=0)
    pieces = np.maximum(np.ceil(np.linalg.norm(edges, axis=1) / step), 1).astype(np.int64)
    segment = np.repeat(np.arange(len(edges)), pieces)
    first = np.cumsum(pieces) - pieces
    share = (np.arange(len(segment)) - first[segment]) / pieces[segment]
    inner = corners[segment] + share[:, None] * edges[segment]
    return np.concatenate([inner, corners[-1:]]), np.append(first, len(inner))


def distance_to_segments(places: FloatArray, samples: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the distances of places near each sample from the two segments that meet there.

    Parameters
    ----------
    places : ndarray of shape (S, m, 3)
    samples : ndarray of shape (S, 3)
        Samples in order along a polyline.

    Returns
    -------
    distance : ndarray of shape (S, m)
    nearest : ndarray of shape (S, m), int64
        The sample that is the nearest point of these segments; -1 if that is inside a segment.
    """
    distance = np.linalg.norm(places - samples[:, None], axis=2)
    nearest = np.repeat(np.arange(len(samples))[:, None], places.shape[1], axis=1)
    for shift in (-1, 1):
        ahead = np.clip(np.arange(len(samples)) + shift, 0, len(samples) - 1)
        along = samples[ahead] - samples
        squared = np.einsum("sd,sd->s", along, along)[:, None]
        reach = np.einsum("smd,sd->sm", places - samples[:, None], along)
        share = np.divide(reach, squared, out=np.zeros_like(reach), where=squared > 0)
        share = np.clip(share, 0, 1)[:, :, None]
        feet = np.where(share < 1, samples[:, None] + share * along[:, None], samples[ahead, None])
        to_foot = np.linalg.norm(places - feet, axis=2)
        closer = to_foot < distance
        distance = np.where(closer, to_foot, distance)
        nearest = np.where(closer, np.where(share[:, :, 0] < 1, -1, ahead[:, None]), nearest)
    return distance, nearest


def bends_of_polyline(
    corners: FloatArray, normals: FloatArray, at: FloatArray, spacing: float, closed: bool
) -> tuple[FloatArray, BoolArray]:
    """Return the geodesic curvature along a polyline, and a mask of its kinks.

    The turns of the polyline in the tangent plane are spread over half of both adjacent segments;
    kinks are excluded.

    Parameters
    ----------
    corners, normals : ndarray of shape (P, 3)
        The last corner of a closed polyline equals the first.
    at : ndarray of shape (S,)
        Positions as lengths along the polyline.
    spacing : float
        Mean edge length of the surface.
    closed : bool

    Returns
    -------
    curvatures : ndarray of shape (S,)
        Positive to the left, seen from outside, where the normals point.
    kinks : ndarray of shape (P,), bool
    """
    steps = np.diff(corners, axis=0)
    ends = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])
    half = min(WINDOW_OF_CURVATURE * spacing, ends[-1]) / 2
    before, after = (
        part - np.einsum("pd,pd->p", part, normals)[:, None] * normals
        for part in (np.vstack([steps[-1:], steps]), np.vstack([steps, steps[:1]]))
    )
    aside = np.einsum("pd,pd->p", np.cross(before, after), normals)
    turns = np.arctan2(aside, np.einsum("pd,pd->p", before, after))
    if not closed:
        turns[[0, -1]] = 0.0
    kinks = _are_kinks(turns, ends, spacing, closed)
    smooth = np.where(kinks, 0.0, turns)[:-1]  # at the start of each segment
    middles, turned = (ends[:-1] + ends[1:]) / 2, np.cumsum(smooth)
    if closed:  # windows at the ends overlap the seam
        laps = np.array([[-1.0], [0.0], [1.0]])
        middles = (middles + laps * ends[-1]).ravel()
        turned = (turned + laps * smooth.sum()).ravel()
    first, last = at - half, at + half
    if not closed:
        first, last = np.maximum(first, 0.0), np.minimum(last, ends[-1])
    change = np.interp(last, middles, turned) - np.interp(first, middles, turned)
    width = np.maximum(last - first, np.finfo(np.float64).tiny)
    return change / width, kinks


def _are_kinks(turns: FloatArray, places: FloatArray, spacing: float, closed: bool) -> BoolArray:
    """Return a mask of the kinks among corners at given lengths along a polyline."""
    last = len(turns) - closed  # the last corner repeats the first
    own, at, total = turns[:last], places[:last], places[-1]
    reach = min(spacing, total) / 2
    laps = np.array([[-1.0], [0.0], [1.0]]) if closed else np.zeros((1, 1))
    along = (at + laps * total).ravel()
    turned = np.concatenate([[0.0], np.cumsum(np.tile(np.abs(own), len(laps)))])
    near = (
        turned[np.searchsorted(along, places + reach, side="right")]
        - turned[np.searchsorted(along, places - reach, side="left")]
    )
    return np.asarray(
        (np.abs(turns) > MIN_ANGLE_OF_KINKS) & (near - np.abs(turns) < MIN_ANGLE_OF_KINKS)
    )
