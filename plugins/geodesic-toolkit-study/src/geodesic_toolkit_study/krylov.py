"""Conjugate gradients, watched: how far each step reaches."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import dijkstra

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization

__all__ = ["Iteration", "conjugate_gradients", "heat_matrix", "rings"]


MOST_STEPS = 2000
"""After which it gives up: at large t and on thin triangles there is no end to it."""


@dataclass(frozen=True, eq=False)
class Iteration:
    """Result of a run of conjugate gradients.

    Attributes
    ----------
    solution : ndarray of shape (N,)
    iterations : int
    non_zero : ndarray of shape (iterations,), int64
        How many entries of the iterate were not exactly 0 after each step.
    converged : bool
        Whether it reached its tolerance.
    """

    solution: FloatArray
    iterations: int
    non_zero: IntArray
    converged: bool


def conjugate_gradients(matrix: csr_array, right_hand_side: FloatArray, rtol: float) -> Iteration:
    """Solve a system by SciPy's conjugate gradients from a start at 0, without a preconditioner.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> path = csr_array(np.diag([2.0] * 4) - np.diag([1.0] * 3, 1) - np.diag([1.0] * 3, -1))
    >>> conjugate_gradients(path, np.array([1.0, 0, 0, 0]), 1e-10).non_zero
    array([1, 2, 3, 4])
    """
    from scipy.sparse.linalg import cg  # half a second: not before it is needed

    counts: list[int] = []
    solution, status = cg(
        matrix,
        right_hand_side,
        rtol=rtol,
        atol=0.0,
        maxiter=MOST_STEPS,
        callback=lambda iterate: counts.append(int(np.count_nonzero(iterate))),
    )
    return Iteration(
        np.asarray(solution), len(counts), np.array(counts, dtype=np.int64), status == 0
    )


def heat_matrix(diffusion: Discretization, time: float) -> csr_array:
    """Return ``M + t L``, L = -Δ positive semidefinite; 1 on the diagonal of lonely vertices."""
    matrix = csr_array(diags_array(diffusion.mass) + time * diffusion.stiffness)
    return csr_array(matrix + diags_array(np.where(matrix.diagonal() > 0, 0.0, 1.0)))


def rings(matrix: csr_array, source: int) -> FloatArray:
    """Return how many edges of the matrix each vertex is from `source`; ``inf`` if not at all."""
    pattern = csr_array(matrix)
    pattern.eliminate_zeros()
    steps = dijkstra(abs(pattern), directed=False, indices=[source], unweighted=True)
    return np.asarray(steps[0], dtype=np.float64)
