"""Shapes with closed forms, and the contract as executable checks."""

from geodesic_toolkit.testing import shapes

__all__ = ["shapes"]
