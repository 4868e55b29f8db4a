"""Rims, where a surface ends, and triangles that are obtuse towards them.

An edge inside a surface is flipped if the sum of its opposite angles is more than π. A rim edge has
only one triangle and cannot be flipped: an angle of more than π/2 opposite it gives it a weight of
the wrong sign, heat turns negative, and along a hull of slivers all functions are forced to be
linear. If the surface is glued to its mirror image along the rim, the rim disappears, and flips in
symmetric pairs are possible. The obtuse triangle and its image form a kite, which gets its other
diagonal, from the obtuse corner to its image. The half of the kite on this side of the mirror is
two right triangles that meet at the foot of the perpendicular. As corner and image have equal
values, the foot has the same value. Further flips make right trapezoids, with one value on each
side that ends in the mirror.

N. Sharp, K. Crane, *A Laplacian for Nonmanifold Triangle Meshes*, Computer Graphics Forum 39, 2020,
https://doi.org/10.1111/cgf.14069, glue two copies of all triangles in this way; here only the
triangles that change are processed.
"""

from typing import NamedTuple

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.triangles import measured_by_lengths

__all__ = ["Trapezoids", "mirrored_at_rims", "rim_cotangents", "rim_edges"]

COTANGENT_TOLERANCE = 1e-10
"""Negative cotangent above which an angle is obtuse, so that rounding does not make it so."""


class Trapezoids(NamedTuple):
    """Right trapezoids between an edge and the mirror, or triangles if a side has length 0.

    Attributes
    ----------
    tails, heads : ndarray of shape (T,), int64
        The vertices of the edge, directed so that the mirror is on its right.
    widths : ndarray of shape (T,), float64
        The distance of the parallel sides, which end in the mirror.
    tail_sides, head_sides : ndarray of shape (T,), float64
        The lengths of these sides: the distances of the vertices from the mirror.
    beyond : ndarray of shape (T,), int64
        The half-edge of the triangle beyond the edge, or -1.
    within : ndarray of shape (T,), int64
        The half-edge of the replaced triangle, from head to tail.
    """

    tails: IntArray
    heads: IntArray
    widths: FloatArray
    tail_sides: FloatArray
    head_sides: FloatArray
    beyond: IntArray
    within: IntArray

    def only(self, chosen: BoolArray) -> "Trapezoids":
        """Return the chosen trapezoids."""
        return Trapezoids._make(column[chosen] for column in self)

    @staticmethod
    def together(parts: "list[Trapezoids]") -> "Trapezoids":
        """Return the trapezoids of several parts."""
        return Trapezoids._make(np.concatenate(columns) for columns in zip(*parts, strict=True))


