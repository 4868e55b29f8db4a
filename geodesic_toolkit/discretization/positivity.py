"""Weights of the wrong sign: a measure of their effect, and a diffusion without them.

Heat satisfies the maximum principle, and so stays positive, if all off-diagonal entries of the
stiffness L = -Δ are zero or negative. Obtuse angles make some of them positive.
"""

from typing import TYPE_CHECKING, cast

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.data import Discretization, check_discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["has_wrong_signs", "obtuse_excess", "positive_part"]

N_RINGS_AVERAGED = 4
"""Number of rings of the neighbourhoods over which :func:`obtuse_excess` averages."""

MIN_RELATIVE_ENTRY = 1e-12
"""Entry of a stiffness, relative to the largest one, below which it counts as 0."""

WEIGHT_OF_REVERSED_EDGES = 1e-3
"""Weight that replaces one of the wrong sign, relative to its size; positive, so that the graph
stays connected."""


def obtuse_excess(stiffness: CompressedRows, mass: FloatArray) -> FloatArray:
    """Return the share of a stiffness with the wrong sign around each vertex: 0 for an M-matrix.

    It is the share of positive entries in the absolute sum of a row without the diagonal, averaged
    by mass over neighbourhoods of four rings, of shape (N,). A single obtuse triangle is harmless,
    and so are tiny ones: only a region of obtuse triangles makes heat negative.

    Parameters
    ----------
    stiffness : CompressedRows of shape (N, N)
        With an entry for every edge and for the diagonal of every row, even if it is zero. The
        diagonal and upper triangle are enough.
    mass : ndarray of shape (N,)
    """
    return _native.obtuse_excess(*stiffness.arrays, mass, N_RINGS_AVERAGED)


def has_wrong_signs(stiffness: CompressedRows) -> bool:
    """Return True if off-diagonal entries of a stiffness are positive beyond rounding."""
    off_diagonal = stiffness.indices != stiffness.row_of_entry
    rounding = MIN_RELATIVE_ENTRY * np.abs(stiffness.data).max(initial=0.0)
    return bool((stiffness.data[off_diagonal] > rounding).any())


def positive_part(metric: Discretization) -> Discretization:
    """Return the graph Laplacian of the edges of `metric` that have the right sign.

    Its heat is positive at all vertices that it reaches. It differs from `metric` in a few edges
    only, which changes the heat little and does not affect the Poisson step, whereas one edge of
    the wrong sign near a source can make the heat negative in the whole region behind it.

    Parameters
    ----------
    metric : Discretization

    Returns
    -------
    Discretization
        On the same vertices with the same mass and the same components; edges of the wrong sign
        keep a thousandth of their weight.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.discretization.positivity import positive_part
    >>> sheared = gt.CotanLaplacian().assemble(gt.testing.shapes.grid(5, shear=3.0))
    >>> bool(positive_part(sheared).gradient.edge_weights.min() > 0)
    True
    """
    check_discretization(metric, "metric")
    given, count = metric.rows, len(metric.mass)
    tails = given.row_of_entry.astype(np.int64)
    heads = given.indices.astype(np.int64)
    upper, diagonal = heads > tails, heads == tails
    weights = np.maximum(-given.data, WEIGHT_OF_REVERSED_EDGES * np.abs(given.data))
    edges = np.column_stack([tails[upper], heads[upper]])
    gradient = EdgeGradient(edges, weights[upper], metric.mass, copy=False)
    if np.count_nonzero(diagonal) == count:  # the pattern and its analysis stay valid
        weights[diagonal] = 0.0
        weights[diagonal] = -np.bincount(tails, weights, count)
        stiffness = cast("csr_array", given.with_data(-weights))  # the class of the result
    else:
        stiffness = gradient.stiffness()
    return Discretization(
        mass=metric.mass,
        stiffness=stiffness,
        gradient=gradient,
        spacing=metric.spacing,
        boundary=metric.boundary,
        scales=metric.scales,
        notes=metric.notes,
        copy=False,
    )
