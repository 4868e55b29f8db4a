"""The tufted Laplacian as an operator of geodesic-toolkit: for shapes of any quality."""

from geodesic_toolkit_robust.tufted import RobustLaplacian

__all__ = ["RobustLaplacian"]
