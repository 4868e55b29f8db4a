"""Nearest neighbours in any dimension, by scikit-learn, or by pynndescent where it is installed."""

import importlib.util
import itertools
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError
from geodesic_toolkit_knn.tables import FloatArray, IntArray

__all__ = ["ASYMMETRY", "Metric", "nearest"]

Metric: TypeAlias = str | Callable[[FloatArray, FloatArray], float]

MIN_SAMPLES_OF_APPROXIMATE_SEARCH = 20_000
"""Samples from which on "auto" takes the approximate search, if it is installed. Compiling it takes
some 20 s, in which the exact one compares 20,000 samples with each other many times over."""

MAX_DIMENSION_OF_TREES = 15
"""Dimension of the space up to which trees find neighbours without looking at nearly all samples:
"auto" is exact up to there."""

N_PROBES = 64
"""Pairs of samples on which a function is tried as a metric."""

ASYMMETRY = 1e-9
"""Relative difference of two values of one pair of samples that rounding accounts for."""


def nearest(points: FloatArray, k: int, metric: Metric, search: str) -> tuple[IntArray, FloatArray]:
    """Return the k nearest other samples of each, nearest first, and how far they are, (N, k).

    Parameters
    ----------
    points : ndarray of shape (N, D), float64
        Distinct.
    k : int
        Below N.
    metric : str or callable
        As scikit-learn's ``NearestNeighbors`` has it.
    search : {"auto", "exact", "approximate"}

    Raises
    ------
    InvalidOptionError
        The metric is not known or not a metric.
    MissingDependencyError
        "approximate", and pynndescent is not installed.
    """
    if callable(metric):
        _try_metric(points, metric)
        search = "exact" if search == "auto" else search
    if search == "auto":
        large = len(points) > MIN_SAMPLES_OF_APPROXIMATE_SEARCH
        wide = points.shape[1] > MAX_DIMENSION_OF_TREES
        installed = importlib.util.find_spec("pynndescent") is not None
        search = "approximate" if large and wide and installed else "exact"
    if metric == "precomputed":
        raise InvalidOptionError(
            'metric="precomputed": give distances that are known as a sparse matrix to '
            "KNNGraph.from_distances"
        )
    find = _by_descent if search == "approximate" else _by_trees
    try:
        near, far = find(points, k, metric)
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidOptionError(f"neighbours by metric {metric!r}: {error}") from error
    sound = np.isfinite(far) & (far >= -ASYMMETRY * np.abs(far).max())
    if not sound.all():
        bad = int(sound.all(axis=1).argmin())
        raise InvalidOptionError(
            f"the metric {metric!r} gives distances that are negative or not finite, as from "
            f"{_shown(points[bad])}"
        )
    return _without_self(near, far)


def _try_metric(points: FloatArray, metric: Callable[[FloatArray, FloatArray], float]) -> None:
    """Raise unless a function gives some pairs of samples the same length in both directions."""
    tried = points[: N_PROBES + 1]
    for one, other in itertools.pairwise(tried):
        there, back = _length(metric, one, other), _length(metric, other, one)
        if abs(there - back) > ASYMMETRY * (there + back):
            raise InvalidOptionError(
                f"the metric {metric!r} is not symmetric: {there} from {_shown(one)} to "
                f"{_shown(other)}, and {back} in the other direction"
            )


def _length(metric: Callable[[FloatArray, FloatArray], Any], *ends: FloatArray) -> float:
    found = metric(*ends)
    try:
        length = float(found)
    except (TypeError, ValueError):
        length = np.nan
    if not 0 <= length < np.inf:
        raise InvalidOptionError(
            f"the metric {metric!r} returns {found!r} for {' and '.join(map(_shown, ends))}; "
            "distances are finite numbers and not negative"
        )
    return length


def _shown(sample: FloatArray) -> str:
    return np.array2string(sample, precision=3, threshold=6, edgeitems=2)


def _by_trees(points: FloatArray, k: int, metric: Metric) -> tuple[Any, Any]:
    from sklearn.neighbors import NearestNeighbors

    index = NearestNeighbors(n_neighbors=k + 1, metric=metric).fit(points)
    far, near = index.kneighbors(points)
    return near, far


def _by_descent(points: FloatArray, k: int, metric: Metric) -> tuple[Any, Any]:
    if callable(metric):
        raise InvalidOptionError(
            'search="approximate" takes metrics by name; take search="exact" for a function'
        )
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
