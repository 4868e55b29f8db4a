"""The shortest way through a strip of triangles, and through the strips beside it.

A strip is a list of faces, each sharing an edge with the next. Unfolded into the plane, the
shortest way through it from one corner to another is found by the funnel algorithm. Where that
bends around a vertex and the surface on the other side of it spans less than π, the way around the
other side is shorter (S.-Q. Xin, G.-J. Wang, *Efficiently determining a locally exact shortest
path on polyhedral surfaces*, Computer-Aided Design 39, 2007,
https://doi.org/10.1016/j.cad.2007.08.001). When no bend is left of that kind the way is a geodesic.
"""

import cmath
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geodesic_toolkit.geometry.fans import Fans

__all__ = ["Way", "beside_cones", "shortest_way"]

MAX_TURNS = 10_000
"""Changes of side after which a way is taken as it is: each made it shorter all the same."""

STRAIGHT = 1e-9
"""Angle, in radians, within which a bend is none."""

SHORTER = 1e-13
"""Share of the length by which a way must be shorter to be another one."""

POINTED = 0.25
"""Angle, in radians, that is missing to 2π at a pointed vertex."""

MAX_CONES = 16
"""The most pointed vertices along a way whose other side is tried."""


@dataclass(frozen=True)
class Way:
    """A straightest line through a strip.

    Attributes
    ----------
    strip : list of int
        Faces, one or more.
    crossings : list of (face, mapping of vertex to weight)
        Its points from start to end: the start, where it crosses each edge, the end.
    length : float
    bends : list of (vertex, portal, angle)
        Vertices that it bends around: the edge of the strip, by number, at which it does, and the
        angle on the strip's side.
    """

    strip: list[int]
    crossings: list[tuple[int, dict[int, float]]]
    length: float
    bends: list[tuple[int, int, float]]


def shortest_way(fans: Fans, strip: list[int], start: int, end: int) -> Way:
    """Return the way from a corner of the first face to one of the last, made a geodesic.

    Parameters
    ----------
    fans : Fans
    strip : list of int
    start, end : int
        Vertices.

    Returns
    -------
    Way
    """
    best = _straightened(fans, _without_returns(strip), start, end)
    tried: set[tuple[int, ...]] = set()
    for _ in range(MAX_TURNS):
        shorter = _turned(fans, best, start, end, tried)
        if shorter is None:
            break
        best = shorter
    return best


def beside_cones(fans: Fans, way: Way, start: int, end: int) -> Way:
    """Return a shorter geodesic, if there is one on the other side of a pointed vertex.

    A geodesic passes a vertex of less than 2π on one side or on the other, and neither way can be
    pulled over it.

    Parameters
    ----------
    fans : Fans
    way : Way
        As `shortest_way` returned it.
    start, end : int

    Returns
    -------
    Way
    """
    best: Way | None = way
    while best is not None:
        way, best = best, None
        for vertex, portal in _cones(fans, way.strip):
            run = _run_around(fans, way.strip, vertex, portal)
            other = _other_side(fans, way.strip, vertex, run)
            if other is None:
                continue
            candidate = shortest_way(fans, other, start, end)
            if candidate.length < way.length * (1 - SHORTER):
                best = candidate
                break
    return way


def _cones(fans: Fans, strip: list[int]) -> list[tuple[int, int]]:
    """Return the most pointed vertices of the inner edges of a strip: (vertex, edge's number)."""
    portals: dict[int, int] = {}
    for portal, (face, following) in enumerate(pairwise(strip)):
        for vertex in set(fans.faces[face].tolist()) & set(fans.faces[following].tolist()):
            portals[vertex] = portal
    sharp = [(fans.total_angle(vertex), vertex) for vertex in portals]
    pointed = sorted(found for found in sharp if found[0] < 2 * np.pi - POINTED)
    return [(vertex, portals[vertex]) for _, vertex in pointed[:MAX_CONES]]


