"""Supernodal sparse Cholesky.

The road from a matrix to a solution, one module a step:

1. `_ordering`: a permutation that keeps the factor sparse (approximate minimum degree).
2. `_elimination`: what the factor will look like (elimination tree, column counts, supernodes).
3. `analysis`: the two above as data, for all matrices of one pattern.
4. `_numeric`: the factor (multifrontal, dense Cholesky in `_front` on each supernode).
5. `_solve`: forward and back substitution, one column or a block.
6. `solver`: the :class:`~geodesic_toolkit.linear.base.LinearSolver` over all of it.

References
----------
T. A. Davis, S. Rajamanickam, W. M. Sid-Lakhdar, *A survey of direct methods for sparse linear
systems*, Acta Numerica 25, 2016, https://doi.org/10.1017/S0962492916000076
"""

from geodesic_toolkit.linear.supernodal.solver import Supernodal

__all__ = ["Supernodal"]
