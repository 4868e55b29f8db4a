"""Geodesic distance inside solids, for geodesic-toolkit: tetrahedra and voxels, with costs."""

from geodesic_toolkit_volume.laplacians import TetLaplacian, VoxelLaplacian
from geodesic_toolkit_volume.tet_mesh import TetMesh
from geodesic_toolkit_volume.voxel_image import VoxelImage

__all__ = ["TetLaplacian", "TetMesh", "VoxelImage", "VoxelLaplacian"]
