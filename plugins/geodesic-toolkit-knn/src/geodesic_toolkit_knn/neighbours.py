"""Nearest neighbours in any dimension, by scikit-learn, or by pynndescent where it is installed."""

import importlib.util
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError

__all__ = ["FloatArray", "IntArray", "nearest"]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]

MIN_SAMPLES_OF_APPROXIMATE_SEARCH = 20_000
"""Samples from which on "auto" takes the approximate search, if it is installed. Compiling it takes
some 20 s, in which the exact one compares 20,000 samples with each other many times over."""

MAX_DIMENSION_OF_TREES = 15
"""Dimension of the space up to which trees find neighbours without looking at nearly all samples:
"auto" is exact up to there."""


def nearest(points: FloatArray, k: int, metric: str, search: str) -> tuple[IntArray, FloatArray]:
    """Return the k nearest other samples of each, nearest first, and how far they are, (N, k).

    Parameters
    ----------
    points : ndarray of shape (N, D), float64
        Distinct.
    k : int
        Below N.
    metric : str
        As scikit-learn's ``NearestNeighbors`` has it.
    search : {"auto", "exact", "approximate"}

    Raises
    ------
    InvalidOptionError
        The metric is not known.
    MissingDependencyError
        "approximate", and pynndescent is not installed.
    """
    if search == "auto":
        large = len(points) > MIN_SAMPLES_OF_APPROXIMATE_SEARCH
        wide = points.shape[1] > MAX_DIMENSION_OF_TREES
        installed = importlib.util.find_spec("pynndescent") is not None
        search = "approximate" if large and wide and installed else "exact"
    try:
        if search == "approximate":
            near, far = _by_descent(points, k, metric)
        else:
            near, far = _by_trees(points, k, metric)
    except (ValueError, KeyError) as error:
        raise InvalidOptionError(f"neighbours by metric {metric!r}: {error}") from error
    return _without_self(near, far)


def _by_trees(points: FloatArray, k: int, metric: str) -> tuple[Any, Any]:
    from sklearn.neighbors import NearestNeighbors

    index = NearestNeighbors(n_neighbors=k + 1, metric=metric).fit(points)
    far, near = index.kneighbors(points)
    return near, far


def _by_descent(points: FloatArray, k: int, metric: str) -> tuple[Any, Any]:
    try:
        from pynndescent import NNDescent
    except ImportError as error:
        raise MissingDependencyError(
            f'search="approximate" needs pynndescent ({error}): pip install pynndescent'
        ) from error
    index = NNDescent(points, metric=metric, n_neighbors=k + 1, random_state=0)
    near, far = index.neighbor_graph
    if (near < 0).any():
        bad = int((near < 0).any(axis=1).argmax())
        raise InvalidOptionError(
            f'pynndescent found fewer than {k} neighbours of sample {bad}; take search="exact"'
        )
    return near, far


def _without_self(near: Any, far: Any) -> tuple[IntArray, FloatArray]:
    """Leave each sample out of its own neighbours, or the farthest where it is not among them."""
    near, far = near.astype(np.int64), far.astype(np.float64)
    own = near == np.arange(len(near))[:, None]
    own[~own.any(axis=1), -1] = True
    rows, kept = len(near), near.shape[1] - 1
    return near[~own].reshape(rows, kept), np.maximum(far[~own], 0.0).reshape(rows, kept)
