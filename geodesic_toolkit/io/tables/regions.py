"""Vertices that a file of neuroimaging marks: labels, annotations, GIFTI."""

from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import InvalidOptionError, ReadError
from geodesic_toolkit.io.readers.freesurfer import read_annotation, read_label
from geodesic_toolkit.io.readers.gifti import read_gifti_numbers

__all__ = ["REGION_SUFFIXES", "read_region"]

REGION_SUFFIXES = (".label", ".annot", ".gii")

MAX_LISTED_REGIONS = 12
"""Regions that a message lists."""


def read_region(path: Path, region: str | None) -> tuple[IntArray, int | None]:
    """Return the vertices that are marked, and of how many, where the file says so.

    Parameters
    ----------
    path : Path
        A FreeSurfer label, which lists them; an annotation or a GIFTI label file, of which `region`
        is taken; or a GIFTI file of zeros and ones.
    region : str or None

    Raises
    ------
    ReadError
        The file holds something else.
    InvalidOptionError
        No such region; a region of a file that has none; none where there are several.
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
        raise ReadError("its numbers are other than 0 and 1, which would mark vertices")
    return np.flatnonzero(values), len(values)


def check_no_region(path: Path, region: str | None) -> None:
    """Raise an `InvalidOptionError` where a region is asked for and the file has none."""
    if region is not None:
        raise InvalidOptionError(f"{path.name} has no regions, and none called {region!r}")


def _of_region(
    path: Path, numbers: IntArray, names: dict[str, int], region: str | None
) -> IntArray:
    listed = ", ".join(list(names)[:MAX_LISTED_REGIONS]) + (
        " ..." if len(names) > MAX_LISTED_REGIONS else ""
    )
    if region is None:
        raise InvalidOptionError(
            f"{path.name} holds {len(names)} regions; say which by region: {listed}"
        )
    if region not in names:
        raise InvalidOptionError(f"{path.name} has no region {region!r}; it has {listed}")
    vertices = np.flatnonzero(numbers == names[region])
    if not len(vertices):
        raise ReadError(f"no vertex is in the region {region!r}")
    return vertices
