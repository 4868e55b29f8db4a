"""Polygons and strips as triangles.

Polygons are given by their sizes and by their corners, one polygon after the other.
"""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["split_polygons", "strip_triangles", "triangles_inside", "unpadded_polygons"]

MAX_LISTED_POLYGONS = 5
"""Maximum number of polygons named in a remark."""


def split_polygons(
    vertices: FloatArray, sizes: IntArray, corners: IntArray
) -> tuple[IntArray, list[str]]:
    """Split polygons into triangles inside them.

    A convex polygon becomes the fan of its first corner.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    sizes : ndarray of shape (P,), int64
        Number of corners of each polygon.
    corners : ndarray of shape (sizes.sum(),), int64
        Vertex indices of the corners, polygon by polygon.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        The triangles of a polygon follow each other.
    remarks : list of str
        Remarks for users on polygons that were split, polygons that cross themselves, and faces of
        fewer than three corners.

    Raises
    ------
    MissingDependencyError
        A polygon of more than four corners is not convex, and manifold3d is not installed.
    """
    faces, crossing = triangles_inside(vertices, sizes, corners)
    polygons, degenerate = int((sizes > 3).sum()), int((sizes < 3).sum())
    remarks = []
    if polygons:
        plural = "polygon was" if polygons == 1 else "polygons were"
        remarks.append(
            f"{polygons} {plural} split into {(sizes[sizes > 3] - 2).sum()} triangles; "
            "face indices count the triangles"
        )
        if crossing:
            remarks.append(_crossing_remark(crossing))
    if degenerate:
        remarks.append(f"{degenerate} faces have fewer than three corners and were dropped")
    return faces, remarks


def triangles_inside(
    vertices: FloatArray, sizes: IntArray, corners: IntArray
) -> tuple[IntArray, list[int]]:
    """Split polygons into triangles inside them, without a remark.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    sizes : ndarray of shape (P,), int64
        Corners of each polygon.
    corners : ndarray of shape (sizes.sum(),), int64
        Their vertex indices, polygon by polygon.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        The triangles of a polygon follow each other: two fewer than it has corners.
    crossing : list of int
        The polygons that cross themselves, whose triangles overlap.

    Raises
    ------
    MissingDependencyError
        As for :func:`split_polygons`.
    """
    corners = _with_equal_repeats(sizes, corners)
    faces = _fans(sizes, corners)
    if not (sizes > 3).any():
        return faces, []
    from geodesic_toolkit.geometry.concave import correct_fans

    return faces, correct_fans(vertices, sizes, corners, faces)


def _fans(sizes: IntArray, corners: IntArray) -> IntArray:
    """Return the fans of the first corners of polygons."""
    counts = np.maximum(sizes - 2, 0)
    owner = np.repeat(np.arange(len(sizes)), counts)
    first = (np.cumsum(sizes) - sizes)[owner]
    step = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
    faces = np.column_stack([corners[first], corners[first + step + 1], corners[first + step + 2]])
    return faces.astype(np.int64)


def _crossing_remark(crossing: list[int]) -> str:
    named = ", ".join(map(str, crossing[:MAX_LISTED_POLYGONS]))
    if len(crossing) == 1:
        subject = f"polygon {named} crosses itself: its"
    else:
        more = (
            f" and {len(crossing) - MAX_LISTED_POLYGONS} more"
            if len(crossing) > MAX_LISTED_POLYGONS
            else ""
        )
        subject = f"polygons {named}{more} cross themselves: their"
    return (
        f"{subject} triangles overlap, and distances there are not those of the shape; correct the "
        "corners (polygons are counted from 0)"
    )


def _with_equal_repeats(sizes: IntArray, corners: IntArray) -> IntArray:
    """Return the corners, with those of a repeated polygon equal to those of its first copy.

    So the back and the front of a polygon are split into the same triangles, which count once.
    """
    begins = np.cumsum(sizes) - sizes
    result = corners
    for size in np.unique(sizes[sizes > 3]).tolist():
        own = begins[sizes == size]
        rows = own[:, None] + np.arange(size)
        ring = corners[rows]
        least = ring.argmin(axis=1)[:, None]
        ahead = np.take_along_axis(ring, (least + np.arange(size)) % size, axis=1)
        back = np.take_along_axis(ring, (least - np.arange(size)) % size, axis=1)
        same_way = np.where((ahead[:, 1] <= back[:, 1])[:, None], ahead, back)
        order = np.lexsort(same_way.T)  # stable: the first of equal polygons leads
        new = np.ones(len(order), dtype=np.bool_)
        new[1:] = (same_way[order[1:]] != same_way[order[:-1]]).any(axis=1)
        if new.all():
            continue
        leader = np.empty(len(order), dtype=np.int64)
        leader[order] = order[new][np.cumsum(new) - 1]
        result = result.copy() if result is corners else result
        result[rows] = ring[leader]
    return result


def strip_triangles(sizes: IntArray, indices: IntArray) -> IntArray:
    """Return the triangles of strips; -1 begins a new strip, and every second triangle is reversed.

    Triangles with a repeated vertex join strips, and are not faces.
    """
    ends = np.cumsum(sizes)
    strip = np.repeat(np.arange(len(sizes)), sizes)
    cut = indices == -1
    strip = strip + np.cumsum(cut)
    # Position in the strip, whose first entry follows a cut or is the first of its list.
    starts = np.zeros(len(indices), dtype=bool)
    starts[(ends - sizes)[sizes > 0]] = True
    starts[1:] |= cut[:-1]
    entries = np.arange(len(indices))
    position = entries - np.maximum.accumulate(np.where(starts, entries, 0))
    a, b, c = indices[:-2], indices[1:-1], indices[2:]
    odd = position[:-2] % 2 == 1
    faces = np.column_stack([np.where(odd, b, a), np.where(odd, a, b), c])
    whole = ~cut[:-2] & ~cut[1:-1] & ~cut[2:] & (strip[:-2] == strip[2:])
    joint = (a == b) | (b == c) | (c == a)
    kept: IntArray = faces[whole & ~joint]
    return kept


def unpadded_polygons(row: IntArray) -> tuple[IntArray, IntArray]:
    """Return sizes and corners of polygons that each follow their size: ``3 a b c 4 ...``."""
    step = int(row[0]) + 1 if len(row) else 1
    if len(row) % step == 0 and (row[::step] == step - 1).all():  # all have one size
        table = row.reshape(-1, step)
        return table[:, 0].astype(np.int64), table[:, 1:].ravel().astype(np.int64)
    heads, head = [], 0
    while head < len(row):
        heads.append(head)
        head += 1 + int(row[head])
    return row[heads].astype(np.int64), np.delete(row, heads).astype(np.int64)
