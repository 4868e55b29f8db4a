"""Geodesic distances as estimators of scikit-learn, for samples of any dimension.

Imports scikit-learn, which takes a second: these names are not attributes of `geodesic_toolkit`.
"""

from geodesic_toolkit.sklearn.isomap import GeodesicIsomap
from geodesic_toolkit.sklearn.landmarks import GeodesicDistances
from geodesic_toolkit.sklearn.neighbors import GeodesicNeighbors

__all__ = ["GeodesicDistances", "GeodesicIsomap", "GeodesicNeighbors"]
