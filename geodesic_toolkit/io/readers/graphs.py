"""Sparse matrices of edge lengths (mtx, npz), and archives of arrays (npz)."""

import io
from pathlib import Path

import numpy as np
from scipy import sparse

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain, Graph, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.interop.conversion import graph_of_lengths
from geodesic_toolkit.io.common import cloud, integers, text_of, whole_numbers
from geodesic_toolkit.io.tables.rows import number_table

__all__ = ["read_mtx", "read_npz"]

SIZES = {"coordinate": 3, "array": 2}
"""Number of entries in the line of sizes."""


def read_mtx(path: Path) -> Graph:
    """Read a Matrix Market file as the edge lengths of a graph.

    Not by SciPy's reader, which crashes the process on some damaged files.
    """
    banner, *lines = text_of(path).decode("latin-1").splitlines()
    words = banner.lower().split()
    if len(words) != 5 or words[:2] != ["%%matrixmarket", "matrix"]:
        raise ReadError('not a Matrix Market file: it does not begin with "%%MatrixMarket matrix"')
    form, numbers, symmetry = words[2:]
    if (
        form not in SIZES
        or numbers not in {"real", "integer", "pattern", "double"}
        or symmetry not in {"general", "symmetric"}
    ):
        raise ReadError(f"a {' '.join(words[2:])} matrix cannot hold edge lengths")
    lines = [line for line in lines if line.strip() and not line.startswith("%")]
    sizes = integers([word.encode() for word in " ".join(lines[:1]).split()], "the sizes")
    if len(sizes) != SIZES[form] or (sizes < 0).any():
        raise ReadError(f"the sizes of the matrix are {' '.join(lines[:1])[:80]!r}")
    if form == "array":
        dense = _dense(lines[1:], *sizes.tolist(), symmetric=symmetry == "symmetric")
        return graph_of_lengths(sparse.coo_array(dense))
    if len(lines) - 1 != sizes[2]:
        raise ReadError(f"{sizes[2]} entries are announced, but {len(lines) - 1} follow")
    width = 2 if numbers == "pattern" else 3
    table = number_table(lines[1:]) if sizes[2] else np.empty((0, width))
    if table.shape[1] != width:
        raise ReadError(f"entries have {table.shape[1]} columns, not {width}")
    indices = whole_numbers(table[:, :2], "row and column numbers") - 1
    bad = np.flatnonzero((indices < 0).any(axis=1) | (indices >= sizes[:2]).any(axis=1))
    if len(bad):
        raise ReadError(f"entry {bad[0]} lies outside a matrix of {sizes[0]} x {sizes[1]}")
    lengths = table[:, 2] if width == 3 else np.ones(len(table))
    return graph_of_lengths(
        sparse.coo_array((lengths, tuple(indices.T)), shape=tuple(sizes[:2].tolist()))
    )


def _dense(lines: list[str], n_rows: int, n_columns: int, *, symmetric: bool) -> FloatArray:
    """Return a matrix listed column by column; only its lower triangle if symmetric."""
    n_entries = n_columns * (n_columns + 1) // 2 if symmetric else n_rows * n_columns
    if len(lines) != n_entries or not lines or (symmetric and n_rows != n_columns):
        raise ReadError(f"{n_rows} x {n_columns} entries are announced, but {len(lines)} follow")
    values = number_table(lines)
    if values.shape[1] != 1:
        raise ReadError(f"entries have {values.shape[1]} columns, not 1")
    matrix = np.zeros((n_columns, n_rows))
    if symmetric:
        matrix[np.triu_indices(n_columns)] = values[:, 0]
    else:
        matrix[:] = values.reshape(n_columns, n_rows)
    return matrix.T


def read_npz(path: Path) -> Domain:
    """Read an npz archive.

    It holds a sparse matrix of edge lengths as written by ``scipy.sparse.save_npz``, or arrays
    ``vertices`` and ``faces``, or ``points`` and optionally ``normals``.
    """
    data = path.read_bytes()
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise ReadError("not an npz archive")
        names = set(archive.files)
        if {"vertices", "faces"} <= names:
            return TriangleMesh(archive["vertices"], archive["faces"])
        if "points" in names:
            return cloud(
                path, archive["points"], archive["normals"] if "normals" in names else None
            )
    if "format" not in names:
        raise ReadError(
            f"the archive holds {', '.join(sorted(names))[:80] or 'nothing'}, but not a sparse "
            "matrix, nor vertices and faces, nor points"
        )
    matrix = sparse.load_npz(io.BytesIO(data))
    if hasattr(matrix, "check_format"):
        matrix.check_format(full_check=True)  # SciPy would use indices out of range unchecked
    return graph_of_lengths(matrix)
