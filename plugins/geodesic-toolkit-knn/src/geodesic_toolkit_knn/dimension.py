"""The dimension of the space that samples are drawn from."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import digamma

from geodesic_toolkit.errors import InvalidDomainError
from geodesic_toolkit_knn.neighbours import nearest
from geodesic_toolkit_knn.tables import FloatArray, as_table

__all__ = ["N_NEIGHBOURS", "dimension_from_distances", "intrinsic_dimension"]

N_NEIGHBOURS = 20
"""Neighbours that a dimension is estimated from. Among 16 to 24 estimates are alike: a roll of 300
samples has 2.0 to 2.2, and 2.6 among 40, which reach the next sheet; a torus with noise of 0.4 has
2.3 to 2.5, and 2.7 among 10."""


def intrinsic_dimension(points: ArrayLike, k: int = N_NEIGHBOURS) -> float:
    """Return the dimension of the space that samples are drawn from, as their neighbours show it.

    Among the k nearest neighbours, the distance to the last is compared with that to the middle
    one: in d dimensions the logarithm of their ratio is about ``log(2) / d``. The nearest half is
    left out because noise is largest beside small distances.

    Parameters
    ----------
    points : array-like of shape (N, D)
        More than k different ones, beside those that are missing: entirely NaN.
    k : int, optional
        Neighbours, 4 or more.

    Returns
    -------
    float
        Near the border of a space it is less: 1.9 on a square, 2.7 in a cube, 7 for 10
        dimensions.

    Raises
    ------
    InvalidDomainError
        As for :class:`KNNGraph`; fewer than k + 1 different samples, or fewer than 4 neighbours.

    References
    ----------
    E. Levina, P. Bickel, *Maximum Likelihood Estimation of Intrinsic Dimension*, NIPS 17, 2004

    A. M. Farahmand, C. Szepesvári, J.-Y. Audibert, *Manifold-adaptive dimension estimation*, ICML
    2007, https://doi.org/10.1145/1273496.1273530

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit_knn import intrinsic_dimension
    >>> angle = np.random.default_rng(0).random(500)
    >>> round(intrinsic_dimension(np.column_stack([np.cos(angle), np.sin(angle)])))
    1
    """
    table = as_table(points)
    places = np.unique(table[~np.isnan(table).any(axis=1)], axis=0)
    if not (isinstance(k, int | np.integer) and 4 <= k < len(places)):
        raise InvalidDomainError(
            f"{k} neighbours of {len(places)} different samples: take 4 or more, and fewer than "
            "samples"
        )
    return dimension_from_distances(nearest(places, k, "euclidean", "exact")[1])


def dimension_from_distances(distances: FloatArray) -> float:
    """Return the same from the distances of neighbours, nearest first, (N, k); NaN if k < 4."""
    k = distances.shape[1]
    if k < 4:
        return float("nan")
    middle, last = distances[:, k // 2 - 1], distances[:, -1]
    apart = middle > 0
    growth = float(np.log(last[apart] / middle[apart]).mean()) if apart.any() else 0.0
    return float((digamma(k) - digamma(k // 2)) / growth) if growth > 0 else float("nan")
