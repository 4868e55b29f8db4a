"""GIFTI surfaces of neuroimaging, through nibabel."""

from pathlib import Path

from geodesic_toolkit.conversion import as_domain
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.io.common import optional_package

__all__ = ["read_gifti"]


def read_gifti(path: Path) -> Domain:
    """Read a GIFTI file that holds a surface: coordinates and triangles."""
    image = optional_package("nibabel.gifti", "gii").GiftiImage.from_filename(str(path))
    return as_domain(image)
