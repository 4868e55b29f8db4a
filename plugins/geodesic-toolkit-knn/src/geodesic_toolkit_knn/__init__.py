"""Samples in any dimension as a kind of domain of geodesic-toolkit, by their nearest neighbours."""

from geodesic_toolkit_knn.annotated import from_anndata, to_anndata
from geodesic_toolkit_knn.dimension import intrinsic_dimension
from geodesic_toolkit_knn.domain import KNNGraph
from geodesic_toolkit_knn.operator import HighDimensionWarning, KNNLaplacian

__all__ = [
    "HighDimensionWarning",
    "KNNGraph",
    "KNNLaplacian",
    "from_anndata",
    "intrinsic_dimension",
    "to_anndata",
]
