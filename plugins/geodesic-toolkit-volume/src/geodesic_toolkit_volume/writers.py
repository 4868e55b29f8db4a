"""Writers of distances with their solid: cells as VTU, images as NIfTI and VTI."""

import gzip
from pathlib import Path

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit.io.common import optional_package
from geodesic_toolkit.io.readers.vtk_library import write_by
from geodesic_toolkit_volume.marching import Floats
from geodesic_toolkit_volume.tet_mesh import TetMesh
from geodesic_toolkit_volume.voxel_image import VoxelImage

__all__ = ["CELLS", "NIFTI", "PACKED_NIFTI", "VTK_IMAGE"]


def _write_cells(path: Path, mesh: TetMesh, distances: Floats) -> None:
    meshio = optional_package("meshio", "vtu", "writing")
    written = meshio.Mesh(mesh.vertices, [("tetra", mesh.cells)], {"distance": distances})
    meshio.vtu.write(str(path), written)


def _write_nifti(path: Path, image: VoxelImage, distances: Floats) -> None:
    path.write_bytes(_nifti(image, distances))


def _write_packed_nifti(path: Path, image: VoxelImage, distances: Floats) -> None:
    path.write_bytes(gzip.compress(_nifti(image, distances), mtime=0))


def _nifti(image: VoxelImage, distances: Floats) -> bytes:
    nibabel = optional_package("nibabel", "nii", "writing")
    content = nibabel.Nifti1Image(distances.reshape(image.mask.shape), image.affine).to_bytes()
    return bytes(content)


def _write_vtk_image(path: Path, image: VoxelImage, distances: Floats) -> None:
    numpy_support = optional_package("vtkmodules.util.numpy_support", "vti", "writing")
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    data, sides = vtkImageData(), np.array(image.spacing)
    data.SetDimensions(*image.mask.shape)
    data.SetSpacing(*image.spacing)
    data.SetOrigin(*image.affine[:3, 3].tolist())
    data.SetDirectionMatrix(*(image.affine[:3, :3] / sides).ravel().tolist())
    first_axis_first = distances.reshape(image.mask.shape).transpose(2, 1, 0).ravel()
    array = numpy_support.numpy_to_vtk(first_axis_first, deep=True)
    array.SetName("distance")
    data.GetPointData().SetScalars(array)
    writer = vtkXMLImageDataWriter()
    writer.SetInputData(data)
    write_by(writer, path)


CELLS = gt.Writer(_write_cells, (TetMesh,), ("meshio",))
"""The cells, and the point data ``distance``, as .vtu."""

NIFTI = gt.Writer(_write_nifti, (VoxelImage,), ("nibabel",))
"""An image of float64 with the affine of the body, as .nii."""

PACKED_NIFTI = gt.Writer(_write_packed_nifti, (VoxelImage,), ("nibabel",))
"""The same, compressed: .nii.gz."""

VTK_IMAGE = gt.Writer(_write_vtk_image, (VoxelImage,), ("vtkmodules",))
"""An image with the point data ``distance``, as .vti."""