def _turned(fans: Fans, way: Way, start: int, end: int, tried: set[tuple[int, ...]]) -> Way | None:
    """Return the way led around the other side of a vertex where that is shorter, or None."""
    for vertex, portal, angle in way.bends:
        run = _run_around(fans, way.strip, vertex, portal)
        key = (vertex, *way.strip[run[0] : run[1] + 1])
        if key in tried or fans.total_angle(vertex) - angle >= np.pi - STRAIGHT:
            continue
        other = _other_side(fans, way.strip, vertex, run)
        if other is None:
            continue
        tried.add(key)
        turned = _straightened(fans, other, start, end)
        if turned.length < way.length * (1 - SHORTER):
            return turned
    return None


def _run_around(fans: Fans, strip: list[int], vertex: int, portal: int) -> tuple[int, int]:
    """Return the first and last position of the faces around a vertex, which share a portal."""
    first, last = portal, portal + 1
    while first > 0 and vertex in fans.faces[strip[first - 1]]:
        first -= 1
    while last + 1 < len(strip) and vertex in fans.faces[strip[last + 1]]:
        last += 1
    return first, last


def _other_side(
    fans: Fans, strip: list[int], vertex: int, run: tuple[int, int]
) -> list[int] | None:
    """Return the strip led around the other side of a vertex, or None if there is none."""
    first, last = run
    ring = fans.cycle(vertex, strip[first])
    if ring is None or strip[last] == strip[first]:
        return None
    if ring[1] == strip[first + 1]:  # go the other way around
        ring = [ring[0], *ring[:0:-1]]
    other = ring[: ring.index(strip[last]) + 1]
    return _without_returns(strip[:first] + other + strip[last + 1 :])


def _without_returns(strip: list[int]) -> list[int]:
    """Return a strip without the same face twice in a row, and without there-and-back."""
    kept: list[int] = []
    for face in strip:
        if kept and kept[-1] == face:
            continue
        if len(kept) > 1 and kept[-2] == face:
            kept.pop()
            continue
        kept.append(face)
    return kept


def _straightened(fans: Fans, strip: list[int], start: int, end: int) -> Way:
    strip = _trimmed(fans, strip, start, end)
    portals, places, first, last = _unfolded(fans, strip, start, end)
    corners = _funnel(places, first, last)
    knots = [
        (-1, first),
        *((portal, places[portal][side]) for portal, side in corners),
        (len(portals), last),
    ]
    crossings = _crossings(strip, portals, places, knots)
    crossings = [(strip[0], {start: 1.0}), *crossings, (strip[-1], {end: 1.0})]
    length = sum(abs(after - before) for (_, before), (_, after) in pairwise(knots))
    return Way(strip, crossings, length, _bends(portals, knots, corners))


def _trimmed(fans: Fans, strip: list[int], start: int, end: int) -> list[int]:
    """Return the strip from its last face at the start to its first face at the end after it."""
    begin = 0
    while begin + 1 < len(strip) and start in fans.faces[strip[begin + 1]]:
        begin += 1
    stop = len(strip) - 1
    while stop > begin and end in fans.faces[strip[stop - 1]]:
        stop -= 1
    return strip[begin : stop + 1]


def _unfolded(
    fans: Fans, strip: list[int], start: int, end: int
) -> tuple[list[tuple[int, int]], list[tuple[complex, complex]], complex, complex]:
    """Lay a strip out in the plane: its inner edges as (left, right), where these are, the ends."""
    flat: dict[int, complex] = {}
    a, b, c = fans.faces[strip[0]].tolist()
    flat[a], flat[b] = 0j, complex(_distance(fans, a, b))
    flat[c] = _apex(fans, flat, a, b, c)
    first = flat[start]
    portals: list[tuple[int, int]] = []
    places: list[tuple[complex, complex]] = []
    for face, following in pairwise(strip):
        own = fans.faces[face].tolist()
        shared = [corner for corner in fans.faces[following].tolist() if corner in own]
        opposite = next((corner for corner in own if corner not in shared[:2]), own[0])
        p, q = shared[0], shared[1]
        if _cross(flat[q] - flat[p], flat[opposite] - flat[p]) > 0:
            p, q = q, p  # on the way out of the face p lies to the left, and q to the right
        portals.append((p, q))
        places.append((flat[p], flat[q]))
        new = fans.third(following, p, q)
        flat = {p: flat[p], q: flat[q]}
        flat[new] = _apex(fans, flat, p, q, new)
    return portals, places, first, flat[end]


