"""FreeSurfer's surfaces, labels and annotations, through nibabel.

The files of a surface have no suffix of their own: ``lh.pial``, ``rh.white``, ``lh.pial.T1``. They
are recognised by their first bytes, not by their names.
"""

import warnings
from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import lines_of, optional_package

__all__ = ["is_surface", "read_annotation", "read_label", "read_surface"]

TRIANGLES, QUADRANGLES, NEW_QUADRANGLES = b"\xff\xff\xfe", b"\xff\xff\xff", b"\xff\xff\xfd"
BYTES_A_COORDINATE = {QUADRANGLES: 2, NEW_QUADRANGLES: 4}
MAGIC = 3
HEADER = 9


def is_surface(path: Path) -> bool:
    """Return whether a file begins as a FreeSurfer surface, or as FreeSurfer's vertex data."""
    with path.open("rb") as file:
        return file.read(MAGIC) in {TRIANGLES, QUADRANGLES, NEW_QUADRANGLES}


def read_surface(path: Path) -> TriangleMesh:
    """Read a surface of triangles, or an old one of quadrangles, which nibabel splits."""
    data = path.read_bytes()
    _check_sizes(data)
    nibabel = optional_package("nibabel.freesurfer", path.suffix[1:])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # nibabel warns about headers that are not used here
        vertices, faces = nibabel.read_geometry(str(path))
    return TriangleMesh(vertices, faces)


def _check_sizes(data: bytes) -> None:
    """Raise if the counts in the header do not fit the file: nibabel does not check them."""
    magic = data[:MAGIC]
    if magic == TRIANGLES:
        start = data.find(b"\n\n")
        if start < 0:
            raise ReadError("not a FreeSurfer surface: its header has no end")
        counts = np.frombuffer(data[start + 2 : start + 10].ljust(8, b"\0"), ">i4").tolist()
        needed = start + 10 + 12 * sum(counts)
    elif magic in BYTES_A_COORDINATE:
        if magic == QUADRANGLES and _is_morphometry(data):
            raise ReadError("it holds a number for each vertex, not a surface")
        counts = [int.from_bytes(data[at : at + 3], "big") for at in (MAGIC, MAGIC + 3)]
        needed = HEADER + 3 * BYTES_A_COORDINATE[magic] * counts[0] + 12 * counts[1]
    else:
        raise ReadError("not a FreeSurfer surface: it begins with other bytes")
    if min(counts) < 0 or needed > len(data):
        raise ReadError(
            f"{counts[0]} vertices and {counts[1]} faces are announced, more than the file holds"
        )


def _is_morphometry(data: bytes) -> bool:
    """Return whether a file holds vertex data such as thickness; its header fits quadrangles."""
    n_vertices, _, n_values = np.frombuffer(data[MAGIC : MAGIC + 12].ljust(12, b"\0"), ">i4")
    return len(data) == MAGIC + 12 + 4 * int(n_vertices) * int(n_values)


def read_label(path: Path) -> IntArray:
    """Return the vertices listed in a label, of shape (K,)."""
    lines = lines_of(path)  # the first line is a comment
    n_vertices = int(lines[0])
    if len(lines) - 1 != n_vertices or n_vertices == 0:
        raise ReadError(f"the label announces {n_vertices} vertices, but {len(lines) - 1} follow")
    vertices = optional_package("nibabel.freesurfer", "label").read_label(str(path))
    return np.atleast_1d(vertices).astype(np.int64)


def read_annotation(path: Path) -> tuple[IntArray, dict[str, int]]:
    """Return the region of each vertex, of shape (N,), and the numbers of the regions by name."""
    nibabel = optional_package("nibabel.freesurfer", "annot")
    regions, _, names = nibabel.read_annot(str(path))
    return np.asarray(regions, dtype=np.int64), {
        name.decode("utf-8", "replace"): number for number, name in enumerate(names)
    }
