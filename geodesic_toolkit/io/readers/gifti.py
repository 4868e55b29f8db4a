"""GIFTI, the format of surfaces in neuroimaging and of vertex data, through nibabel."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.io.common import optional_package

__all__ = ["encode_gifti", "read_gifti", "read_gifti_numbers"]

LABEL_INTENT = 1002
"""Intent of an array of regions."""


def read_gifti(path: Path) -> Domain:
    """Read a GIFTI file that holds a surface: coordinates and triangles."""
    return as_domain(_image(path))


def read_gifti_numbers(path: Path) -> tuple[NDArray[Any], dict[str, int] | None]:
    """Return the number of each vertex, of shape (N,); for regions also their names."""
    image = _image(path)
    if len(image.darrays) != 1 or image.darrays[0].data.ndim != 1:
        raise ReadError("one number per vertex is needed, but the file holds other data")
    array = image.darrays[0]
    names = None
    if array.intent == LABEL_INTENT:
        table = image.labeltable.get_labels_as_dict()
        names = {str(name): int(key) for key, name in table.items()}
    return np.asarray(array.data), names


def encode_gifti(field: FloatArray, name: str) -> bytes:
    """Return a file of one number per vertex, in single precision as the format requires.

    `name` is the name of the file; its last part but one gives the kind: ``d.func.gii``.
    """
    gifti = optional_package("nibabel.gifti", "gii", "writing")
    function = name.lower().endswith(".func.gii")
    array = gifti.GiftiDataArray(
        field.astype(np.float32),
        intent="NIFTI_INTENT_NONE" if function else "NIFTI_INTENT_SHAPE",
        datatype="NIFTI_TYPE_FLOAT32",
        meta=gifti.GiftiMetaData({"Name": "geodesic distance"}),
    )
    encoded: bytes = gifti.GiftiImage(darrays=[array]).to_bytes()
    return encoded


def _image(path: Path) -> Any:
    return optional_package("nibabel.gifti", "gii").GiftiImage.from_filename(str(path))