def _distance(fans: Fans, a: int, b: int) -> float:
    return float(np.linalg.norm(fans.vertices[a] - fans.vertices[b]))


def _apex(fans: Fans, flat: dict[int, complex], a: int, b: int, c: int) -> complex:
    """Return where corner c lies in the plane, on the left of the way from a to b."""
    return flat[a] + (flat[b] - flat[a]) * fans.shape(a, b, c)


def _cross(p: complex, q: complex) -> float:
    return p.real * q.imag - p.imag * q.real


def _funnel(
    places: list[tuple[complex, complex]], first: complex, last: complex
) -> list[tuple[int, int]]:
    """Return the corners of the shortest way: (portal, 0 for its left end or 1 for its right)."""
    gates = [*places, (last, last)]
    corners: list[tuple[int, int]] = []
    apex, left, right = first, first, first
    at = [0, 0]
    index = 0
    restart = -1
    while index < len(gates):
        new_left, new_right = gates[index]
        if _cross(right - apex, new_right - apex) >= 0 or right == apex:
            if apex == right or _cross(left - apex, new_right - apex) < 0 or left == apex:
                right, at[1] = new_right, index
            else:
                apex, restart = left, at[0]
                corners.append((at[0], 0))
                left = right = apex
                at = [restart, restart]
                index = restart + 1
                continue
        if _cross(left - apex, new_left - apex) <= 0 or left == apex:
            if apex == left or _cross(right - apex, new_left - apex) > 0 or right == apex:
                left, at[0] = new_left, index
            else:
                apex, restart = right, at[1]
                corners.append((at[1], 1))
                left = right = apex
                at = [restart, restart]
                index = restart + 1
                continue
        index += 1
    return [corner for corner in corners if corner[0] < len(places)]


def _crossings(
    strip: list[int],
    portals: list[tuple[int, int]],
    places: list[tuple[complex, complex]],
    knots: list[tuple[int, complex]],
) -> list[tuple[int, dict[int, float]]]:
    """Return the point of a way on each inner edge of its strip."""
    crossings = []
    for (since, p), (until, q) in pairwise(knots):
        for portal in range(since + 1, min(until + 1, len(portals))):
            a, b = places[portal]
            denominator = _cross(b - a, q - p)
            # Where the way runs along the edge it is on its way to one end: to q.
            share = _cross(p - a, q - p) / denominator if denominator else float(q != a)
            share = min(max(share, 0.0), 1.0)
            left, right = portals[portal]
            crossings.append((strip[portal], {left: 1 - share, right: share}))
    return crossings


def _bends(
    portals: list[tuple[int, int]], knots: list[tuple[int, complex]], corners: list[tuple[int, int]]
) -> list[tuple[int, int, float]]:
    """Return the vertices that a way bends around, as in `Way`."""
    bends = []
    for (_, before), (portal, at), (_, after), (_, side) in zip(
        knots, knots[1:], knots[2:], corners, strict=False
    ):
        inward, outward = before - at, after - at
        if inward == 0 or outward == 0:
            continue
        turn = cmath.phase(outward / inward) * (1 if side == 0 else -1)
        angle = turn % (2 * np.pi)
        if angle < np.pi - 1e-3:  # a taut way leaves at least π: it was a full turn more
            angle += 2 * np.pi
        bends.append((portals[portal][side], portal, angle))
    return bends
