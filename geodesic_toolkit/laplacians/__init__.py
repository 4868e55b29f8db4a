"""Laplace operators: one back end a file, all behind one contract."""

from geodesic_toolkit.laplacians.base import LaplaceOperator

__all__ = ["LaplaceOperator"]
