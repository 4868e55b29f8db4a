"""The stiffness of weighted edges, to which both kinds of gradient reduce."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["graph_laplacian"]


def graph_laplacian(
    weights: FloatArray, tails: IntArray, heads: IntArray, n_vertices: int
) -> csr_array:
    """Return ``D - W`` for edge weights of either sign.

    Every row has an entry for its diagonal, and one for every edge, even if its weight is zero:
    matrices that share the edges share the pattern. Both entries of an edge are the same sum, so
    that W is symmetric to the bit; D is its row sum, so that constants are in the kernel up to
    rounding.
    """
    from scipy.sparse import coo_array, csr_array

    proper = tails != heads
    tails, heads = tails[proper], heads[proper]
    indices = (np.minimum(tails, heads), np.maximum(tails, heads))
    shape = (n_vertices, n_vertices)
    edges = coo_array(csr_array(coo_array((weights[proper], indices), shape=shape)))
    lower, upper = edges.coords
    degree = np.bincount(lower, edges.data, minlength=n_vertices)
    degree += np.bincount(upper, edges.data, minlength=n_vertices)
    vertices = np.arange(n_vertices)
    entries = np.concatenate([degree, -edges.data, -edges.data])
    rows = np.concatenate([vertices, lower, upper])
    columns = np.concatenate([vertices, upper, lower])
    return csr_array(coo_array((entries, (rows, columns)), shape=shape))
