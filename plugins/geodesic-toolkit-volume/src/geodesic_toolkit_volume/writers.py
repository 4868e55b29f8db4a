"""Writers of distances with their solid: cells as VTU, images as NIfTI and VTI."""

import gzip
import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.domains.base import as_floats
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.io import replacing
from geodesic_toolkit.io.common import optional_package
from geodesic_toolkit_volume.marching import Floats
from geodesic_toolkit_volume.tet_mesh import TetMesh
from geodesic_toolkit_volume.voxel_image import VoxelImage

__all__ = ["write_solid"]


def write_solid(
    path: str | os.PathLike[str], solid: TetMesh | VoxelImage, distances: ArrayLike
) -> None:
    """Write distances with the cells, or as an image; `gt.write` has the other formats.

    ============ ==================================================================
    .vtu         a `TetMesh`, its cells and the point data ``distance`` (meshio)
    .nii, nii.gz a `VoxelImage`, float64, with its affine (nibabel)
    .vti         a `VoxelImage`, the point data ``distance`` (vtk)
    ============ ==================================================================

    Parameters
    ----------
    path : str or path-like
        Replaced as a whole at the end.
    solid : TetMesh or VoxelImage
    distances : array-like of shape (N,)
        One per vertex or voxel; ``inf`` is kept.

    Raises
    ------
    InvalidOptionError
        A suffix that this kind of solid does not have.
    InvalidDomainError
        Distances of another shape.
    MissingDependencyError
        The format needs a package that is not installed.
    WriteError
        The file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_volume import VoxelImage, write_solid
    >>> image = VoxelImage(np.ones((4, 3, 2), dtype=bool))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "distance.nii.gz")
    ...     write_solid(file, image, gt.GeodesicSolver(image).distance(0))
    ...     gt.read(file)
    VoxelImage(4 x 3 x 2 voxels, 23 in the body)
    """
    file = Path(path)
    values = as_floats(distances, "distances", (solid.n_vertices,))
    suffix = ".nii.gz" if file.name.lower().endswith(".nii.gz") else file.suffix.lower()
    if isinstance(solid, TetMesh) and suffix == ".vtu":
        _write_vtu(file, solid, values)
    elif isinstance(solid, VoxelImage) and suffix in {".nii", ".nii.gz"}:
        _write_nifti(file, solid, values, packed=suffix == ".nii.gz")
    elif isinstance(solid, VoxelImage) and suffix == ".vti":
        _write_vti(file, solid, values)
    else:
        can = ".vtu" if isinstance(solid, TetMesh) else ".nii, .nii.gz, .vti"
        raise InvalidOptionError(
            f"{file}: a {type(solid).__name__} can be written as {can}; gt.write has other formats"
        )


def _write_vtu(file: Path, mesh: TetMesh, values: Floats) -> None:
    meshio = optional_package("meshio", "vtu", "writing")
    written = meshio.Mesh(mesh.vertices, [("tetra", mesh.cells)], {"distance": values})
    with replacing(file) as temporary:
        meshio.vtu.write(str(temporary), written)


def _write_nifti(file: Path, image: VoxelImage, values: Floats, *, packed: bool) -> None:
    nibabel = optional_package("nibabel", "nii", "writing")
    content = nibabel.Nifti1Image(values.reshape(image.mask.shape), image.affine).to_bytes()
    with replacing(file) as temporary:
        temporary.write_bytes(gzip.compress(content, mtime=0) if packed else content)


def _write_vti(file: Path, image: VoxelImage, values: Floats) -> None:
    numpy_support = optional_package("vtkmodules.util.numpy_support", "vti", "writing")
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    data, sides = vtkImageData(), np.array(image.spacing)
    data.SetDimensions(*image.mask.shape)
    data.SetSpacing(*image.spacing)
    data.SetOrigin(*image.affine[:3, 3].tolist())
    data.SetDirectionMatrix(*(image.affine[:3, :3] / sides).ravel().tolist())
    first_axis_first = values.reshape(image.mask.shape).transpose(2, 1, 0).ravel()
    array = numpy_support.numpy_to_vtk(first_axis_first, deep=True)
    array.SetName("distance")
    data.GetPointData().SetScalars(array)
    writer = vtkXMLImageDataWriter()
    with replacing(file) as temporary:
        writer.SetFileName(str(temporary))
        writer.SetInputData(data)
        writer.Write()