def rim_edges(faces: IntArray, boundary: BoolArray) -> IntArray:
    """Return the half-edges ``3 f + c``, opposite corner c of face f, of edges of one face.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
    boundary : ndarray of shape (N,), bool
        True for vertices at the ends of such edges.
    """
    beside = _native.faces_at(faces, boundary)
    at = boundary[faces[beside]]
    found = np.flatnonzero(at[:, [1, 2, 0]] & at[:, [2, 0, 1]])
    candidates = 3 * beside[found // 3] + found % 3
    edges = _edge_numbers(faces, candidates, len(boundary))
    _, first, count = np.unique(edges, return_index=True, return_counts=True)
    return np.asarray(candidates[np.sort(first[count == 1])])


def _edge_numbers(faces: IntArray, half_edges: IntArray, n_vertices: int) -> IntArray:
    """Return a number for the edge of each half-edge, equal for half-edges with the same ends."""
    corners = faces.ravel()
    tails, heads = corners[_next(half_edges)], corners[_before(half_edges)]
    return np.asarray(np.minimum(tails, heads) * n_vertices + np.maximum(tails, heads))


def rim_cotangents(lengths: FloatArray, half_edges: IntArray) -> FloatArray:
    """Return the cotangents of the angles opposite half-edges.

    Parameters
    ----------
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.
    half_edges : ndarray of shape (R,), int64

    Returns
    -------
    ndarray of shape (R,)
    """
    edge, along, up = _apexes(lengths, half_edges)
    return np.asarray(_cotangents(edge, along, up))


def mirrored_at_rims(
    faces: IntArray, lengths: FloatArray, twin: IntArray
) -> tuple[BoolArray, Trapezoids]:
    """Return half of the intrinsic Delaunay triangulation of a surface and its mirror image.

    Only triangles at rims change, because others keep their neighbours. If the corner beyond an
    edge lies in the circle through that edge and its image, the triangle is removed, and two
    trapezoids replace one.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        Intrinsically Delaunay away from rims.
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.
    twin : ndarray of shape (3 F,), int64
        The half-edge that each half-edge is glued to, or -1: at rims, at edges of more than two
        faces, and at cuts of one-sided surfaces. The surface is mirrored at all of these.

    Returns
    -------
    kept : ndarray of shape (F,), bool
        The triangles that stay.
    trapezoids : Trapezoids
        The trapezoids between the triangles and the mirror, each with an area.
    """
    kept = np.ones(len(faces), dtype=np.bool_)
    rims = np.flatnonzero(twin < 0)
    corners, none = faces.ravel(), np.zeros(len(rims))
    tails, heads = corners[_next(rims)], corners[_before(rims)]
    found = Trapezoids(tails, heads, lengths.ravel()[rims], none, none, rims, rims)
    done = [found.only(np.zeros(len(rims), dtype=np.bool_))]
    while len(found.widths):
        absorbs, feet, sides = _absorbed_triangles(found, lengths, kept)
        done.append(found.only(~absorbs))
        found, foot, side = found.only(absorbs), feet[absorbs], sides[absorbs]
        half = found.beyond
        apex = corners[half]
        kept[half // 3] = False
        before, after = _before(half), _next(half)
        one = found._replace(
            heads=apex, widths=foot, head_sides=side, beyond=twin[before], within=before
        )
        rest = found.widths - foot
        other = found._replace(
            tails=apex, widths=rest, tail_sides=side, beyond=twin[after], within=after
        )
        found = Trapezoids.together([one, other])
    found = Trapezoids.together(done)
    return kept, found.only(found.tail_sides + found.head_sides > 0)


def _absorbed_triangles(
    found: Trapezoids, lengths: FloatArray, kept: BoolArray
) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Return a mask of the trapezoids that absorb the triangle beyond them, each a different one.

    Return also the positions on the mirror of the corners of these triangles, measured from the
    side at the tail, and the distances of the corners from the mirror.
    """
    absorbs = found.beyond >= 0
    faces = np.where(absorbs, found.beyond // 3, 0)
    absorbs &= kept[faces]  # removed ones are trapezoids already
    edge, along, up = _apexes(lengths, np.where(absorbs, found.beyond, 0))
    rise, run = (found.head_sides - found.tail_sides) / edge, found.widths / edge
    feet = along * run - up * rise
    sides = found.tail_sides + along * rise + up * run
    facing = (found.tail_sides + found.head_sides) / found.widths  # cotangent seen from an image
    excess = _cotangents(edge, along, up) + facing
    absorbs &= (excess < -COTANGENT_TOLERANCE) & (feet > 0) & (feet < found.widths)
    order = np.lexsort((np.where(absorbs, excess, np.inf), faces))
    later = np.zeros(len(order), dtype=np.bool_)
    later[order[1:]] = faces[order[1:]] == faces[order[:-1]]
    return absorbs & ~later, feet, sides


def _apexes(lengths: FloatArray, half_edges: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the lengths of half-edges, and the positions of opposite corners: along and aside."""
    own = lengths.ravel()
    edge, to_head, to_tail = own[half_edges], own[_next(half_edges)], own[_before(half_edges)]
    along = (edge**2 + (to_tail - to_head) * (to_tail + to_head)) / (2 * edge)
    _, areas = measured_by_lengths(lengths[half_edges // 3])
    return edge, along, 2 * areas / edge


def _cotangents(edge: FloatArray, along: FloatArray, up: FloatArray) -> FloatArray:
    return np.asarray((up**2 - along * (edge - along)) / (edge * up))


def _next(half_edges: IntArray) -> IntArray:
    """Return the next half-edges of the same triangles."""
    return np.asarray(half_edges - half_edges % 3 + (half_edges + 1) % 3)


def _before(half_edges: IntArray) -> IntArray:
    return np.asarray(half_edges - half_edges % 3 + (half_edges + 2) % 3)
