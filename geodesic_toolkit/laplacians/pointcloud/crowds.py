"""Crowds of points: heaps, and lines whose points are closer than the lines are.

Sensors do not sample evenly. A spinning scanner writes lines that are tens of spacings apart, and
one that passes several times writes heaps. All nearest neighbours of a point then lie in one
direction, or in no direction to speak of, and no number of them is right everywhere. So crowds are
thinned, and what is left is sampled about as densely across lines as along them.

The kernels are ``native/clouds/crowds.cpp``, with the measurements behind their constants.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.threads import threads_for
from geodesic_toolkit.laplacians.pointcloud.blades import N_SAMPLES, where_blades
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_among, nearest_neighbours

__all__ = ["Representatives", "representatives", "restored"]

RELATIVE_SPACING_OF_KEPT = 0.25
"""How close kept points of a crowd may be, in reaches of it: the next line, or the next heap, is
about a reach away."""

POINTS_PER_NEIGHBOUR = 32
"""Neighbours are looked at up to the nearest one of so many points: in a cloud of some hundreds 40
neighbours are a limb. A fox of 313 points reads 6.2 % off so, and 9.1 % if all are looked at."""

MAX_ROUNDS = 12
"""Rounds of thinning at most. Lines take one for every factor of 5 by which they are farther apart
than their points, heaps one or two."""

MAX_SHARE_OF_CROWDED_IN_LAST_ROUND = 0.05
"""Share of the crowded points up to which a round may take some away and be the last one."""

MAX_SHARE_OF_ALL_IN_LAST_ROUND = 0.001
"""The same of all points: on clouds without crowds a few points are taken for crowded by chance."""

BY_CHANCE = 0.01
"""Share of points up to which they are taken for crowded by chance, and left: it is 0 to 0.9 % on
clouds that sample surfaces evenly or at random."""

SAMPLING_STEP = 8
"""One of so many points is kept to look for heaps of more points than there are neighbours."""

N_PROBES = 500
"""Points at which it is looked for them first."""

MIN_RATIO_OF_HEAPS = 6.0
"""Ratio of the distances to two neighbours among that part, one of four times the other's rank,
from which on they do not lie on one surface about a point: more than in the kernel, because a
random part has heaps of its own."""

MIN_RATIO_OF_CERTAIN_HEAPS = 25.0
"""The same ratio from which on there is a heap even if the next ones lie in one direction."""

MAX_VARIANCE_ACROSS_BANDS = 0.1
"""Share of the variance along a band that there is across it, below which it is one: a band of a
fifth of the length of the neighbourhood has 0.04, a quarter of a circle 0.03, a surface 0.5 or
more."""

MIN_SHARE_OF_LONE_POINTS = 0.25
"""Share of crowded points that stand alone from which on none is taken for crowded; a tenth does by
chance among heaps."""

NEIGHBOURS_TO_NEXT_LINE = 16
"""Neighbours among which the next line must be, of a point that is left of a line."""

MIN_SHARE_OF_PROBES = 0.05
"""Share of the probes that have to see one for all points to be asked."""

WITHIN_BLADES = (2, 4, 8, 16)
"""One of so many points is kept to look for blades that hold all neighbours of their points.
Measured on sweeps of 32 beams over slopes of 0.15 and 0.3 with noise of 2 and 3 cm, refined: errors
of 3 to 34 % become 0.003 to 0.016 % with these, 0.002 to 0.01 % with 3 and 9, and 0.006 to 3.2 %
with 4 and 16."""

N_VOTING_POINTS = 9
"""Points around one, itself included, most of which have to agree."""


@dataclass(frozen=True)
class Representatives:
    """The points of a cloud that stand for all of it.

    Attributes
    ----------
    kept : ndarray of shape (P,), int64
        Which they are, ascending.
    reaches : ndarray of shape (N,), float64
        How far the widest crowd reached that a point was in; 0 where there was none.
    neighbours : ndarray of shape (N, k), int64
        The nearest representatives of all points, themselves excluded.
    """

    kept: IntArray
    reaches: FloatArray
    neighbours: IntArray

    @cached_property
    def stands(self) -> BoolArray:
        """A mask of the points that represent themselves, of shape (N,)."""
        stands = np.zeros(len(self.reaches), dtype=np.bool_)
        stands[self.kept] = True
        return stands

    @cached_property
    def nearest(self) -> IntArray:
        """The index of the nearest representative of each point, of shape (N,)."""
        if len(self.kept) == len(self.reaches):
            return self.kept
        number = np.zeros(len(self.reaches), dtype=np.int64)
        number[self.kept] = np.arange(len(self.kept))
        own = np.arange(len(self.reaches))
        return np.asarray(number[np.where(self.stands, own, self.neighbours[:, 0])])

    @cached_property
    def own(self) -> IntArray:
        """The neighbours of the representatives, in their order, of shape (P, k)."""
        if len(self.kept) == len(self.reaches):
            return self.neighbours
        return self.nearest[self.neighbours[self.kept]]


def representatives(points: FloatArray, k: int) -> Representatives:
    """Return the points that are left when crowds are thinned, and the neighbours among them.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    k : int
        Neighbours asked for; where there are fewer representatives, one less than these.
    """
    kept = np.arange(len(points))
    reaches = np.zeros(len(points))
    if len(points) < 2:
        return Representatives(kept, reaches, np.empty((len(points), 0), dtype=np.int64))
    everywhere = near = nearest_neighbours(points, min(k, len(points) - 1))
    for _ in range(MAX_ROUNDS):
        some = points[kept]
        local = np.ascontiguousarray(near[:, : len(some) // POINTS_PER_NEIGHBOUR])
        found = _native.crowd_reaches(some, local, n_threads=threads_for(len(some)))
        found = np.maximum(found, _reaches_of_great_heaps(some, near))
        found = np.maximum(found, _reaches_of_blades(some, k))
        if np.count_nonzero(found) <= BY_CHANCE * len(some):
            break
        reaches[kept] = np.maximum(reaches[kept], found)
        stays = _native.thinned(some, near, RELATIVE_SPACING_OF_KEPT * found)
        near = _without(some, near, stays, k)
        kept = kept[stays]
        few = max(
            MAX_SHARE_OF_CROWDED_IN_LAST_ROUND * np.count_nonzero(found),
            MAX_SHARE_OF_ALL_IN_LAST_ROUND * len(points),
        )
        if np.count_nonzero(~stays) <= few:
            break
    if len(kept) < len(points):
        everywhere = nearest_among(points, kept, np.arange(len(points)), near.shape[1])
        # One that stands for a crowd can be one that was in none, and the last to be thinned knows
        # best how far it is to the next line.
        others = np.flatnonzero(reaches)
        np.maximum.at(reaches, everywhere[others, 0], reaches[others])
        gone = np.ones(len(points), dtype=np.bool_)
        gone[kept] = False
        reaches[gone] = np.maximum(reaches[gone], reaches[everywhere[gone, 0]])
    thin = Representatives(kept, reaches, everywhere)
    if not reaches.any():
        return thin
    alone = _alone(points[kept], near)[thin.nearest]
    return restored(points, thin, reaches > 0) if _are_many(alone, thin) else thin


def _alone(points: FloatArray, near: IntArray) -> BoolArray:
    """Return which (P,) points that are left have others in one direction only.

    Next to a line of a scan there is another, and what is left of both covers a surface. A narrow
    band that is sampled evenly looks like a line, too, but has no other next to it, and must not be
    thinned: on one of 3,000 points, three of their spacings wide, distances were off by twice
    their length in the mean.
    """
    if near.shape[1] < NEIGHBOURS_TO_NEXT_LINE:
        return np.ones(len(points), dtype=np.bool_)  # too few are left to tell
    nearer, farther = (
        np.linalg.norm(points[near[:, r - 1]] - points, axis=1)
        for r in (NEIGHBOURS_TO_NEXT_LINE // 4, NEIGHBOURS_TO_NEXT_LINE)
    )
    found = ~_to_all_sides(points[near[:, :NEIGHBOURS_TO_NEXT_LINE]]) & (
        farther < MIN_RATIO_OF_HEAPS * nearer
    )  # no heap
    found |= found[near[:, : N_VOTING_POINTS - 1]].any(axis=1)  # all that is about a gap
    return np.asarray(found)


def _are_many(chosen: BoolArray, thin: Representatives) -> bool:
    crowded = thin.reaches > 0
    return bool(
        np.count_nonzero(chosen & crowded) > MIN_SHARE_OF_LONE_POINTS * np.count_nonzero(crowded)
    )


def restored(points: FloatArray, thin: Representatives, again: BoolArray) -> Representatives:
    """Return the representatives with those points, (N,), that stand for themselves after all.

    If they are many of the crowded ones, these were not crowds, and all of them do: half of a band
    that is thinned is worse than all of it.
    """
    if _are_many(again, thin):
        again = again | (thin.reaches > 0)
    kept = np.flatnonzero(thin.stands | again)
    everything = np.arange(len(points))
    near = nearest_among(points, kept, everything, thin.neighbours.shape[1])
    return Representatives(kept, np.where(again, 0.0, thin.reaches), near)


def _without(points: FloatArray, near: IntArray, stays: BoolArray, k: int) -> IntArray:
    """Return the neighbours of the points that stay; most have lost none."""
    left = np.flatnonzero(stays)
    k = min(k, len(left) - 1)
    number = np.full(len(points), -1)
    number[left] = np.arange(len(left))
    result = number[near[left, :k]]
    changed = np.flatnonzero((result < 0).any(axis=1))
    result[changed] = number[nearest_among(points, left, left[changed], k)]
    return np.ascontiguousarray(result)


def _reaches_of_great_heaps(points: FloatArray, near: IntArray) -> FloatArray:
    """Return how far heaps reach that hold all neighbours of their points, 0 where there are none.

    Among an eighth of the points the neighbours reach eight times as many points far.
    """
    count, k = near.shape
    none = np.zeros(count)
    if count // SAMPLING_STEP <= k:
        return none
    part = np.sort(np.random.default_rng(0).permutation(count)[: count // SAMPLING_STEP])
    probes = np.linspace(0, count - 1, min(N_PROBES, count)).astype(np.int64)
    around = np.column_stack([np.arange(count), near[:, : N_VOTING_POINTS - 1]])
    asked = np.unique(around[probes])
    near = nearest_among(points, part, asked, k)
    seen = _in_great_heaps(points, near, asked, around[probes]) > 0
    if seen.mean() < MIN_SHARE_OF_PROBES:
        return none
    everything = np.arange(count)
    near = nearest_among(points, part, everything, k)
    return _in_great_heaps(points, near, everything, around)


def _reaches_of_blades(points: FloatArray, k: int) -> FloatArray:
    """Return how far the blades reach that hold all neighbours of their points, 0 where none are.

    What is wider than the neighbourhoods is seen among a part of the points; to estimate normals
    from more of them would not do, as stars, too, have to reach the next blade.
    """
    reaches = np.zeros(len(points))
    shuffled = np.random.default_rng(0).permutation(len(points))  # steps alias with the scanner's
    for every in WITHIN_BLADES:
        if len(points) < every * N_SAMPLES or len(points) // every <= k:
            break
        part = np.sort(shuffled[: len(points) // every])
        chosen = part[np.linspace(0, len(part) - 1, N_SAMPLES).astype(np.int64)]
        near = nearest_among(points, part, chosen, k)
        blades = where_blades(points, chosen, near)
        if blades.any():
            farthest = np.linalg.norm(points[near[:, -1]] - points[chosen], axis=1)
            asked = np.flatnonzero(blades)
            nearest = np.searchsorted(chosen, nearest_among(points, chosen, asked, 1)[:, 0])
            reaches[asked] = np.maximum(reaches[asked], farthest[nearest])
    return reaches


def _to_all_sides(groups: FloatArray) -> BoolArray:
    """Return which of K groups of points, (K, n, 3), lie in more than one direction.

    The next heaps of a surface do. A narrow band of random points is uneven from afar as heaps are,
    and goes on in one.
    """
    offsets = groups - groups.mean(axis=1, keepdims=True)
    spread = np.linalg.eigvalsh(np.einsum("kni,knj->kij", offsets, offsets))
    return np.asarray(spread[:, 1] > MAX_VARIANCE_ACROSS_BANDS * spread[:, 2])


def _in_great_heaps(
    points: FloatArray, near: IntArray, asked: IntArray, around: IntArray
) -> FloatArray:
    """Return the reaches at the first of `around`, whose neighbours and itself are all `asked`."""
    row = np.zeros(len(points), dtype=np.int64)
    row[asked] = np.arange(len(asked))
    reaches = np.zeros(len(around))
    for rank in (2, 4, 10):
        nearer, farther = (
            np.linalg.norm(points[near[:, r - 1]] - points[asked], axis=1) for r in (rank, 4 * rank)
        )
        signs = np.asarray(farther > MIN_RATIO_OF_HEAPS * nearer)
        surely = farther[signs] > MIN_RATIO_OF_CERTAIN_HEAPS * nearer[signs]
        signs[signs] = surely | _to_all_sides(points[near[signs]])
        found = np.asarray(2 * np.count_nonzero(signs[row[around]], axis=1) > N_VOTING_POINTS)
        reaches[found] = farther[row[around[found, 0]]]
    return reaches
