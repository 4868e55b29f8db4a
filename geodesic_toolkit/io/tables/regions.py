"""Vertices that are marked by a file of neuroimaging: labels, annotations, GIFTI."""

from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import InvalidOptionError, ReadError
from geodesic_toolkit.io.readers.freesurfer import read_annotation, read_label
from geodesic_toolkit.io.readers.gifti import read_gifti_numbers

__all__ = ["REGION_SUFFIXES", "read_region"]

REGION_SUFFIXES = (".label", ".annot", ".gii")

MAX_LISTED_REGIONS = 12
"""Number of regions listed in a message."""


def read_region(path: Path, region: str | None) -> tuple[IntArray, int | None]:
    """Return the marked vertices, and the number of all vertices if the file states it.

    Parameters
    ----------
    path : Path
        A FreeSurfer label, which lists vertices; an annotation or a GIFTI label file, of which
        `region` is read; or a GIFTI file of zeros and ones.
    region : str or None

    Raises
    ------
    ReadError
        The file holds other data.
    InvalidOptionError
        The region does not exist, the file has no regions, or a region must be chosen.
    """
    if path.suffix.lower() == ".label":
        check_no_region(path, region)
        return read_label(path), None
    if path.suffix.lower() == ".annot":
        numbers, names = read_annotation(path)
        return _of_region(path, numbers, names, region), len(numbers)
    values, gifti_names = read_gifti_numbers(path)
    if gifti_names is not None:
        return _of_region(path, values.astype(np.int64), gifti_names, region), len(values)
    check_no_region(path, region)
    if not np.isin(values, (0, 1)).all():
        raise ReadError("its numbers must be 0 and 1 to mark vertices, but others occur")
    return np.flatnonzero(values), len(values)


def check_no_region(path: Path, region: str | None) -> None:
    """Raise an `InvalidOptionError` if a region is requested but the file has none."""
    if region is not None:
        raise InvalidOptionError(f"{path.name} has no regions: omit region={region!r}")


def _of_region(
    path: Path, numbers: IntArray, names: dict[str, int], region: str | None
) -> IntArray:
    listed = ", ".join(list(names)[:MAX_LISTED_REGIONS]) + (
        " ..." if len(names) > MAX_LISTED_REGIONS else ""
    )
    if region is None:
        raise InvalidOptionError(
            f"{path.name} holds {len(names)} regions; choose a region: {listed}"
        )
    if region not in names:
        raise InvalidOptionError(f"{path.name} has no region {region!r}; it has {listed}")
    vertices = np.flatnonzero(numbers == names[region])
    if not len(vertices):
        raise ReadError(f"the region {region!r} has no vertices")
    return vertices
