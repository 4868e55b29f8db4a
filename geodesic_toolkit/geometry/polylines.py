"""Polylines in space: samples of them, and distances to them."""

import numpy as np

from geodesic_toolkit._typing import BoolArray, FloatArray

__all__ = ["distance_to_segments", "sample_polyline"]


def sample_polyline(corners: FloatArray, step: float) -> FloatArray:
    """Return points along a polyline, its corners among them, no farther apart than `step`.

    Parameters
    ----------
    corners : ndarray of shape (P, 3)
    step : float

    Returns
    -------
    ndarray of shape (S, 3)
    """
    edges = np.diff(corners, axis=0)
    pieces = np.maximum(np.ceil(np.linalg.norm(edges, axis=1) / step), 1).astype(np.int64)
    segment = np.repeat(np.arange(len(edges)), pieces)
    first = np.cumsum(pieces) - pieces
    share = (np.arange(len(segment)) - first[segment]) / pieces[segment]
    inner = corners[segment] + share[:, None] * edges[segment]
    return np.concatenate([inner, corners[-1:]])


def distance_to_segments(places: FloatArray, samples: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return how far places near each sample are from the two segments that meet there.

    Parameters
    ----------
    places : ndarray of shape (S, m, 3)
    samples : ndarray of shape (S, 3)
        In order along a polyline.

    Returns
    -------
    distance : ndarray of shape (S, m)
    beside : ndarray of shape (S, m), bool
        Whether the nearest point is inside a segment or between two, rather than an end of all.
    """
    distance = np.linalg.norm(places - samples[:, None], axis=2)
    beside = np.zeros(distance.shape, dtype=np.bool_)
    beside[1:-1] = True
    for shift in (-1, 1):
        other = np.roll(samples, -shift, axis=0)
        other[-1 if shift == 1 else 0] = samples[-1 if shift == 1 else 0]
        along = other - samples
        squared = np.einsum("sd,sd->s", along, along)[:, None]
        reach = np.einsum("smd,sd->sm", places - samples[:, None], along)
        share = np.clip(
            np.divide(reach, squared, out=np.zeros_like(reach), where=squared > 0), 0, 1
        )
        feet = samples[:, None] + share[:, :, None] * along[:, None]
        to_foot = np.linalg.norm(places - feet, axis=2)
        beside |= (share > 0) & (to_foot <= distance)
        distance = np.minimum(distance, to_foot)
    return distance, beside
