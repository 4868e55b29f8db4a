"""Rims, where a surface ends, and triangles that are obtuse towards them.

An edge inside a surface is flipped where its opposite angles are more than π together. A rim edge
has no other side to be flipped with: an angle of more than π/2 opposite it gives it a weight of the
wrong sign, heat turns negative, and along a hull of slivers all functions are held to straight
lines. Glued to its mirror image along the rim, the surface has no rim, and flips in symmetric pairs
are possible. The obtuse triangle and its image become a kite with its other diagonal, which leads
from the obtuse corner to the image of that. The half of the kite on this side of the mirror is two
right triangles that meet in the foot of the perpendicular. As corner and image have one value, the
foot has it, too. Further flips make right trapezoids, with one value on each side that ends in the
mirror.

N. Sharp, K. Crane, *A Laplacian for Nonmanifold Triangle Meshes*, Computer Graphics Forum 39, 2020,
https://doi.org/10.1111/cgf.14069, glue so two copies of all triangles; here only those that change
are touched.
"""

from typing import NamedTuple

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.triangles import measured_by_lengths

__all__ = ["Trapezoids", "mirrored_at_rims", "rim_cotangents", "rim_edges"]

COTANGENT_TOLERANCE = 1e-10
"""Cotangent below zero from which on an angle is obtuse: no rounding must make it so."""


class Trapezoids(NamedTuple):
    """Right trapezoids between an edge and the mirror, or triangles where a side has no length.

    Attributes
    ----------
    tails, heads : ndarray of shape (T,), int64
        The vertices of the edge, seen from which the mirror lies on the right.
    widths : ndarray of shape (T,), float64
        How far the sides, which end in the mirror, are apart.
    tail_sides, head_sides : ndarray of shape (T,), float64
        How long the sides are: how far the vertices are from the mirror.
    beyond : ndarray of shape (T,), int64
        The half-edge of the triangle on the other side of the edge, or -1.
    within : ndarray of shape (T,), int64
        The half-edge of the triangle in whose place it lies, which runs from head to tail.
    """

    tails: IntArray
    heads: IntArray
    widths: FloatArray
    tail_sides: FloatArray
    head_sides: FloatArray
    beyond: IntArray
    within: IntArray

    def only(self, chosen: BoolArray) -> "Trapezoids":
        """Return some of them."""
        return Trapezoids._make(column[chosen] for column in self)

    @staticmethod
    def together(parts: "list[Trapezoids]") -> "Trapezoids":
        """Return those of several."""
        return Trapezoids._make(np.concatenate(columns) for columns in zip(*parts, strict=True))


def rim_edges(faces: IntArray, boundary: BoolArray) -> IntArray:
    """Return the half-edges ``3 f + c``, opposite corner c of face f, that have an edge alone.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
    boundary : ndarray of shape (N,), bool
        Whether a vertex is at the end of one.
    """
    beside = _native.faces_at(faces, boundary)
    at = boundary[faces[beside]]
    found = np.flatnonzero(at[:, [1, 2, 0]] & at[:, [2, 0, 1]])
    candidates = 3 * beside[found // 3] + found % 3
    edges = _edge_numbers(faces, candidates, len(boundary))
    _, first, count = np.unique(edges, return_index=True, return_counts=True)
    return np.asarray(candidates[np.sort(first[count == 1])])


def _edge_numbers(faces: IntArray, halves: IntArray, n_vertices: int) -> IntArray:
    """Return a number for the edge of each half-edge, the same for those of the same ends."""
    corners = faces.ravel()
    tails, heads = corners[_next(halves)], corners[_before(halves)]
    return np.asarray(np.minimum(tails, heads) * n_vertices + np.maximum(tails, heads))


def rim_cotangents(lengths: FloatArray, halves: IntArray) -> FloatArray:
    """Return the cotangents of the angles opposite half-edges.

    Parameters
    ----------
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.
    halves : ndarray of shape (R,), int64

    Returns
    -------
    ndarray of shape (R,)
    """
    edge, along, up = _apexes(lengths, halves)
    return np.asarray(_cotangents(edge, along, up))


def mirrored_at_rims(
    faces: IntArray, lengths: FloatArray, twin: IntArray
) -> tuple[BoolArray, Trapezoids]:
    """Return the intrinsic Delaunay triangulation of a surface and its mirror image, halved.

    Only rims change, as nothing else has another neighbour than it had: where the corner beyond an
    edge lies within the circle about that edge and its image, the triangle goes, and there are two
    trapezoids in the place of one.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        Intrinsically Delaunay away from rims.
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.
    twin : ndarray of shape (3 F,), int64
        The half-edge that each is glued to, or -1: at rims, at edges of more than two faces, and
        where a one-sided surface was cut. The surface is mirrored at all of them.

    Returns
    -------
    kept : ndarray of shape (F,), bool
        The triangles that stay.
    trapezoids : Trapezoids
        What lies between them and the mirror, of which each has an area.
    """
    kept = np.ones(len(faces), dtype=np.bool_)
    rims = np.flatnonzero(twin < 0)
    corners, none = faces.ravel(), np.zeros(len(rims))
    tails, heads = corners[_next(rims)], corners[_before(rims)]
    found = Trapezoids(tails, heads, lengths.ravel()[rims], none, none, rims, rims)
    done = [found.only(np.zeros(len(rims), dtype=np.bool_))]
    while len(found.widths):
        opens, feet, sides = _openings(found, lengths, kept)
        done.append(found.only(~opens))
        found, foot, side = found.only(opens), feet[opens], sides[opens]
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


def _openings(
    found: Trapezoids, lengths: FloatArray, kept: BoolArray
) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Return which trapezoids are to take the triangles beyond them, one each.

    Also where on the mirror the corners of those lie, from the tail's side on, and how far from it.
    """
    opens = found.beyond >= 0
    faces = np.where(opens, found.beyond // 3, 0)
    opens &= kept[faces]  # or else they are neighbours of a trapezoid, and no flip is due
    edge, along, up = _apexes(lengths, np.where(opens, found.beyond, 0))
    rise, run = (found.head_sides - found.tail_sides) / edge, found.widths / edge
    feet = along * run - up * rise
    sides = found.tail_sides + along * rise + up * run
    facing = (found.tail_sides + found.head_sides) / found.widths  # cotangent seen from an image
    excess = _cotangents(edge, along, up) + facing
    opens &= (excess < -COTANGENT_TOLERANCE) & (feet > 0) & (feet < found.widths)
    order = np.lexsort((np.where(opens, excess, np.inf), faces))
    later = np.zeros(len(order), dtype=np.bool_)
    later[order[1:]] = faces[order[1:]] == faces[order[:-1]]
    return opens & ~later, feet, sides


def _apexes(lengths: FloatArray, halves: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the lengths of half-edges, and where the corners opposite lie: along it and aside."""
    own = lengths.ravel()
    edge, to_head, to_tail = own[halves], own[_next(halves)], own[_before(halves)]
    along = (edge**2 + (to_tail - to_head) * (to_tail + to_head)) / (2 * edge)
    _, areas = measured_by_lengths(lengths[halves // 3])
    return edge, along, 2 * areas / edge


def _cotangents(edge: FloatArray, along: FloatArray, up: FloatArray) -> FloatArray:
    return np.asarray((up**2 - along * (edge - along)) / (edge * up))


def _next(halves: IntArray) -> IntArray:
    """Return the half-edges that follow about their triangles."""
    return np.asarray(halves - halves % 3 + (halves + 1) % 3)


def _before(halves: IntArray) -> IntArray:
    return np.asarray(halves - halves % 3 + (halves + 2) % 3)
