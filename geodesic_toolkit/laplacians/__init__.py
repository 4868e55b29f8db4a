"""Laplace operators: one file for each back end, all with one interface."""

from geodesic_toolkit.laplacians.base import LaplaceOperator

__all__ = ["LaplaceOperator"]
